"""Capability of the process against a tolerance: Cp and Cpk within subgroups, Pp and Ppk overall, with confidence.

The spread is that of the measured bars, of which the gauge's own scatter is a part: the indices are rather too small.
"""

import importlib
import math
import statistics
from collections.abc import Sequence
from typing import Any, NamedTuple

from appliance.reports.control_chart import MEAN_RANGE_D2, RANGE_DEVIATION_D3, subgroups

CONFIDENCE = 0.95


class Index(NamedTuple):
    """A capability index and its two-sided interval of 95 % confidence."""

    value: float
    low: float
    high: float


class Capability(NamedTuple):
    """Capability of bars of one target.

    Attributes
    ----------
    bars : int
    mean_mm : float
        Of the deviations from the target.
    within_mm : float
        Standard deviation within subgroups, mean range / d2.
    overall_mm : float
        Standard deviation of all, with n - 1.
    cp, cpk : Index
        With the deviation within subgroups: what the process does while nothing drifts.
    pp, ppk : Index
        With the overall one: what was delivered.
    """

    bars: int
    mean_mm: float
    within_mm: float
    overall_mm: float
    cp: Index
    cpk: Index
    pp: Index
    ppk: Index


def capability(deviations_mm: Sequence[float], plus_mm: float, minus_mm: float) -> Capability | None:
    """Capability of consecutive bars of one target.

    Parameters
    ----------
    deviations_mm : sequence of float
        Of each bar from the target, in the order of time.
    plus_mm, minus_mm : float
        Tolerance above and below the target, both positive.

    Returns
    -------
    Capability or None
        None for fewer than two subgroups of five, or without any spread.
    """
    groups = subgroups(deviations_mm)
    if len(groups) < 2:
        return None
    mean_mm, overall_mm = statistics.fmean(deviations_mm), statistics.stdev(deviations_mm)
    within_mm = statistics.fmean(max(group) - min(group) for group in groups) / MEAN_RANGE_D2
    if not within_mm > 0:
        return None
    # u(mean range) / mean range = d3 / (d2 sqrt k), as of a standard deviation with this many degrees of freedom
    freedom_within = len(groups) * MEAN_RANGE_D2**2 / (2 * RANGE_DEVIATION_D3**2)
    near_mm = min(plus_mm - mean_mm, mean_mm + minus_mm)
    count, width_mm = len(deviations_mm), plus_mm + minus_mm
    return Capability(
        count,
        mean_mm,
        within_mm,
        overall_mm,
        centred_interval(width_mm / (6 * within_mm), freedom_within),
        nearest_interval(near_mm / (3 * within_mm), count, freedom_within),
        centred_interval(width_mm / (6 * overall_mm), count - 1),
        nearest_interval(near_mm / (3 * overall_mm), count, count - 1),
    )


def centred_interval(value: float, freedom: float) -> Index:
    """Cp or Pp with its interval, Montgomery eq. 8.19.

    Parameters
    ----------
    value : float
    freedom : float
        Degrees of freedom of the standard deviation in it.
    """
    chi2: Any = importlib.import_module("scipy.stats").chi2
    low, high = (math.sqrt(chi2.ppf(share, freedom) / freedom) for share in _tails())
    return Index(value, value * low, value * high)


def nearest_interval(value: float, count: int, freedom: float) -> Index:
    """Cpk or Ppk with its interval, Montgomery eq. 8.21 (Bissell 1990).

    Parameters
    ----------
    value : float
    count : int
        Bars.
    freedom : float
        Degrees of freedom of the standard deviation in it.
    """
    half = statistics.NormalDist().inv_cdf(_tails()[1]) * math.sqrt(1 / (9 * count) + value**2 / (2 * freedom))
    return Index(value, value - half, value + half)


def _tails() -> tuple[float, float]:
    return (1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2
