"""Commands of the PLC's side: poll, registers."""

import argparse
import itertools
import sys

from appliance.cli.common import whole_number
from appliance.command_options import CommandError
from appliance.supervisor.settings import PlcSettings
from plc import export


def add_registers(command: argparse.ArgumentParser) -> None:
    command.add_argument("--format", choices=("markdown", "csv", "json", "st"), default="markdown")


def run_registers(given: argparse.Namespace) -> None:
    texts = {
        "markdown": export.to_markdown,
        "csv": export.to_csv,
        "json": export.to_json,
        "st": export.to_structured_text,
    }
    sys.stdout.write(texts[given.format]())


def add_poll(command: argparse.ArgumentParser) -> None:
    port = PlcSettings.model_fields["port"].default
    command.add_argument("host", metavar="HOST", help="name or address of the gauge")
    command.add_argument("--port", type=int, default=port, help=f"TCP port, {port} unless given")
    command.add_argument("--count", type=whole_number, help="number of polls; without: until Ctrl-C")
    command.add_argument("--word-order", choices=("big", "little"), default="big", help="as set in the gauge")


def run_poll(given: argparse.Namespace) -> None:
    from plc.poll import PollError, poll, snapshot_lines

    try:
        snapshots = poll(given.host, given.port, word_order=given.word_order)
        for snapshot in itertools.islice(snapshots, given.count):
            print("\n".join(snapshot_lines(snapshot)), end="\n\n", flush=True)
    except PollError as error:
        raise CommandError(str(error)) from error
