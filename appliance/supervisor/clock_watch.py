"""Detects that the computer's wall clock was set; measurements use the monotonic clock and are not affected."""

import math
import time
from collections.abc import Callable

LEAST_STEP_S = 1.0  # chosen: a time server slews the clock by far less between two calls
STEP_MEMORY_S = 60.0  # chosen: how long the fault `clock_stepped` stays after a step


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
