"""What several commands share."""

import argparse
import contextlib
import difflib
from collections.abc import Callable, Generator, Sequence
from pathlib import Path
from typing import TypeVar

_Name = TypeVar("_Name", bound=str)


class CommandError(Exception):
    """The command cannot do what it was asked for; the message says what, where and what to do."""


def add_config(command: argparse.ArgumentParser) -> None:
    command.add_argument("--config", type=Path, metavar="FILE", help="settings in TOML; without: the defaults")


def one_of(known: Sequence[_Name], name: str, option: str) -> _Name:
    for one in known:
        if name == one:
            return one
    near = difflib.get_close_matches(name, known, n=1)
    advice = f"did you mean {near[0]}?" if near else "there are " + ", ".join(known)
    raise CommandError(f"{option}: there is no {name}; {advice}")


@contextlib.contextmanager
def progress(unit: str) -> Generator[Callable[[int, int], None]]:
    """A progress bar on a terminal, nothing on a pipe; gets how many are done, of how many."""
    from tqdm import tqdm

    with tqdm(unit=unit, disable=None) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield show


def whole_number(text: str) -> int:
    number = int(text)
    if number < 0:
        raise ValueError
    return number
