"""Relative elongation of hot steel, by grade.

The elongations are those of EN 1993-1-2:2005: carbon steel by clause 3.4.1.1 (equations 3.1a to 3.1c: 1.48 % at
1,050 °C, 1.58 % at 1,100 °C), austenitic steel by annex C.3.1 (2.03 % at 1,050 °C, 2.36 % at 1,200 °C). Both are
given up to 1,200 °C; above, the last equation is extrapolated. Real steels of a grade differ from it by some
hundredths of their elongation, which the uncertainty does not contain; a mill that knows its steel corrects the target.
"""

from collections.abc import Callable
from typing import NamedTuple


class Grade(NamedTuple):
    """One row of the expansion table.

    Attributes
    ----------
    name : str
    elongation : callable
        Relative elongation since 20 °C at a temperature in °C.
    """

    name: str
    elongation: Callable[[float], float]


def _carbon(temperature_c: float) -> float:
    theta = temperature_c
    if theta < 750:
        return 1.2e-5 * theta + 0.4e-8 * theta**2 - 2.416e-4
    return max(1.1e-2, 2e-5 * theta - 6.2e-3)  # level from 750 to 860 °C, where the lattice changes


def _austenitic(temperature_c: float) -> float:
    theta = temperature_c
    return (16 + 4.79e-3 * theta - 1.243e-6 * theta**2) * (theta - 20) * 1e-6


GRADES = {1: Grade("carbon and low-alloy steel", _carbon), 2: Grade("austenitic stainless steel", _austenitic)}
