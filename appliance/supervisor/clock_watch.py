"""Detects that the wall clock was set, which measurements do not use, and that the computer slept."""

import math
import time
from collections.abc import Callable

LEAST_STEP_S = 1.0  # chosen: a time server slews the clock by far less between two calls
STEP_MEMORY_S = 60.0  # chosen: how long the fault `clock_stepped` stays after a step


LEAST_SLEEP_S = 0.2  # chosen: a reading that is older by this is still fresh; both clocks are read 1 us apart


class SleepWatch:
    """Notices that the computer has slept: the monotonic clock, by which readings age, stood still meanwhile.

    Parameters
    ----------
    boot : callable
        Seconds since the computer was started, asleep or not.
    monotonic : callable
        Seconds awake.
    """

    def __init__(
        self,
        boot: Callable[[], float] = lambda: time.clock_gettime(time.CLOCK_BOOTTIME),
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        self._boot = boot
        self._monotonic = monotonic
        self._asleep_s = boot() - monotonic()

    def has_slept(self) -> bool:
        """Whether the computer has slept since the last call."""
        before_s, self._asleep_s = self._asleep_s, self._boot() - self._monotonic()
        return self._asleep_s - before_s > LEAST_SLEEP_S


class WallClock:
    """Compares wall time with monotonic time.

    Parameters
    ----------
    wall : callable
        Wall time, seconds since 1970.
    monotonic : callable
        Monotonic time, seconds.
    """

    def __init__(self, wall: Callable[[], float] = time.time, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._wall = wall
        self._monotonic = monotonic
        self._ahead_s = self._read_difference_s()
        self._set_s = -math.inf

    def was_set(self, now_s: float) -> bool:
        """Whether the wall clock was set within STEP_MEMORY_S before `now_s`, monotonic; call it at every update."""
        ahead_s = self._read_difference_s()
        if abs(ahead_s - self._ahead_s) > LEAST_STEP_S:
            self._set_s = now_s
        self._ahead_s = ahead_s
        return now_s - self._set_s < STEP_MEMORY_S

    def _read_difference_s(self) -> float:
        return self._wall() - self._monotonic()
