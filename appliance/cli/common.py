"""Options and the progress bar that several commands share."""

import argparse
import contextlib
import logging
import math
from collections.abc import Callable, Generator, Sequence
from pathlib import Path

from appliance.command_options import CommandError

MOST_DIGITS = 18  # of a number that counts something


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


def refuse_no_region(region: Sequence[float]) -> None:
    """Raise `CommandError` unless `--region` names a finite length, its smaller end first."""
    first_mm, last_mm = region
    if not -math.inf < first_mm < last_mm < math.inf:
        raise CommandError(f"--region: from {first_mm:g} to {last_mm:g} is no region; give the smaller number first")


def positive_number(text: str) -> int:
    return _whole(text, 1)


def whole_number(text: str) -> int:
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= MOST_DIGITS and int(text) >= least):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number from {least}")
    return int(text)
