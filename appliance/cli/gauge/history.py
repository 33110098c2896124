"""Commands that read the history: export, report."""

import argparse
from datetime import datetime
from pathlib import Path

from appliance.cli.common import add_config
from appliance.command_options import CommandError, number_within, one_of
from appliance.history.export import write_csv, write_parquet
from appliance.history.read import moment, open_to_read
from appliance.history.tables import TABLES
from appliance.service.install import CONFIG
from appliance.supervisor import settings as settings_file

BY_NAME = {table.name.replace("_", "-"): table for table in TABLES}


def add_period(command: argparse.ArgumentParser) -> None:
    words = "ISO 8601, as 2026-11-28T22:00 in local time or 2026-11-28T21:00Z"
    command.add_argument("--from", dest="start", required=True, metavar="T", help=f"first moment; {words}")
    command.add_argument("--to", dest="end", required=True, metavar="T", help="moment after the last")
    command.add_argument("--output", type=Path, required=True, metavar="FILE")
    add_config(command)


def add_export(command: argparse.ArgumentParser) -> None:
    command.add_argument("--what", required=True, metavar="TABLE", help=", ".join(BY_NAME))
    add_period(command)


def run_export(given: argparse.Namespace) -> None:
    table = BY_NAME[one_of(tuple(BY_NAME), given.what, "--what")]
    writers = {".csv": write_csv, ".parquet": write_parquet}
    suffix = given.output.suffix.lower()
    if suffix not in writers:
        raise CommandError(f"--output {given.output}: give a name that ends in .csv or .parquet")
    start, end = period(given)
    with open_to_read(folder(given)) as history:
        try:
            written = writers[suffix](table, history.rows(table, start, end), given.output)
        except OSError as error:
            raise CommandError(f"{given.output}: {error.strerror}; give a place in a writable folder") from error
    print(f"{given.output}: {written} rows of {given.what}")


def add_report(command: argparse.ArgumentParser) -> None:
    add_period(command)
    command.add_argument(
        "--shift-hours", type=_hours, default=8.0, metavar="H", help="length of a shift; 8 if not given"
    )


def run_report(given: argparse.Namespace) -> None:
    from appliance.reports.shift import shifts
    from appliance.reports.write import write_report

    if given.output.suffix.lower() not in {".html", ".pdf"}:
        raise CommandError(f"--output {given.output}: give a name that ends in .html or .pdf")
    start, end = period(given)
    with open_to_read(folder(given)) as history:
        try:
            written = write_report(shifts(history, start, end, given.shift_hours), given.output)
        except OSError as error:
            raise CommandError(f"{given.output}: {error.strerror}; give a place in a writable folder") from error
    print(f"{given.output}: {written} shifts")


def _hours(text: str) -> float:
    return number_within(text, 0.1, 24 * 366, "hours")


def period(given: argparse.Namespace) -> tuple[datetime, datetime]:
    """First moment and moment after the last; raises `CommandError`."""
    start, end = (_moment(text, option) for text, option in ((given.start, "--from"), (given.end, "--to")))
    if not start < end:
        raise CommandError(f"--to {given.end}: not after --from {given.start}; give a later moment")
    return start, end


def _moment(text: str, option: str) -> datetime:
    try:
        return moment(text)
    except ValueError as error:
        raise CommandError(f"{option} {text}: no moment; write it as 2026-11-28T22:00") from error


def folder(given: argparse.Namespace) -> Path:
    """The folder of the history, from the settings that were given, else from those of the installed service."""
    installed = Path("/") / CONFIG
    config = given.config or (installed if installed.is_file() else None)
    directory = settings_file.load(config).history.directory
    if directory is None:
        raise CommandError(f"{config or 'the defaults'}: history.directory is not set; give --config FILE that sets it")
    return directory
