"""Interface of a range sensor: a range beside each exposure, or what is wrong with it."""

import math
from dataclasses import replace
from typing import NamedTuple, Protocol, Self

from appliance.cameras.source import Frame, FramePair

Exposed = FramePair | Frame

LEAST_READINGS = 2  # a single one says nothing of motion
MOST_APART = 3.0  # chosen: of u_mm


class RangeReading(NamedTuple):
    """A range, mm, at a moment of the monotonic clock; NaN where the beam meets nothing within the measuring range."""

    moment_s: float
    range_mm: float


class RangeSensor(Protocol):
    """A sensor in use: as a context manager it is opened and closed."""

    def __enter__(self) -> Self:
        """Open it; never raises."""
        ...

    def __exit__(self, *_: object) -> None:
        """Close it; never raises."""
        ...

    @property
    def faults(self) -> dict[str, str]:
        """Names in the fault table, each with its detail."""
        ...

    def beside(self, exposed: Exposed) -> Exposed:
        """The exposure with the range of its moment."""
        ...


class NoRangeSensor:
    """Cameras alone, or the simulated mill, whose pairs bring their range."""

    def __enter__(self) -> Self:
        """Nothing to open."""
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing to close."""

    @property
    def faults(self) -> dict[str, str]:
        """None."""
        return {}

    def beside(self, exposed: Exposed) -> Exposed:
        """The exposure as it is."""
        return exposed


def with_range(exposed: Exposed, range_mm: float) -> Exposed:
    """A pair with the range of its moment; the picture of a single camera as it is.

    Parameters
    ----------
    exposed : FramePair or Frame
    range_mm : float
        NaN without one.
    """
    return replace(exposed, range_mm=range_mm) if isinstance(exposed, FramePair) else exposed


def steady_range_mm(readings: list[RangeReading], moment_s: float, age_max_s: float, u_mm: float) -> float:
    """Range of the reading nearest to a moment, if the bar held still around it; else NaN.

    With one camera nothing else tells that a bar hopped between exposure and range, by which a diameter would be wrong
    beyond its U (docs/methods/range.md).

    Parameters
    ----------
    readings : list of RangeReading
    moment_s : float
        Of the exposure, on the monotonic clock.
    age_max_s : float
        Longest time between the exposure and a reading that counts.
    u_mm : float
        Standard uncertainty of the spot's place; readings that differ by more than `MOST_APART` of it show motion.
    """
    near = [one for one in readings if abs(one.moment_s - moment_s) <= age_max_s]
    ranges = [one.range_mm for one in near]
    if len(near) < LEAST_READINGS or any(map(math.isnan, ranges)) or max(ranges) - min(ranges) > MOST_APART * u_mm:
        return math.nan
    return min(near, key=lambda one: abs(one.moment_s - moment_s)).range_mm
