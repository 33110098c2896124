"""Commands of the PLC's side: poll, registers."""

import argparse
import csv
import io
import itertools
import json
import re
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, get_args

from appliance.cli.common import whole_number
from appliance.command_options import CommandError, number_within
from appliance.diagnostics.named_bits import named_bits
from appliance.supervisor.settings import PlcSettings
from plc import export
from plc.security.addresses import check_host
from plc.structured_text.dialect import Dialect
from plc.structured_text.program import to_structured_text

if TYPE_CHECKING:
    from plc.poll import Snapshot


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
    command.add_argument("host", metavar="HOST", help="name or address of the gauge; HOST:PORT too")
    command.add_argument("--port", type=int, help=f"TCP port, {port} unless given")
    command.add_argument("--count", type=whole_number, help="number of polls; without: until Ctrl-C")
    command.add_argument(
        "--interval", type=_seconds, default=1.0, metavar="S", help="seconds between polls, without: 1"
    )
    command.add_argument("--word-order", choices=("big", "little"), default="big", help="as set in the gauge")
    command.add_argument("--all", action="store_true", help="show every value of the measurement block")
    form = command.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="a JSON object a line")
    form.add_argument("--csv", action="store_true", help="a line of comma-separated values each, with a heading")


def run_poll(given: argparse.Namespace) -> None:
    from plc.poll import PollError, poll

    host, port = _place(given.host, given.port)
    try:
        snapshots = poll(host, port, every_s=given.interval, word_order=given.word_order)
        show = _shower(given)
        for snapshot in itertools.islice(snapshots, given.count):
            if not snapshot.word_order_fits:
                other = "little" if given.word_order == "big" else "big"
                advice = f"give --word-order {other}, or check that this is a gauge"
                raise CommandError(f"{host}:{port}: the test value reads wrongly; {advice}")
            print(show(snapshot), flush=True)
    except PollError as error:
        raise CommandError(str(error)) from error


def _seconds(text: str) -> float:
    return number_within(text, 0.01, 3600, "seconds")


def _place(text: str, port: int | None) -> tuple[str, int]:
    """Host and port of HOST, HOST:PORT, [IPV6]:PORT or an IPv6 address."""
    host, inside = text, ""
    if found := re.fullmatch(r"\[(.*)\](?::(.*))?", text):
        host, inside = found[1], found[2] or ""
    elif text.count(":") == 1:
        host, _, inside = text.partition(":")
    try:
        check_host(host)
        given = int(inside) if inside else None
    except ValueError as error:
        raise CommandError(f"HOST: {text!r} is no name or address; give one, or HOST:PORT") from error
    if given is not None and port not in {None, given}:
        raise CommandError(f"HOST: {text} and --port {port} differ; give the port once")
    chosen = given or port or PlcSettings.model_fields["port"].default
    if not 1 <= chosen <= 65535:
        raise CommandError(f"--port: {chosen} is not within 1 to 65535")
    return host, chosen


def _shower(given: argparse.Namespace) -> "Callable[[Snapshot], str]":
    """How each snapshot is printed: for programs, on one screen in place, or one after the other."""
    from plc.poll import snapshot_lines, to_record

    bits = named_bits()
    if given.json:
        return lambda snapshot: json.dumps(to_record(snapshot, bits))
    if given.csv:
        return _csv_lines()
    before = "\x1b[H\x1b[J" if sys.stdout.isatty() else ""  # home, and clear to the end
    return lambda snapshot: before + "\n".join(snapshot_lines(snapshot, bits, everything=given.all)) + "\n"


def _csv_lines() -> "Callable[[Snapshot], str]":
    heading = True

    def line(snapshot: "Snapshot") -> str:
        nonlocal heading
        row = snapshot.values | {f"written_{name}": value for name, value in snapshot.set_points.items()}
        text = io.StringIO()
        writer = csv.DictWriter(text, list(row), lineterminator="\n")
        if heading:
            writer.writeheader()
        heading = False
        writer.writerow(row)
        return text.getvalue().rstrip("\n")

    return line
