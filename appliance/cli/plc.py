"""Commands of the PLC's side: poll, registers."""

import argparse
import itertools
import sys
from collections.abc import Callable
from typing import get_args

from appliance.cli.common import whole_number
from appliance.command_options import CommandError
from appliance.diagnostics.named_bits import named_bits
from appliance.supervisor.settings import PlcSettings
from plc import export
from plc.structured_text.dialect import Dialect
from plc.structured_text.program import to_structured_text


def add_registers(command: argparse.ArgumentParser) -> None:
    command.add_argument("--format", choices=("markdown", "csv", "json", "st"), default="markdown")
    command.add_argument("--bom", action="store_true", help="begin csv with the mark by which Excel knows UTF-8")
    command.add_argument("--plc", choices=get_args(Dialect), help="kind of PLC for st; codesys unless given")


def run_registers(given: argparse.Namespace) -> None:
    if given.bom and given.format != "csv":
        raise CommandError("--bom: only csv has one; give --format csv")
    if given.plc and given.format != "st":
        raise CommandError("--plc: only st differs by PLC; give --format st")
    bits = named_bits()
    texts: dict[str, Callable[[], str]] = {
        "markdown": lambda: export.to_markdown(bits),
        "csv": lambda: export.to_csv(bits, byte_order_mark=given.bom),
        "json": lambda: export.to_json(bits),
        "st": lambda: to_structured_text(bits, dialect=given.plc or "codesys"),
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
