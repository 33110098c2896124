"""Delivers the newest picture of a single camera; older ones are discarded and counted."""

import math
from collections.abc import Callable

from appliance.cameras.pacing import utc_ms
from appliance.cameras.pairing import Exposure
from appliance.cameras.source import Frame


class NewestPicture:
    """Numbers the exposures of one camera from the first one on, and counts those that nobody took.

    Parameters
    ----------
    take : callable
        Waits at most so many seconds for the camera's next exposure; None when none came.
    temperature_c : callable, optional
        The camera's temperature, °C.
    """

    def __init__(
        self, take: Callable[[float], Exposure | None], temperature_c: Callable[[], float] = lambda: math.nan
    ) -> None:
        self._take = take
        self._temperature_c = temperature_c
        self._first: int | None = None
        self._delivered = 0

    def next(self, timeout_s: float) -> Frame | None:
        """Newest exposure as a frame; None when none came in time; raises what `take` raises."""
        newest = self._take(timeout_s)
        while (later := self._take(0.0)) is not None:
            newest = later
        if newest is None:
            return None
        self._first = newest.sequence if self._first is None else self._first
        number = newest.sequence - self._first
        self._delivered += 1
        return Frame(
            newest.picture.shown,
            sequence=number,
            exposed_monotonic_s=newest.exposed_monotonic_s,
            exposed_utc_ms=utc_ms(newest.exposed_monotonic_s),
            exposure_us=newest.exposure_us,
            dropped=number + 1 - self._delivered,
            device_us=newest.device_us,
            temperature_c=self._temperature_c(),
            sent=newest.picture,
        )
