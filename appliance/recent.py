"""What has just been measured, for PLCs that read slowly: the last readings, and the diameters of each bar."""

import math
from collections.abc import Mapping

from appliance.publication import NO_BAR
from appliance.stations.link import ReadingMessage
from plc.registers import Value
from plc.rings import READING_FIELDS, SLOTS

BLIND_S = 2.0  # a bar that is seen again after so long may be another one


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


class PerBar:
    """Smallest, mean and largest diameter of the bar that passes, or of the last one until the next begins.

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
            self._add(reading.diameter_mm)

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

    def _add(self, diameter_mm: float) -> None:
        if not self._passing:
            self._passing = True
            self._bars += 1
            self._readings = 0
            self._smallest_mm = self._mean_mm = self._largest_mm = diameter_mm
        self._readings += 1
        self._smallest_mm = min(self._smallest_mm, diameter_mm)
        self._mean_mm += (diameter_mm - self._mean_mm) / self._readings
        self._largest_mm = max(self._largest_mm, diameter_mm)
