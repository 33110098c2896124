"""Which left and which right picture belong to the same exposure."""

import math
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.pacing import utc_ms
from appliance.cameras.source import FramePair

KEPT = 8  # pictures of a camera that wait for their partner; older ones have lost it


class Exposure(NamedTuple):
    """One picture of one camera.

    Attributes
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    sequence : int
        Number that the camera gave it.
    device_us : int
        The camera's own time stamp, µs.
    exposed_monotonic_s : float
        Moment of exposure on this machine's monotonic clock.
    exposure_us : float
        Exposure time; NaN where the camera cannot say.
    """

    picture: NDArray[np.uint8]
    sequence: int
    device_us: int
    exposed_monotonic_s: float
    exposure_us: float


class Pairing:
    """Pairs the pictures of two cameras; only the newest pair counts.

    Parameters
    ----------
    apart_max_s : float
        Longest time between two exposures that count as one.
    same_sequence : bool
        Whether both cameras count their exposures together, as two sensors of one device do; equal numbers are
        asked for then.

    Attributes
    ----------
    dropped : int
        Exposures of the left camera, since the first pair, that gave no pair.
    apart_s : float
        Time between the newest pictures of both sides; NaN until both have given one.
    newest_of_both_s : float
        Moment (monotonic) of the newest exposure that both sides have reached; minus infinity before there is one.
    """

    def __init__(self, apart_max_s: float, *, same_sequence: bool) -> None:
        self._apart_max_s = apart_max_s
        self._same_sequence = same_sequence
        self._waiting: tuple[deque[Exposure], deque[Exposure]] = (deque(maxlen=KEPT), deque(maxlen=KEPT))
        self._first: int | None = None
        self._last = -1
        self.dropped = 0
        self.apart_s = math.nan
        self.newest_of_both_s = -math.inf

    @property
    def behind(self) -> int:
        """Side whose newest picture is the older one: 0 left, 1 right."""
        left, right = (waiting[-1].exposed_monotonic_s if waiting else -math.inf for waiting in self._waiting)
        return int(right < left)

    def add(self, side: int, exposure: Exposure) -> None:
        """Take a picture of the left (0) or right (1) camera."""
        self._waiting[side].append(exposure)
        if all(self._waiting):
            left, right = (waiting[-1] for waiting in self._waiting)
            self.apart_s = abs(left.exposed_monotonic_s - right.exposed_monotonic_s)
            self.newest_of_both_s = min(left.exposed_monotonic_s, right.exposed_monotonic_s)

    def take(self) -> FramePair | None:
        """Newest pair that is complete, and forget all that is older; None without one."""
        for left in reversed(self._waiting[0]):
            for right in reversed(self._waiting[1]):
                if self._together(left, right):
                    return self._pair(left, right)
        return None

    def _together(self, left: Exposure, right: Exposure) -> bool:
        apart_s = abs(left.exposed_monotonic_s - right.exposed_monotonic_s)
        return apart_s <= self._apart_max_s and (not self._same_sequence or left.sequence == right.sequence)

    def _pair(self, left: Exposure, right: Exposure) -> FramePair:
        for waiting, taken in zip(self._waiting, (left, right), strict=True):
            while waiting.popleft() is not taken:
                pass
        if self._first is None:
            self._first = left.sequence
        number = left.sequence - self._first
        self.dropped += number - self._last - 1
        self._last = number
        return FramePair(
            left.picture,
            right.picture,
            sequence=number,
            left_us=left.device_us,
            right_us=right.device_us,
            exposed_monotonic_s=left.exposed_monotonic_s,
            exposed_utc_ms=utc_ms(left.exposed_monotonic_s),
            exposure_us=left.exposure_us,
            dropped=self.dropped,
        )
