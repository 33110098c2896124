"""The checkerboard that the rig is calibrated with."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from vision.calibration.json_fields import Fields
from vision.calibration.rig import read_response_name
from vision.light import NamedResponse


@dataclass(frozen=True, eq=False)
class Board:
    """A checkerboard, and the two heights at which it lay flat on the conveyor.

    Attributes
    ----------
    squares : tuple of int
        (along the long side, along the short side), at least 4 and 3.
    square_mm : float
        Side of a square.
    low_mm, high_mm : float
        Heights of its face over the conveyor plane z = 0 in the registration pictures.
    square_u_mm : float
        Standard uncertainty of `square_mm`, common to all squares.
    height_u_mm : float
        Standard uncertainty of each height.
    response : str or None
        How pixel values follow from light in the pictures, where the user knows it; else they are measured for it.

    Raises
    ------
    ValueError
        A number is not finite or not positive, there are too few squares, the first of `squares` is not the larger,
        or `high_mm` is not above `low_mm`.
    """

    squares: tuple[int, int]
    square_mm: float
    low_mm: float
    high_mm: float
    square_u_mm: float
    height_u_mm: float
    response: NamedResponse | None = None

    def __post_init__(self) -> None:
        columns, rows = self.squares
        if rows < 3 or columns < 4 or rows >= columns:
            raise ValueError(f"squares: at least 4 x 3, long side first, are needed, not {columns} x {rows}")
        if not (math.isfinite(self.square_mm) and self.square_mm > 0.0):
            raise ValueError(f"square_mm: a number above zero is needed, not {self.square_mm:g}")
        if not (math.isfinite(self.low_mm) and math.isfinite(self.high_mm) and self.high_mm > self.low_mm):
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
    def half_turn_shows(self) -> bool:
        """Whether the colours tell the board from itself turned by 180 degrees: one side even, the other odd."""
        return sum(self.squares) % 2 == 1

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
            JSON object with the keys `squares`, `square_mm`, `square_u_mm`, `low_mm`, `high_mm`, `height_u_mm`
            and, where it is known, `response`.

        Returns
        -------
        Board

        Raises
        ------
        ValueError
            One sentence naming the key that is missing or wrong.
        """
        fields = Fields.of_text(text)
        return cls(
            squares=fields.pair_of_counts("squares"),
            square_mm=fields.number("square_mm"),
            low_mm=fields.number("low_mm"),
            high_mm=fields.number("high_mm"),
            square_u_mm=fields.number("square_u_mm"),
            height_u_mm=fields.number("height_u_mm"),
            response=read_response_name(fields) if "response" in fields else None,
        )
