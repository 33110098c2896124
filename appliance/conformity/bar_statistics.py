"""Smallest, mean and largest diameter of each bar, mm, for PLCs that poll slowly."""

import enum
import math

from appliance.conformity.mean_uncertainty import MeanUncertainty
from appliance.sizing.message import ReadingMessage
from plc.rows import Value
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.bar_gap import BarGap


class Part(enum.Enum):
    """Part of a bar that lies in the measuring region; a bar passes in this order."""

    NONE = "none"
    ENTER = "enter"
    HEAD = "head"
    BODY = "body"
    TAIL = "tail"
    LEAVE = "leave"


def part_of_bar(reasons: Reason) -> Part:
    """Part of the bar that a reading with these reasons shows; a bar with both ends in the region counts as head."""
    if Reason.NO_BAR in reasons:
        return Part.NONE
    short = Reason.BAR_TOO_SHORT in reasons
    if Reason.BAR_HEAD in reasons:
        return Part.ENTER if short else Part.HEAD
    if Reason.BAR_TAIL in reasons:
        return Part.LEAVE if short else Part.TAIL
    return Part.BODY


class BarStatistics:
    """Smallest, mean and largest diameter of the bar that passes, or of the last one until the next begins.

    Only readings of the bar's body count. Head and tail count until the first reading of a body, and so on the whole
    of a bar that is shorter than the measuring region.

    A bar begins with the first valid reading after a gap. It ends as `BarGap` says, and where a recording loops or
    jumps.

    Parameters
    ----------
    gap_s : float
        Time without a bar that separates two bars, seconds; shorter ones are missed detections.
    """

    def __init__(self, gap_s: float) -> None:
        self._gap = BarGap(gap_s)
        self._passing = False
        self._stretch = 0
        self._bars = 0
        self._readings = 0
        self._body = False
        self._smallest_mm = self._mean_mm = self._largest_mm = math.nan
        self._mean = MeanUncertainty()

    def add(self, message: ReadingMessage) -> None:
        """Count a new reading."""
        reading = message.reading
        if message.stretch != self._stretch:
            self.end()
            self._stretch = message.stretch
        if self._gap.ends_bar(reading, message.exposed_monotonic_s):
            self.end()
        if reading.valid:
            self._add(reading, body=part_of_bar(reading.reasons) is Part.BODY)

    @property
    def passing(self) -> bool:
        """Whether a bar has begun and not ended."""
        return self._passing

    def end(self) -> None:
        """End the bar: the next valid reading begins another one."""
        self._passing = False

    def values(self) -> dict[str, Value]:
        """Values of the registers, by name."""
        return {
            "bar_sequence": self._bars,
            "bar_min": self._smallest_mm,
            "bar_mean": self._mean_mm,
            "bar_max": self._largest_mm,
            "bar_mean_expanded_uncertainty": self._mean.expanded_mm,
        }

    def _add(self, reading: SizeReading, *, body: bool) -> None:
        diameter_mm = reading.diameter_mm
        if not self._passing:
            self._passing = True
            self._bars += 1
            self._readings, self._body = 0, False
        if self._body and not body:
            return
        if body and not self._body:
            self._readings, self._body = 0, True
        if self._readings == 0:
            self._smallest_mm = self._mean_mm = self._largest_mm = diameter_mm
            self._mean = MeanUncertainty()
        self._mean.add(reading)
        self._readings += 1
        self._smallest_mm = min(self._smallest_mm, diameter_mm)
        self._mean_mm += (diameter_mm - self._mean_mm) / self._readings
        self._largest_mm = max(self._largest_mm, diameter_mm)
