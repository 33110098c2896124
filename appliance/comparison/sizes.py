"""Diameters held against the truth: error, its bias and spread, how far U covers it, how many frames got a value."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from appliance.comparison.files import SizeTruth

Array = NDArray[np.float64]

WRONG_MM = 1.0  # a wrong value is off by more than this and by more than 2 U
NORMAL_95_PERCENT = 1.959964  # quantile of the normal distribution for two-sided intervals of 95 %


@dataclass(frozen=True, slots=True, eq=False)
class Sizes:
    """Readings and truth of frames that both have, n frames.

    Attributes
    ----------
    frame : ndarray of int64, shape (n,)
    truth_mm : ndarray of float64, shape (n,)
        NaN where no bar can be measured.
    diameter_mm, expanded_mm, virtual_board_mm : ndarray of float64, shape (n,)
        Diameter, its U (k = 2), and the diameter by virtual boards beside it; NaN without a value.
    """

    frame: NDArray[np.int64]
    truth_mm: Array
    diameter_mm: Array
    expanded_mm: Array
    virtual_board_mm: Array

    @classmethod
    def of(cls, rows: Sequence[dict[str, Any]], truth: SizeTruth) -> "Sizes":
        """Pair rows of `measure` with the truth, by frame.

        Parameters
        ----------
        rows : sequence of dict
            Rows without a `frame`, or of a frame that the truth lacks, are left out.
        truth : dict of int to float or None
        """
        both = [row for row in rows if row.get("frame") in truth]
        valid = [bool(row.get("valid", True)) for row in both]

        def column(name: str) -> Array:
            numbers = [row.get(name) if there else None for row, there in zip(both, valid, strict=True)]
            return np.array([math.nan if number is None else number for number in numbers], dtype=np.float64)

        frames = [int(row["frame"]) for row in both]
        true = [truth[frame] for frame in frames]
        return cls(
            np.array(frames, dtype=np.int64),
            np.array([math.nan if one is None else one for one in true], dtype=np.float64),
            column("diameter_mm"),
            column("expanded_uncertainty_mm"),
            column("diameter_virtual_board_mm"),
        )

    @property
    def error_mm(self) -> Array:
        """Diameter less truth, NaN where one of them is missing."""
        return self.diameter_mm - self.truth_mm


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors of one diameter, mm; NaN where there are too few.

    Attributes
    ----------
    values : int
        Frames with a measurable bar and a value.
    bias_mm, bias_error_mm : float
        Mean error, and its standard error as if frames were independent.
    rmse_mm, worst_mm : float
        Root mean square error; the largest error, with its sign.
    worst_frame : int or None
    """

    values: int
    bias_mm: float
    bias_error_mm: float
    rmse_mm: float
    worst_mm: float
    worst_frame: int | None


@dataclass(frozen=True, slots=True)
class Comparison:
    """What the comparison of a recording says.

    Attributes
    ----------
    measurable, empty : int
        Frames with a bar that can be measured, and without.
    errors, virtual_board_errors : Errors
    values_without_bar : int
        Values in frames without a bar that can be measured.
    covered, stated : int
        Values with |error| <= U, and values with a U.
    mean_expanded_mm : float
    wrong : int
        Values with |error| > max(2 U, 1 mm).
    """

    measurable: int
    empty: int
    errors: Errors
    virtual_board_errors: Errors
    values_without_bar: int
    covered: int
    stated: int
    mean_expanded_mm: float
    wrong: int

    @property
    def availability(self) -> float:
        """Share of the frames with a measurable bar that got a value; NaN without any."""
        return self.errors.values / self.measurable if self.measurable else math.nan

    @property
    def coverage(self) -> float:
        """Share of the values with a U whose error is within it; NaN without any."""
        return self.covered / self.stated if self.stated else math.nan


