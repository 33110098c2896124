"""Bars side by side, from frame to frame: which is which stays the same while they pass."""

import math
from collections.abc import Sequence

from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.passing_bar import PassingBar

SAME_BAR_MM = 40.0  # chosen: a bar that lies further across the line than this from where one was is another bar


class SideBySide:
    """Passing bars, each with values of its own."""

    def __init__(self) -> None:
        self._bars: list[tuple[float, PassingBar]] = []

    def add(self, readings: Sequence[SizeReading], time_s: float) -> tuple[SizeReading, ...]:
        """Count a frame.

        Parameters
        ----------
        readings : sequence of SizeReading
            Of all bars of a frame, from smaller x.
        time_s : float
            Moment of exposure; later than those before.

        Returns
        -------
        tuple of SizeReading
            The same readings with their bars' values.
        """
        known, self._bars = self._bars, []
        if any(Reason.NO_BAR in reading.reasons for reading in readings):
            known = []
        result: list[SizeReading] = []
        for reading in readings:
            near = min(known, key=lambda one: abs(one[0] - reading.offset_mm), default=None)
            if near is None or not (len(readings) == len(known) == 1 or _is_near(near[0], reading)):
                near = (math.nan, PassingBar())
            else:
                known.remove(near)
            result.append(near[1].add(reading, time_s))
            offset_mm = reading.offset_mm if math.isfinite(reading.offset_mm) else near[0]
            self._bars.append((offset_mm, near[1]))
        return tuple(result)


def _is_near(offset_mm: float, reading: SizeReading) -> bool:
    return abs(offset_mm - reading.offset_mm) <= SAME_BAR_MM
