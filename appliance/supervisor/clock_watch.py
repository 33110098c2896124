"""Notices when somebody sets the computer's clock; nothing that is measured rests on it."""

import math
import time
from collections.abc import Callable

LEAST_STEP_S = 1.0  # a clock that follows a time server is slewed by far less between two looks
STEP_MEMORY_S = 60.0


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
        """Whether the clock was set within the last minute before `now_s`, monotonic; to be asked often."""
        ahead_s = self._read_difference_s()
        if abs(ahead_s - self._ahead_s) > LEAST_STEP_S:
            self._set_s = now_s
        self._ahead_s = ahead_s
        return now_s - self._set_s < STEP_MEMORY_S

    def _read_difference_s(self) -> float:
        return self._wall() - self._monotonic()
