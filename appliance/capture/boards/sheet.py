"""`hotgauge board`: a checkerboard to print, at its true size, with rulers that show whether the printer kept it."""

import importlib.resources
from pathlib import Path
from typing import NamedTuple

from appliance.command_options import CommandError
from appliance.reports.pages import render, write_pages

SHEETS_MM = {  # ISO 216, long side first
    "A4": (297.0, 210.0),
    "A3": (420.0, 297.0),
    "A2": (594.0, 420.0),
    "A1": (841.0, 594.0),
    "A0": (1189.0, 841.0),
}
UNPRINTED_MM = 5.0  # that printers leave white along the paper's edges
RULER_MM = 12.0  # strip of a ruler, outside the white margin
RULER_STEP_MM = 10
LARGEST_MM = 5000.0  # a PDF's page has at most 14,400 points
LEAST_MM, MOST_MM = 2.0, 1000.0  # of a square
LEAST_SQUARES, MOST_SQUARES = 3, 100


class Sheet(NamedTuple):
    """A board on paper, mm.

    Attributes
    ----------
    squares : tuple of int
        Along the long and the short side.
    square_mm : float
    paper : str
        Name of the ISO format; empty for a sheet of its own size.
    width_mm, height_mm : float
        Of the paper.
    """

    squares: tuple[int, int]
    square_mm: float
    paper: str
    width_mm: float
    height_mm: float

    @property
    def left_mm(self) -> float:
        """From the paper's left edge to the pattern."""
        return (self.width_mm - self.squares[0] * self.square_mm) / 2

    @property
    def top_mm(self) -> float:
        """From the paper's upper edge to the pattern."""
        return (self.height_mm - self.squares[1] * self.square_mm) / 2

    @property
    def rulers_mm(self) -> tuple[int, int]:
        """Lengths of the rulers along the long and the short side: whole steps, not longer than the pattern."""
        along, down = (int(count * self.square_mm) // RULER_STEP_MM * RULER_STEP_MM for count in self.squares)
        return along, down


def sheet_of(squares: tuple[int, int], square_mm: float) -> Sheet:
    """Place a board on the smallest paper that holds it with its white margin of one square and its rulers.

    Parameters
    ----------
    squares : tuple of int
        Along both sides, in any order.
    square_mm : float
        Side of a square.

    Raises
    ------
    CommandError
        Too few or too many squares, or a size that cannot be printed.
    """
    short, long = sorted(squares)
    if not (short >= LEAST_SQUARES and LEAST_SQUARES < long <= MOST_SQUARES):
        raise CommandError(
            f"--squares {squares[0]}x{squares[1]}: give {LEAST_SQUARES} to {MOST_SQUARES} squares along a side, at "
            f"least {LEAST_SQUARES + 1} along one of them, such as 8x5"
        )
    if not LEAST_MM <= square_mm <= MOST_MM:
        raise CommandError(f"--mm {square_mm:g}: give the side of a square, {LEAST_MM:g} to {MOST_MM:g} mm")
    around_mm = 2 * max(square_mm, RULER_MM) + 2 * UNPRINTED_MM
    if square_mm < 2 * RULER_MM:  # the ruler needs more than the white margin has
        around_mm += 2 * RULER_MM
    width_mm, height_mm = long * square_mm + around_mm, short * square_mm + around_mm
    for paper, (paper_width_mm, paper_height_mm) in SHEETS_MM.items():
        if width_mm <= paper_width_mm and height_mm <= paper_height_mm:
            return Sheet((long, short), square_mm, paper, paper_width_mm, paper_height_mm)
    if width_mm > LARGEST_MM:
        raise CommandError(f"--mm {square_mm:g}: the sheet would be {width_mm:.0f} mm wide; at most {LARGEST_MM:g} fit")
    return Sheet((long, short), square_mm, "", width_mm, height_mm)


def write_board(sheet: Sheet, output: Path) -> None:
    """Write the PDF; raises `OSError` and `ReportMissingError`.

    Parameters
    ----------
    sheet : Sheet
    output : Path
    """
    text = importlib.resources.files("appliance.capture.boards").joinpath("board.html").read_text(encoding="utf-8")
    values = {"sheet": sheet, "unprinted": UNPRINTED_MM, "ruler": RULER_MM, "step": RULER_STEP_MM}
    write_pages(render(text, output, values), output)
