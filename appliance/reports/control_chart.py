"""Control chart of subgroup means and ranges: D. C. Montgomery, Introduction to Statistical Quality Control, 6.2."""

import math
import statistics
from collections.abc import Sequence
from typing import NamedTuple

SUBGROUP_BARS = 5
MEAN_RANGE_D2 = 2.32593  # mean of the range of five normal numbers, in standard deviations (ASTM MNL 7, table 49)
RANGE_DEVIATION_D3 = 0.86408  # standard deviation of that range, likewise
MEANS_FACTOR_A2 = 3 / (MEAN_RANGE_D2 * math.sqrt(SUBGROUP_BARS))
RANGE_FACTOR_D4 = 1 + 3 * RANGE_DEVIATION_D3 / MEAN_RANGE_D2  # its lower partner is below 0, so there is no lower limit
SUBGROUPS_ENOUGH = 20  # Montgomery: limits from fewer are trial limits


class ControlChart(NamedTuple):
    """Means and ranges of subgroups of five bars, with three-sigma limits from the chart's own ranges.

    Attributes
    ----------
    means, ranges : tuple of float
        Of each subgroup, in the order of time.
    center, lower, upper : float
        Center line and limits of the means.
    range_center, range_upper : float
        Center line and upper limit of the ranges; the lower limit is 0.
    """

    means: tuple[float, ...]
    ranges: tuple[float, ...]
    center: float
    lower: float
    upper: float
    range_center: float
    range_upper: float

    @property
    def means_outside(self) -> list[int]:
        """Numbers of the subgroups, from 0, whose mean lies beyond a limit."""
        return [number for number, mean in enumerate(self.means) if not self.lower <= mean <= self.upper]

    @property
    def ranges_outside(self) -> list[int]:
        """Numbers of the subgroups, from 0, whose range lies beyond the limit."""
        return [number for number, width in enumerate(self.ranges) if width > self.range_upper]


def subgroups(numbers: Sequence[float]) -> list[tuple[float, ...]]:
    """Consecutive fives; what is left over belongs to none."""
    whole = len(numbers) - len(numbers) % SUBGROUP_BARS
    return [tuple(numbers[start : start + SUBGROUP_BARS]) for start in range(0, whole, SUBGROUP_BARS)]


def control_chart(groups: Sequence[Sequence[float]]) -> ControlChart | None:
    """Chart of subgroups of five; None for fewer than two of them."""
    if len(groups) < 2:
        return None
    means = tuple(statistics.fmean(group) for group in groups)
    ranges = tuple(max(group) - min(group) for group in groups)
    return ControlChart(means, ranges, *limits(statistics.fmean(means), statistics.fmean(ranges)))


def limits(grand_mean: float, mean_range: float) -> tuple[float, float, float, float, float]:
    """Center, lower and upper limit of means; center and upper limit of ranges."""
    half = MEANS_FACTOR_A2 * mean_range
    return grand_mean, grand_mean - half, grand_mean + half, mean_range, RANGE_FACTOR_D4 * mean_range
