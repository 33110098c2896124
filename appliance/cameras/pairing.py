"""Pairs left and right pictures of the same exposure."""

import math
from collections import deque
from typing import NamedTuple

from appliance.cameras.pacing import utc_ms
from appliance.cameras.source import FramePair
from vision.sent_picture import SentPicture

LARGEST_QUEUE = 8  # chosen: pictures of one camera that wait for a partner; the oldest is discarded


class Exposure(NamedTuple):
    """One picture of one camera.

    Attributes
    ----------
    picture : SentPicture
    sequence : int
        Number that the camera gave it.
    device_us : int
        The camera's own time stamp, µs.
    exposed_monotonic_s : float
        Moment of exposure on this machine's monotonic clock.
    exposure_us : float
        Exposure time; NaN where the camera cannot say.
    """

    picture: SentPicture
    sequence: int
    device_us: int
    exposed_monotonic_s: float
    exposure_us: float


class Pairing:
    """Pairs the pictures of two cameras; only the newest pair is delivered.

    Sensors that count their exposures together are paired by number, others by the nearest moment. Pictures further
    apart than `in_step_s` are paired too, once no nearer partner can come; `liveness` rejects a pair that is out of
    step.

    Parameters
    ----------
    in_step_s : float
        Pictures no further apart than this, seconds, are paired at once.
    same_sequence : bool
        Whether both cameras number their exposures together, as two sensors of one device do.

    Attributes
    ----------
    dropped : int
        Exposures of the left camera, since the first pair, that gave no pair.
    """

    def __init__(self, in_step_s: float, *, same_sequence: bool) -> None:
        self._in_step_s = in_step_s
        self._same_sequence = same_sequence
        self._waiting: tuple[deque[Exposure], deque[Exposure]] = (
            deque(maxlen=LARGEST_QUEUE),
            deque(maxlen=LARGEST_QUEUE),
        )
        self._first: int | None = None
        self._last = -1
        self.dropped = 0

    @property
    def behind(self) -> int:
        """Side whose newest picture is the older one: 0 left, 1 right."""
        left, right = (waiting[-1].exposed_monotonic_s if waiting else -math.inf for waiting in self._waiting)
        return int(right < left)

    def add(self, side: int, exposure: Exposure) -> None:
        """Queue a picture for pairing.

        Parameters
        ----------
        side : int
            Camera: 0 left, 1 right.
        exposure : Exposure
        """
        self._waiting[side].append(exposure)

    def newest_pair(self) -> FramePair | None:
        """Remove and return the newest complete pair, and discard older pictures; None without a pair."""
        for left in reversed(self._waiting[0]):
            right = self._same_number(left) if self._same_sequence else self._nearest(left)
            if right is not None:
                return self._pair(left, right)
        return None

    def _same_number(self, left: Exposure) -> Exposure | None:
        return next((right for right in self._waiting[1] if right.sequence == left.sequence), None)

    def _nearest(self, left: Exposure) -> Exposure | None:
        if not self._waiting[1]:
            return None
        nearest = min(self._waiting[1], key=lambda right: _apart_s(left, right))
        later_s = max(left.exposed_monotonic_s, nearest.exposed_monotonic_s)
        known = all(waiting[-1].exposed_monotonic_s >= later_s for waiting in self._waiting)
        return nearest if known or _apart_s(left, nearest) <= self._in_step_s else None

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
            left.picture.shown,
            right.picture.shown,
            sequence=number,
            left_us=left.device_us,
            right_us=right.device_us,
            exposed_monotonic_s=left.exposed_monotonic_s,
            exposed_utc_ms=utc_ms(left.exposed_monotonic_s),
            exposure_us=left.exposure_us,
            dropped=self.dropped,
            stamped=self._same_sequence,
            sent=(left.picture, right.picture),
        )


def _apart_s(left: Exposure, right: Exposure) -> float:
    return abs(left.exposed_monotonic_s - right.exposed_monotonic_s)
