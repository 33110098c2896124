"""Options and the progress bar that several commands share."""

import argparse
import contextlib
import logging
from collections.abc import Callable, Generator
from pathlib import Path


def add_config(command: argparse.ArgumentParser) -> None:
    command.add_argument("--config", type=Path, metavar="FILE", help="settings in TOML; without: the defaults")


@contextlib.contextmanager
def progress(unit: str) -> Generator[Callable[[int, int], None]]:
    """Show a progress bar on a terminal, unless --quiet was given; the function yielded takes steps done and of all."""
    from tqdm import tqdm

    quiet = logging.getLogger("hotgauge").level > logging.INFO
    with tqdm(unit=unit, disable=quiet or None) as bar:

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
