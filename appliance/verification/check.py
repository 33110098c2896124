"""Error, repeatability, drift and verdict of the gauge on a bar of known diameter. Pure arithmetic."""

import math
import statistics
from collections.abc import Sequence
from typing import Literal, NamedTuple

READINGS_ENOUGH = 10  # the standard deviation of ten readings is known to 24 % (k = 1), 1 / sqrt(2 (n - 1))
SAME_MASTER_SHARE = 0.01  # masters that differ by less are compared: errors that scale with size differ by less, too

Verdict = Literal["pass", "fail", "undecided"]


class Master(NamedTuple):
    """The bar of known size: its diameter and its expanded uncertainty (k = 2), mm."""

    diameter_mm: float
    expanded_mm: float


class Verification(NamedTuple):
    """Outcome of one verification.

    Attributes
    ----------
    master : Master
    readings : int
        Valid readings.
    missing : int
        Readings without a value.
    mean_mm : float
        Of the valid readings.
    error_mm : float
        Mean minus master.
    repeatability_mm : float
        Standard deviation of a single reading.
    test_expanded_mm : float
        U (k = 2) with which the error is known: the master's and the mean's scatter. What the gauge itself does wrong
        is the error that is looked for, and no part of it (ISO 14253-5).
    limit_mm : float
        Largest permissible error, either way.
    drift_mm : float
        Error minus that of the first earlier verification on a like master; NaN without one.
    verdict : {"pass", "fail", "undecided"}
    """

    master: Master
    readings: int
    missing: int
    mean_mm: float
    error_mm: float
    repeatability_mm: float
    test_expanded_mm: float
    limit_mm: float
    drift_mm: float
    verdict: Verdict


def verify(
    diameters_mm: Sequence[float], missing: int, master: Master, limit_mm: float, earlier: Sequence[tuple[float, float]]
) -> Verification:
    """Compare readings with a master.

    Parameters
    ----------
    diameters_mm : sequence of float
        Valid readings of the master, at least `READINGS_ENOUGH`.
    missing : int
        Readings without a value.
    master : Master
    limit_mm : float
        Largest permissible error, either way.
    earlier : sequence of (float, float)
        Master's diameter and error of each earlier verification, mm, oldest first.

    Raises
    ------
    ValueError
        Fewer readings than `READINGS_ENOUGH`, or a limit that is not positive.
    """
    if len(diameters_mm) < READINGS_ENOUGH:
        raise ValueError(f"diameters_mm: {len(diameters_mm)} readings, {READINGS_ENOUGH} are needed")
    if not limit_mm > 0:
        raise ValueError("limit_mm: not positive")
    mean_mm, repeatability_mm = statistics.fmean(diameters_mm), statistics.stdev(diameters_mm)
    error_mm = mean_mm - master.diameter_mm
    test_expanded_mm = math.hypot(master.expanded_mm, 2 * repeatability_mm / math.sqrt(len(diameters_mm)))
    alike = [error for size, error in earlier if abs(size / master.diameter_mm - 1) < SAME_MASTER_SHARE]
    return Verification(
        master,
        len(diameters_mm),
        missing,
        mean_mm,
        error_mm,
        repeatability_mm,
        test_expanded_mm,
        limit_mm,
        error_mm - alike[0] if alike else math.nan,
        verdict(error_mm, test_expanded_mm, limit_mm),
    )


def verdict(error_mm: float, test_expanded_mm: float, limit_mm: float) -> Verdict:
    """Conformity with a limit after ISO 14253-1, with the guard band g = U (k = 2) on both sides of the limit.

    Parameters
    ----------
    error_mm : float
    test_expanded_mm : float
        U of the error.
    limit_mm : float
        Largest permissible error, either way.
    """
    if abs(error_mm) <= limit_mm - test_expanded_mm:
        return "pass"
    return "fail" if abs(error_mm) >= limit_mm + test_expanded_mm else "undecided"
