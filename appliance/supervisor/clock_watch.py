"""Notices when somebody sets the computer's clock; nothing that is measured rests on it."""

import math
import time
from collections.abc import Callable

STEP_S = 1.0  # a clock that follows a time server is slewed by far less between two looks
REMEMBERED_S = 60.0


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
        self._ahead_s = self._look()
        self._set_s = -math.inf

    def was_set(self, now_s: float) -> bool:
        """Whether the clock was set within the last minute before `now_s`, monotonic; to be asked often."""
        ahead_s = self._look()
        if abs(ahead_s - self._ahead_s) > STEP_S:
            self._set_s = now_s
        self._ahead_s = ahead_s
        return now_s - self._set_s < REMEMBERED_S

    def _look(self) -> float:
        return self._wall() - self._monotonic()
