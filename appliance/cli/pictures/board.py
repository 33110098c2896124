"""The command board."""

import argparse
import re
from pathlib import Path

from appliance.command_options import CommandError


def add_board(command: argparse.ArgumentParser) -> None:
    command.add_argument("--squares", type=squares, default=(8, 5), metavar="8x5", help="squares along both sides")
    command.add_argument("--mm", type=float, default=50.0, metavar="MM", help="side of a square; 50 unless given")
    command.add_argument(
        "--output", type=Path, metavar="FILE.pdf", help="without: board-8x5-50mm.pdf in this folder, or as it is sized"
    )


def squares(text: str) -> tuple[int, int]:
    """Squares along the long and the short side, from `8x5`."""
    numbers = re.fullmatch(r"(\d{1,4})\s*[xX×,]\s*(\d{1,4})", text.strip())
    if numbers is None:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of squares; give it as 8x5")
    short, long = sorted(map(int, numbers.groups()))
    return long, short


def run_board(given: argparse.Namespace) -> None:
    from appliance.capture.boards.sheet import sheet_of, write_board

    sheet = sheet_of(given.squares, given.mm)
    long, short = sheet.squares
    output = given.output or Path(f"board-{long}x{short}-{given.mm:g}mm.pdf")
    if output.suffix.lower() != ".pdf":
        raise CommandError(f"--output {output}: give a name that ends in .pdf")
    try:
        write_board(sheet, output)
    except OSError as error:
        raise CommandError(f"{output}: {error.strerror}; give a place in a writable folder") from error
    paper = f"{sheet.paper}, " if sheet.paper else ""
    along, down = sheet.rulers_mm
    lines = [
        f"{output}: {long} x {short} squares of {given.mm:g} mm on {paper}{sheet.width_mm:g} x {sheet.height_mm:g} mm",
        "  print it at 100 %, not fitted to the page, and glue it on something flat",
        f"  its rulers must measure {along} and {down} mm; if not, give what a square measures as --mm",
    ]
    if (long + short) % 2 == 0:
        lines.append("  turned by half it looks the same; boards such as 8x5 or 9x6 tell their two ends apart")
    lines.append(f"  next: hotgauge capture boards --output rig_folder --squares {long}x{short} --mm {given.mm:g}")
    print("\n".join(lines))