def compared(sizes: Sizes) -> Comparison:
    """Compare readings with their truth."""
    there = np.isfinite(sizes.truth_mm)
    error = sizes.error_mm
    stated = np.isfinite(error) & np.isfinite(sizes.expanded_mm)
    expanded = sizes.expanded_mm[stated]
    off = np.abs(error[stated])
    without_u = np.isfinite(error) & ~stated
    wrong = int((off > np.maximum(2 * expanded, WRONG_MM)).sum() + (np.abs(error[without_u]) > WRONG_MM).sum())
    return Comparison(
        measurable=int(there.sum()),
        empty=int((~there).sum()),
        errors=_errors(error, sizes.frame),
        virtual_board_errors=_errors(sizes.virtual_board_mm - sizes.truth_mm, sizes.frame),
        values_without_bar=int((np.isfinite(sizes.diameter_mm) & ~there).sum()),
        covered=int((off <= expanded).sum()),
        stated=int(stated.sum()),
        mean_expanded_mm=float(expanded.mean()) if expanded.size else math.nan,
        wrong=wrong,
    )


def _errors(error_mm: Array, frame: NDArray[np.int64]) -> Errors:
    found = np.isfinite(error_mm)
    error, count = error_mm[found], int(found.sum())
    if not count:
        return Errors(0, math.nan, math.nan, math.nan, math.nan, None)
    worst = int(np.abs(error).argmax())
    spread = float(error.std(ddof=1)) / math.sqrt(count) if count > 1 else math.nan
    return Errors(
        count,
        float(error.mean()),
        spread,
        float(np.sqrt(np.mean(error**2))),
        float(error[worst]),
        int(frame[found][worst]),
    )


def share_interval(part: int, whole: int) -> tuple[float, float]:
    """Wilson's interval of 95 % for a share (doi:10.1080/01621459.1927.10502953); NaN without any.

    Parameters
    ----------
    part, whole : int
    """
    if not whole:
        return math.nan, math.nan
    z2 = NORMAL_95_PERCENT**2
    share = part / whole
    middle = (share + z2 / (2 * whole)) / (1 + z2 / whole)
    half = NORMAL_95_PERCENT / (1 + z2 / whole) * math.sqrt(share * (1 - share) / whole + z2 / (4 * whole**2))
    return middle - half, middle + half


def size_lines(found: Comparison) -> list[str]:
    """Table of a comparison, for people."""
    both = found.errors, found.virtual_board_errors
    table = (
        ("", "diameter", "virtual board"),
        ("bias, mm", *(_millimetres(one.bias_mm, "+.3f") for one in both)),
        ("its error, mm", *(_millimetres(one.bias_error_mm, ".3f") for one in both)),
        ("RMSE, mm", *(_millimetres(one.rmse_mm, ".3f") for one in both)),
        ("worst, mm", *(_millimetres(one.worst_mm, "+.3f") for one in both)),
        ("in frame", *("-" if one.worst_frame is None else str(one.worst_frame) for one in both)),
    )
    got = (
        f"{found.errors.values} of {found.measurable} got a value, and {found.values_without_bar} values without a bar"
    )
    return [
        f"frames          {found.measurable} with a measurable bar, {found.empty} without",
        f"availability    {_percent(found.availability)} ({got})",
        *(f"{name:16}{first:>12}{second:>16}" for name, first, second in table),
        f"error within U  {_coverage(found)}",
        f"wrong values    {found.wrong} (off by more than 2 U and {WRONG_MM:g} mm)",
    ]


def _coverage(found: Comparison) -> str:
    if not found.stated:
        return "no value states a U"
    low, high = (100 * share for share in share_interval(found.covered, found.stated))
    counts = f"{found.covered} of {found.stated}; 95 % interval {low:.0f} to {high:.0f} %"
    return f"{_percent(found.coverage)} ({counts}), mean U {found.mean_expanded_mm:.3f} mm"


def _percent(share: float) -> str:
    return "-" if math.isnan(share) else f"{100 * share:.1f} %"


def _millimetres(value: float, form: str) -> str:
    return "-" if math.isnan(value) else format(value, form)
