"""What has just been measured, for PLCs that read slowly: the last readings, and the diameters of each bar."""

import enum
import math
from collections.abc import Mapping

from appliance.publication import (
    BAR_HEAD,
    BAR_TAIL,
    BAR_TOO_SHORT,
    CALIBRATION_DUE,
    CAMERA_MOVED,
    LOW_CONTRAST,
    NO_BAR,
)
from appliance.stations.link import ReadingMessage
from plc.registers import Value
from plc.rings import READING_FIELDS, SLOTS

BLIND_S = 2.0  # a bar that is seen again after so long may be another one


LASTING = {
    "contrast_low": LOW_CONTRAST,
    "calibration_due": CALIBRATION_DUE | CAMERA_MOVED,
}


class ReadingRing:
    """The last readings as they were served."""

    def __init__(self) -> None:
        self._index = 0
        self._slots: dict[str, Value] = {}

    def add(self, values: Mapping[str, Value]) -> None:
        """Write the values that belong to the newest reading over the oldest."""
        slot = f"reading_{self._index % SLOTS}_"
        self._slots |= {slot + field: values.get(field) for field in READING_FIELDS}
        self._index += 1

    def values(self) -> dict[str, Value]:
        """Values of the registers, by name."""
        return {"reading_ring_index": self._index} | self._slots


class Part(enum.Enum):
    """Which part of a bar lies in the measuring region; in time each bar is seen in this order."""

    NONE = "none"
    ENTER = "enter"
    HEAD = "head"
    BODY = "body"
    TAIL = "tail"
    LEAVE = "leave"


def part_of_bar(reasons: int) -> Part:
    """Part of the bar that a reading with these reasons is of; a bar with both ends in the region shows its head."""
    if reasons & NO_BAR:
        return Part.NONE
    short = bool(reasons & BAR_TOO_SHORT)
    if reasons & BAR_HEAD:
        return Part.ENTER if short else Part.HEAD
    if reasons & BAR_TAIL:
        return Part.LEAVE if short else Part.TAIL
    return Part.BODY


class PerBar:
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

    def take(self, reading: ReadingMessage) -> None:
        """Take a new reading into account."""
        away_s = reading.exposed_monotonic_s - self._seen_s
        if reading.reasons & NO_BAR:
            self._passing = self._passing and away_s < self._gap_s
            return
        self._passing = self._passing and away_s < max(BLIND_S, self._gap_s)
        self._seen_s = reading.exposed_monotonic_s
        if reading.valid and reading.diameter_mm is not None:
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


class Lasting:
    """Faults that single readings only hint at: reasons that stay for a while.

    Parameters
    ----------
    after_s : float
        How long a reason must be there, or be gone, in all readings of bars.
    """

    def __init__(self, after_s: float) -> None:
        self._after_s = after_s
        self._since_s: dict[str, float] = {}
        self._active: set[str] = set()

    def take(self, reading: ReadingMessage) -> dict[str, bool]:
        """Take a new reading into account; which faults are active now."""
        now_s = reading.exposed_monotonic_s
        if not reading.reasons & NO_BAR:
            for fault, bits in LASTING.items():
                self._see(fault, now_s, there=bool(reading.reasons & bits))
        return {fault: fault in self._active for fault in LASTING}

    def _see(self, fault: str, now_s: float, *, there: bool) -> None:
        if there == (fault in self._active):
            self._since_s.pop(fault, None)
        elif now_s - self._since_s.setdefault(fault, now_s) >= self._after_s:
            self._active ^= {fault}
            del self._since_s[fault]
