"""Moments at which a recording or a simulation delivers its next frame."""

import time
from collections.abc import Callable

STAMP_RATE_HZ = 25.0  # chosen: rate of the device time stamps of a source without a rate


class Pacer:
    """Delivers frame numbers at a rate, as a camera does: only the newest due one, older ones are dropped.

    Parameters
    ----------
    rate_hz : float
        Exposures per second; 0 makes each exposure due at once and drops none.
    clock, sleep : callable
        Monotonic clock and sleep, both in seconds.

    Raises
    ------
    ValueError
        The rate is negative.

    Attributes
    ----------
    dropped : int
        Exposures that were not delivered before a newer one was due.
    """

    def __init__(
        self,
        rate_hz: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if rate_hz < 0:
            raise ValueError(f"rate_hz must not be negative, got {rate_hz}")
        self._rate_hz = rate_hz
        self._clock = clock
        self._sleep = sleep
        self._start_s = clock()
        self._next = 0
        self.dropped = 0

    def next_due(self, timeout_s: float) -> tuple[int, float] | None:
        """Wait for the next exposure to be due.

        Parameters
        ----------
        timeout_s : float
            Longest wait, seconds.

        Returns
        -------
        tuple of int and float, or None
            Number of the newest exposure that is due and its moment on the clock, seconds; None if none is due in time.
        """
        if self._rate_hz == 0:
            return self._deliver(self._next, self._clock())
        if not self._wait_until(self._moment(self._next), timeout_s):
            return None
        newest = max(self._next, int((self._clock() - self._start_s) * self._rate_hz))
        return self._deliver(newest, self._moment(newest))

    def _deliver(self, number: int, moment_s: float) -> tuple[int, float]:
        self.dropped += number - self._next
        self._next = number + 1
        return number, moment_s

    def _moment(self, number: int) -> float:
        return self._start_s + number / self._rate_hz

    def _wait_until(self, moment_s: float, timeout_s: float) -> bool:
        wait_s = moment_s - self._clock()
        if wait_s > 0:
            self._sleep(min(wait_s, timeout_s))
        return wait_s <= timeout_s


def device_us(number: int, rate_hz: float) -> int:
    """Time stamp of an exposure on a steady device clock, µs.

    Parameters
    ----------
    number : int
        Of the exposure, from 0.
    rate_hz : float
        Exposures per second; 0 counts as STAMP_RATE_HZ.
    """
    return round(number * 1e6 / (rate_hz or STAMP_RATE_HZ))


def utc_ms(monotonic_s: float) -> int:
    """Wall time, ms since 1970 UTC, of a moment on the monotonic clock."""
    return round((time.time() - (time.monotonic() - monotonic_s)) * 1000)
