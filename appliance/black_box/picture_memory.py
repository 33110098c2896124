"""The newest exposures with what was measured on them, bounded in time and in bytes."""

import threading
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from appliance.cameras.source import Frame, FramePair
from appliance.files.row_writer import Row
from vision.sent_picture import SentPicture


class KeptExposure(NamedTuple):
    """One exposure in memory.

    Attributes
    ----------
    exposed : FramePair or Frame
    rows : callable
        Makes the rows that `hotgauge measure` or `orient` writes for it: one, or one for each of several bars.
    carried : tuple of float
        What the gauge carried over from earlier frames when it measured this one.
    """

    exposed: FramePair | Frame
    rows: Callable[[], list[Row]]
    carried: tuple[float, ...] = ()

    @property
    def pictures(self) -> tuple[SentPicture, ...]:
        """Its pictures with their coding, left first."""
        return self.exposed.pictures

    @property
    def size_bytes(self) -> int:
        """Memory of its pictures; code values that are shown as they are count once."""
        return sum(one.shown.nbytes + (one.measured.nbytes if is_apart(one) else 0) for one in self.pictures)


def is_apart(picture: SentPicture) -> bool:
    """Whether the code values that are measured are others than those that are shown."""
    return not np.may_share_memory(picture.measured, picture.shown)


class PictureMemory:
    """The newest exposures; adding one never waits for more than a few instructions of another thread.

    Parameters
    ----------
    seconds : float
        Time from the oldest to the newest.
    bytes_max : int
        Of the pictures; the oldest go first, and one exposure that is larger is not kept.
    """

    def __init__(self, seconds: float, bytes_max: int) -> None:
        self._seconds = seconds
        self._bytes_max = bytes_max
        self._kept: deque[KeptExposure] = deque()
        self._bytes = 0
        self._lock = threading.Lock()

    def add(self, kept: KeptExposure) -> None:
        """Keep one more, and let go of what is too old, too much, or of another size than it."""
        with self._lock:
            if self._kept and _shape(self._kept[-1]) != _shape(kept):  # a recording has pictures of one size
                self._kept.clear()
                self._bytes = 0
            self._kept.append(kept)
            self._bytes += kept.size_bytes
            newest_s = kept.exposed.exposed_monotonic_s
            while self._kept and (self._bytes > self._bytes_max or newest_s - self._oldest_s() > self._seconds):
                self._bytes -= self._kept.popleft().size_bytes

    def _oldest_s(self) -> float:
        return self._kept[0].exposed.exposed_monotonic_s

    def all(self) -> deque[KeptExposure]:
        """What is kept now, oldest first."""
        with self._lock:
            return self._kept.copy()


def _shape(kept: KeptExposure) -> list[tuple[int, ...]]:
    return [picture.shown.shape for picture in kept.pictures]
