"""Counts failed log-ins, so that nobody finds a password by trying."""

import time
from collections import deque
from collections.abc import Callable

FAILURES_MAX = 5  # chosen: within the window, of one address or for one name
WINDOW_S = 300.0  # chosen: 5 attempts in 5 minutes are 1440 a day
REMEMBERED_MAX = 1000  # addresses and names


class Attempts:
    """Failed log-ins of the last minutes, by address and by name.

    Parameters
    ----------
    clock : callable
        Monotonic time, seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._failed_s: dict[str, deque[float]] = {}

    def wait_s(self, *keys: str) -> float:
        """Seconds until the next attempt may be made; 0 if it may be made now."""
        now_s = self._clock()
        waits = (self._failed_s[key][0] + WINDOW_S - now_s for key in keys if self._is_full(key))
        return max(0.0, *waits, 0.0)

    def add(self, *keys: str) -> None:
        """Count a failed attempt."""
        now_s = self._clock()
        if len(self._failed_s) >= REMEMBERED_MAX:
            self._failed_s = {key: times for key, times in self._failed_s.items() if now_s - times[-1] < WINDOW_S}
        for key in keys:
            if key in self._failed_s or len(self._failed_s) < REMEMBERED_MAX:
                self._failed_s.setdefault(key, deque(maxlen=FAILURES_MAX)).append(now_s)

    def forget(self, *keys: str) -> None:
        """Forget the failures of one who has logged in."""
        for key in keys:
            self._failed_s.pop(key, None)

    def _is_full(self, key: str) -> bool:
        return len(self._failed_s.get(key, ())) == FAILURES_MAX
