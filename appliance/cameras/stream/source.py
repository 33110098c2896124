"""Network cameras (RTSP, HTTP) and V4L2 devices through PyAV: luma as it was sent, moments as `clock` tells them.

Each camera has a thread that receives every picture as it comes; pairs are made by moment.
"""

import threading
import time
from typing import Self

from appliance.cameras.newest_picture import NewestPicture
from appliance.cameras.pairing import Exposure, Pairing
from appliance.cameras.source import CameraError, Frame, FramePair
from appliance.cameras.stream.reader import StreamReader
from appliance.cameras.stream.settings import StreamCamera, StreamPictures


class StreamSource:
    """Image pairs of two streams; see `PairSource`.

    Parameters
    ----------
    settings : StreamCamera
    in_step_us : float
        Longest time between the exposures of one pair.
    """

    simulated = False

    def __init__(self, settings: StreamCamera, in_step_us: float) -> None:
        self._settings = settings
        self._in_step_s = in_step_us / 1e6

    def __enter__(self) -> Self:
        """Open both streams at once; raises `CameraError`."""
        self._news = threading.Condition()
        addresses = self._settings.left, self._settings.right
        self._streams = [StreamReader(self._settings.place(address), self._news) for address in addresses]
        _wait_for_all(self._streams)
        self._pairing = Pairing(self._in_step_s, same_sequence=False)
        return self

    def __exit__(self, *_: object) -> None:
        """Close the streams."""
        _close_all(self._streams)

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair; None when none came in time, `CameraError` when a stream has ended."""
        until_s = time.monotonic() + timeout_s
        with self._news:
            while (pair := self._newest()) is None:
                _check_all(self._streams)
                left_s = until_s - time.monotonic()
                if left_s <= 0:
                    return None
                self._news.wait(left_s)
        return pair

    def _newest(self) -> FramePair | None:
        for side, stream in enumerate(self._streams):
            if (exposure := stream.take()) is not None:
                self._pairing.add(side, exposure)
        return self._pairing.newest_pair()


class StreamPictureSource:
    """Pictures of one stream; see `PictureSource`.

    Parameters
    ----------
    settings : StreamPictures
    """

    simulated = False

    def __init__(self, settings: StreamPictures) -> None:
        self._settings = settings

    def __enter__(self) -> Self:
        """Open the stream; raises `CameraError`."""
        self._news = threading.Condition()
        self._stream = StreamReader(self._settings.place(self._settings.address), self._news)
        _wait_for_all([self._stream])
        self._newest = NewestPicture(self._take)
        return self

    def __exit__(self, *_: object) -> None:
        """Close the stream."""
        _close_all([self._stream])

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture; None when none came in time, `CameraError` when the stream has ended."""
        return self._newest.next(timeout_s)

    def _take(self, wait_s: float) -> Exposure | None:
        with self._news:
            if (exposure := self._stream.take()) is None and wait_s > 0:
                _check_all([self._stream])
                self._news.wait(wait_s)
                exposure = self._stream.take()
        return exposure


def _wait_for_all(streams: list[StreamReader]) -> None:
    """Wait until each stream has given a picture; close them all and raise `CameraError` when one does not."""
    try:
        for stream in streams:
            stream.wait_for_first()
    except CameraError:
        _close_all(streams)
        raise


def _check_all(streams: list[StreamReader]) -> None:
    for stream in streams:
        stream.check()


def _close_all(streams: list[StreamReader]) -> None:
    for stream in streams:
        stream.ask_to_end()
    for stream in streams:
        stream.wait_for_end()
