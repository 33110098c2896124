"""Bars side by side, from frame to frame: which is which stays the same while they pass."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.bar_gap import BLIND_TIME_S, BarGap
from vision.sizing.passing_bar import PassingBar
from vision.sizing.tangent.bar_pairs import MOST_BARS

SAME_BAR_MM = 40.0  # chosen: a bar that lies further across the line than this from where one was is another bar


class _Known(NamedTuple):
    """A bar that passes: its slot, when and where it was seen last, its values, its reading in the last frame."""

    slot: int
    seen_s: float
    offset_mm: float
    passing: PassingBar
    reading: SizeReading


class SideBySide:
    """Passing bars, each with values of its own and a slot that it keeps, also while another one hides it."""

    def __init__(self) -> None:
        self._gap = BarGap()
        self._bars: list[_Known] = []

    @property
    def slots(self) -> tuple[SizeReading, ...]:
        """Readings of the last frame by slot, `MOST_BARS` of them; a slot without a bar says `no_bar`."""
        slots = [SizeReading(reasons=Reason.NO_BAR)] * MOST_BARS
        for bar in self._bars:
            slots[bar.slot] = bar.reading
        return tuple(slots)

    def add(self, readings: Sequence[SizeReading], time_s: float) -> tuple[SizeReading, ...]:
        """Count a frame.

        Parameters
        ----------
        readings : sequence of SizeReading
            Of all bars of a frame, from smaller x.
        time_s : float
            Moment of exposure.

        Returns
        -------
        tuple of SizeReading
            The same readings with their bars' values. Only a reading with a value begins a bar.
        """
        gone = self._gap.ends_bar(readings[0], time_s)  # a frame without a bar has no other reading
        before = [bar for bar in self._bars if not gone and time_s - bar.seen_s < BLIND_TIME_S]
        if Reason.NO_BAR in readings[0].reasons:
            self._bars = [bar._replace(reading=readings[0]) for bar in before]
            return tuple(readings)
        alone = len(readings) == len(before) == 1
        known = [_same(before, reading, alone=alone) for reading in readings]
        hidden = [bar._replace(reading=SizeReading(reasons=Reason.ONE_CAMERA)) for bar in before]
        taken = {bar.slot for bar in (*hidden, *known) if bar is not None}
        free = [slot for slot in range(MOST_BARS) if slot not in taken]
        self._bars = hidden
        result: list[SizeReading] = []
        for one, reading in zip(known, readings, strict=True):
            placed = len(readings) == 1 or math.isfinite(reading.offset_mm)
            if one is None and not (free and reading.valid and placed):
                result.append(reading)
                continue
            bar = one or _Known(free.pop(0), time_s, reading.offset_mm, PassingBar(), reading)
            result.append(bar.passing.add(reading, time_s))
            offset_mm = reading.offset_mm if math.isfinite(reading.offset_mm) else bar.offset_mm
            self._bars.append(_Known(bar.slot, time_s, offset_mm, bar.passing, result[-1]))
        return tuple(result)


def _same(before: list[_Known], reading: SizeReading, *, alone: bool) -> _Known | None:
    """The known bar that a reading shows, removed from the list; None for a new one."""
    near = [one for one in before if alone or abs(one.offset_mm - reading.offset_mm) <= SAME_BAR_MM]
    if not near:
        return None
    nearest = min(near, key=lambda one: abs(one.offset_mm - reading.offset_mm))
    before.remove(nearest)
    return nearest
