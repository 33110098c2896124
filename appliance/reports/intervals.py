"""Stretches of time, in ms: what of them lies in a shift, and how long they are together."""

from collections.abc import Iterable
from typing import NamedTuple


class Interval(NamedTuple):
    """From a moment to another, ms since 1970 UTC."""

    start_ms: int
    end_ms: int

    @property
    def length_ms(self) -> int:
        """Its length."""
        return self.end_ms - self.start_ms

    def within(self, frame: "Interval") -> "Interval":
        """What of it lies in another one; of no length if nothing does."""
        start_ms = min(max(self.start_ms, frame.start_ms), frame.end_ms)
        return Interval(start_ms, max(start_ms, min(self.end_ms, frame.end_ms)))


def merged(intervals: Iterable[Interval]) -> list[Interval]:
    """The same time in intervals that do not touch each other, in order."""
    whole: list[Interval] = []
    for interval in sorted(intervals):
        if whole and interval.start_ms <= whole[-1].end_ms:
            whole[-1] = Interval(whole[-1].start_ms, max(whole[-1].end_ms, interval.end_ms))
        else:
            whole.append(interval)
    return whole


def length_ms(intervals: Iterable[Interval]) -> int:
    """Time that any of the intervals covers."""
    return sum(interval.length_ms for interval in merged(intervals))


def without(intervals: Iterable[Interval], others: Iterable[Interval]) -> int:
    """Time that any of the intervals covers and none of the others does, ms."""
    there, gone = list(intervals), list(others)
    return length_ms([*there, *gone]) - length_ms(gone)
