"""What has just been measured, for PLCs that read slowly: the last readings, and the diameters of each bar."""

import enum
import math

from appliance.sizing.message import ReadingMessage
from plc.rows import Value
from vision.reasons import Reason

BLIND_S = 2.0  # a bar that is seen again after so long may be another one


class Part(enum.Enum):
    """Which part of a bar lies in the measuring region; in time each bar is seen in this order."""

    NONE = "none"
    ENTER = "enter"
    HEAD = "head"
    BODY = "body"
    TAIL = "tail"
    LEAVE = "leave"


def part_of_bar(reasons: Reason) -> Part:
    """Part of the bar that a reading with these reasons is of; a bar with both ends in the region shows its head."""
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

    They are those of the bar's body. Its head and its tail count only as long as no body has been seen, as on a bar
    that is shorter than the measuring region.

    A bar begins with the first valid reading after a gap, and ends when no bar has been seen for `gap_s`, or
    nothing at all for a while.

    Parameters
    ----------
    gap_s : float
        Time without a bar that is a gap and not a miss.
    """

    def __init__(self, gap_s: float) -> None:
        self._gap_s = gap_s
        self._passing = False
        self._seen_s = 0.0
        self._bars = 0
        self._readings = 0
        self._body = False
        self._smallest_mm = self._mean_mm = self._largest_mm = math.nan

    def add(self, message: ReadingMessage) -> None:
        """Count a new reading."""
        reading = message.reading
        away_s = message.exposed_monotonic_s - self._seen_s
        if Reason.NO_BAR in reading.reasons:
            self._passing = self._passing and away_s < self._gap_s
            return
        self._passing = self._passing and away_s < max(BLIND_S, self._gap_s)
        self._seen_s = message.exposed_monotonic_s
        if reading.valid:
            self._add(reading.diameter_mm, body=part_of_bar(reading.reasons) is Part.BODY)

    def end(self) -> None:
        """Nothing is seen any more: what comes next is another bar."""
        self._passing = False

    def values(self) -> dict[str, Value]:
        """Values of the registers, by name."""
        return {
            "bar_sequence": self._bars,
            "bar_min": self._smallest_mm,
            "bar_mean": self._mean_mm,
            "bar_max": self._largest_mm,
        }

    def _add(self, diameter_mm: float, *, body: bool) -> None:
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
        self._readings += 1
        self._smallest_mm = min(self._smallest_mm, diameter_mm)
        self._mean_mm += (diameter_mm - self._mean_mm) / self._readings
        self._largest_mm = max(self._largest_mm, diameter_mm)
