"""The checkerboard that the rig is calibrated with."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from vision.calibration.json_fields import Fields
from vision.calibration.rig import read_response_name
from vision.light import NamedResponse

MOST_SQUARES = 100  # along a side; chosen: a square is then less than 40 pixels of the widest industrial picture
# Standard uncertainty of an unmeasured print: printers scale by up to 0.5 %, evenly distributed (GUM, 4.3.7)
UNTOLD_SQUARE_RELATIVE_U = 0.003
UNTOLD_HEIGHT_U_MM = 0.5  # chosen: a board on rollers, its height taken with a rule
BOARD_KEYS = ("squares", "square_mm", "square_u_mm", "low_mm", "high_mm", "height_u_mm", "response")


class Assumption(NamedTuple):
    """What was left out of a board's description and is assumed.

    Attributes
    ----------
    text : str
        A sentence.
    of_world : bool
        Whether it matters to the world frame alone, and to nothing where there is none.
    """

    text: str
    of_world: bool = False


@dataclass(frozen=True, eq=False)
class Board:
    """A checkerboard, and the two heights at which it lay flat on the conveyor.

    Attributes
    ----------
    squares : tuple of int
        (along the long side, along the short side), at least 4 and 3; the sides may be equal.
    square_mm : float
        Side of a square.
    low_mm, high_mm : float or None
        Heights of its face over the conveyor plane z = 0 in the registration pictures; None where they are not known.
    square_u_mm : float
        Standard uncertainty of `square_mm`, common to all squares.
    height_u_mm : float
        Standard uncertainty of each height.
    response : str or None
        How pixel values follow from light in the pictures, where the user knows it; else they are measured for it.
    assumptions : tuple of Assumption
        What was left out and is assumed.

    Raises
    ------
    ValueError
        A number is not finite or not positive, there are too few squares or more than `MOST_SQUARES`, the first of
        `squares` is the smaller, or `high_mm` is not above `low_mm`.
    """

    squares: tuple[int, int]
    square_mm: float
    low_mm: float | None
    high_mm: float | None
    square_u_mm: float
    height_u_mm: float
    response: NamedResponse | None = None
    assumptions: tuple[Assumption, ...] = ()

    def __post_init__(self) -> None:
        columns, rows = self.squares
        if not (3 <= rows <= columns <= MOST_SQUARES and columns >= 4):
            sizes = f"4 x 3 to {MOST_SQUARES} x {MOST_SQUARES}"
            raise ValueError(f"squares: {sizes}, long side first, are needed, not {columns} x {rows}")
        if not (math.isfinite(self.square_mm) and self.square_mm > 0.0):
            raise ValueError(f"square_mm: a number above zero is needed, not {self.square_mm:g}")
        for key, value in (("low_mm", self.low_mm), ("high_mm", self.high_mm)):
            if value is not None and not math.isfinite(value):
                raise ValueError(f"{key}: a finite number is needed, not {value:g}")
        if self.low_mm is not None and self.high_mm is not None and self.high_mm <= self.low_mm:
            raise ValueError(f"high_mm: must be above low_mm, not {self.high_mm:g} over {self.low_mm:g}")
        for key, value in (("square_u_mm", self.square_u_mm), ("height_u_mm", self.height_u_mm)):
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{key}: a number not below zero is needed, not {value:g}")

    @property
    def inner_corners(self) -> tuple[int, int]:
        """(along the long side, along the short side): where four squares meet."""
        return self.squares[0] - 1, self.squares[1] - 1

    @property
    def square_relative_u(self) -> float:
        """Relative standard uncertainty of all lengths that follow from the board."""
        return self.square_u_mm / self.square_mm

    @property
    def grid_turns(self) -> tuple[int, ...]:
        """Quarter turns about its normal that put the grid of corners on itself, colours aside."""
        return (0, 1, 2, 3) if self.squares[0] == self.squares[1] else (0, 2)

    @property
    def hidden_turns(self) -> tuple[int, ...]:
        """Quarter turns that the colours do not show either.

        Half a turn shows where one side is even and the other odd; a quarter on equal sides shows where they are even.
        """
        if sum(self.squares) % 2:
            return (0,)
        return self.grid_turns if self.squares[0] % 2 else (0, 2)

    def turned(self, corners_px: NDArray[np.float64], quarter_turns: int) -> NDArray[np.float64]:
        """Corners in the order that they have after quarter turns of the board, of `grid_turns`.

        Parameters
        ----------
        corners_px : ndarray of float64, shape (n, 2)
            In the order of `corners_mm`.
        quarter_turns : int
            Clockwise as its face is looked at.
        """
        columns, rows = self.inner_corners
        return np.rot90(corners_px.reshape(rows, columns, 2), quarter_turns).reshape(-1, 2).copy()

    @cached_property
    def corners_mm(self) -> NDArray[np.float64]:
        """Inner corners on the board, shape (n, 3), mm: x along the long side, z = 0, origin at the board's centre.

        Row by row along the long side; the first corner is the one at -x, +y.
        """
        columns, rows = self.inner_corners
        y, x = np.mgrid[(rows - 1) / 2.0 : -rows / 2.0 : -1.0, -(columns - 1) / 2.0 : columns / 2.0]
        return self.square_mm * np.column_stack([x.ravel(), y.ravel(), np.zeros(columns * rows)])

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read the text of a `board.json`.

        Parameters
        ----------
        text : str
            JSON object with the keys `squares` and `square_mm`, and where they are known `square_u_mm`, `low_mm`,
            `high_mm`, `height_u_mm` and `response`.

        Returns
        -------
        Board

        Raises
        ------
        ValueError
            One sentence naming the key that is missing, wrong or unknown.
        """
        fields = Fields.of_text(text)
        fields.refuse_others(BOARD_KEYS)
        long, short = sorted(fields.pair_of_counts("squares"), reverse=True)
        square_mm = fields.number("square_mm")
        square_u_mm, height_u_mm = fields.number_or_none("square_u_mm"), fields.number_or_none("height_u_mm")
        assumed: list[Assumption] = []
        if square_u_mm is None:
            square_u_mm = UNTOLD_SQUARE_RELATIVE_U * abs(square_mm)
            sentence = (
                f"square_u_mm is not given: every length is uncertain by {100 * UNTOLD_SQUARE_RELATIVE_U:g} %, as of "
                "a print that nobody has measured; measure the board and give it"
            )
            assumed.append(Assumption(sentence))
        if height_u_mm is None:
            height_u_mm = UNTOLD_HEIGHT_U_MM
            sentence = f"height_u_mm is not given: {height_u_mm:g} mm is assumed for each height of the board"
            assumed.append(Assumption(sentence, of_world=True))
        return cls(
            squares=(long, short),
            square_mm=square_mm,
            low_mm=fields.number_or_none("low_mm"),
            high_mm=fields.number_or_none("high_mm"),
            square_u_mm=square_u_mm,
            height_u_mm=height_u_mm,
            response=read_response_name(fields) if "response" in fields else None,
            assumptions=tuple(assumed),
        )
