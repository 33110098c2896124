"""The command reproduce."""

import argparse
from pathlib import Path

from appliance.cli.common import positive_number, progress


def add_reproduce(command: argparse.ArgumentParser) -> None:
    command.add_argument("--output", type=Path, required=True, metavar="DIR", help="folder of results and report")
    command.add_argument("--quick", action="store_true", help="a few cases of each experiment, some minutes")
    command.add_argument("--recordings", type=Path, metavar="DIR", help="recordings with truth, to be judged as well")
    command.add_argument("--processes", type=positive_number, default=2, metavar="N", help="at once, 2 unless given")


def run_reproduce(given: argparse.Namespace) -> None:
    from appliance.reproduction.run import reproduce

    with progress("case") as show:
        report = reproduce(
            given.output,
            quick=given.quick,
            recordings=given.recordings,
            processes=given.processes,
            on_progress=show,
        )
    print(f"{report}: the report; interrupted, the same command goes on where it was")
