"""Options and the progress bar that several commands share."""

import argparse
import contextlib
from collections.abc import Callable, Generator
from pathlib import Path


def add_config(command: argparse.ArgumentParser) -> None:
    command.add_argument("--config", type=Path, metavar="FILE", help="settings in TOML; without: the defaults")


@contextlib.contextmanager
def progress(unit: str) -> Generator[Callable[[int, int], None]]:
    """Show a progress bar on a terminal, nothing on a pipe; the function yielded takes steps done and steps in all."""
    from tqdm import tqdm

    with tqdm(unit=unit, disable=None) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield show


def positive_number(text: str) -> int:
    number = int(text)
    if number < 1:
        raise ValueError
    return number


def whole_number(text: str) -> int:
    number = int(text)
    if number < 0:
        raise ValueError
    return number
