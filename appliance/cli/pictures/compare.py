"""The command compare."""

import argparse
from pathlib import Path

from appliance.cli.outputs import refuse_lost_input, refuse_unwritable
from appliance.command_options import CommandError

PLOT_SUFFIXES = (".png", ".svg", ".pdf")


def add_compare(command: argparse.ArgumentParser) -> None:
    command.add_argument("readings", type=Path, metavar="READINGS", help="file that measure or orient wrote")
    command.add_argument(
        "truth", type=Path, metavar="TRUTH", help="truth.json of bars, truth.csv of ingots, or the folder with it"
    )
    command.add_argument("--plot", type=Path, metavar="FILE", help="picture of it: .png, .svg or .pdf")


def run_compare(given: argparse.Namespace) -> None:
    from appliance.comparison.compare import compare

    if given.plot is not None and given.plot.suffix.lower() not in PLOT_SUFFIXES:
        raise CommandError(f"--plot: {given.plot} is no picture; let its name end in {', '.join(PLOT_SUFFIXES)}")
    if given.plot is not None:
        refuse_lost_input(given.plot, (given.readings, given.truth), option="--plot")
        refuse_unwritable(given.plot, option="--plot")
    try:
        lines = compare(given.readings, given.truth, given.plot)
    except OSError as error:
        raise CommandError(f"{error.filename or given.plot}: {error.strerror}; give a writable place") from error
    print("\n".join(lines))
