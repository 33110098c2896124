"""Network cameras (RTSP, HTTP) and V4L2 devices through OpenCV.

Such cameras stamp nothing that can be trusted: a picture's moment is its arrival less the delay that the settings
state, and pairs are made by it. Each camera has a thread that takes every picture as it comes, so that none grows
old in a buffer.
"""

import math
import threading
import time
from typing import Self

import cv2
import numpy as np

from appliance.cameras.pacing import utc_ms
from appliance.cameras.pairing import Exposure, Pairing
from appliance.cameras.source import CameraError, Frame, FramePair
from appliance.cameras.stream.settings import StreamCamera, StreamPictures

OPEN_TIME_S = 8.0
READ_TIME_S = 3.0  # a network camera that sends nothing for so long is gone
DEVICE_FOLDER = "/dev/"
TIMEOUT_OPTIONS = [
    cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, round(1000 * OPEN_TIME_S),
    cv2.CAP_PROP_READ_TIMEOUT_MSEC, round(1000 * READ_TIME_S),
]  # fmt: skip


class StreamSource:
    """Image pairs of two streams; see `PairSource`.

    Parameters
    ----------
    settings : StreamCamera
    in_step_us : float
        Longest time between the arrivals of one pair.
    """

    simulated = False

    def __init__(self, settings: StreamCamera, in_step_us: float) -> None:
        self._settings = settings
        self._in_step_s = in_step_us / 1e6

    def __enter__(self) -> Self:
        """Open both streams at once; raises `CameraError`."""
        settings = self._settings
        self._news = threading.Condition()
        delay_s = settings.delay_ms / 1000
        self._streams = [_Stream(address, delay_s, self._news) for address in (settings.left, settings.right)]
        _wait_for_all(self._streams)
        self._pairing = Pairing(self._in_step_s, same_sequence=False)
        return self

    def __exit__(self, *_: object) -> None:
        """Close the streams."""
        for stream in self._streams:
            stream.close()

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
        self._stream = _Stream(self._settings.address, self._settings.delay_ms / 1000, self._news)
        _wait_for_all([self._stream])
        self._delivered = 0
        return self

    def __exit__(self, *_: object) -> None:
        """Close the stream."""
        self._stream.close()

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture; None when none came in time, `CameraError` when the stream has ended."""
        with self._news:
            if (exposure := self._stream.take()) is None:
                self._news.wait(timeout_s)
                exposure = self._stream.take()
            if exposure is None:
                _check_all([self._stream])
                return None
        self._delivered += 1
        return Frame(
            exposure.picture,
            sequence=exposure.sequence,
            exposed_monotonic_s=exposure.exposed_monotonic_s,
            exposed_utc_ms=utc_ms(exposure.exposed_monotonic_s),
            dropped=exposure.sequence + 1 - self._delivered,
        )


def _wait_for_all(streams: list["_Stream"]) -> None:
    """Wait until each stream has given a picture; close them all and raise `CameraError` when one does not."""
    try:
        for stream in streams:
            stream.wait_for_first()
    except CameraError:
        for stream in streams:
            stream.close()
        raise


def _check_all(streams: list["_Stream"]) -> None:
    for stream in streams:
        stream.check()


class _Stream:
    """One camera and the thread that reads it; `news` is notified of every picture."""

    def __init__(self, address: str, delay_s: float, news: threading.Condition) -> None:
        self._address = address
        self._delay_s = delay_s
        self._news = news
        self._newest: Exposure | None = None
        self._trouble = ""
        self._first = threading.Event()
        self._closed = threading.Event()
        # a thread that hangs in native code must not keep the process
        threading.Thread(target=self._read, daemon=True).start()

    def wait_for_first(self) -> None:
        self._first.wait(OPEN_TIME_S)
        if self._trouble or not self._first.is_set():
            raise CameraError(
                self._trouble or f"{self._address}: no picture within {OPEN_TIME_S:g} s; check the camera"
            )

    def take(self) -> Exposure | None:
        """Newest picture not taken yet."""
        newest, self._newest = self._newest, None
        return newest

    def check(self) -> None:
        """Raise `CameraError` when the camera is gone."""
        if self._trouble:
            raise CameraError(self._trouble)

    def close(self) -> None:
        self._closed.set()

    def _read(self) -> None:
        capture = _open(self._address)
        trouble = f"{self._address}: the stream has ended; check camera and network"
        if not capture.isOpened():
            trouble = f"{self._address}: cannot be opened; check address, camera and network"
        number = 0
        while not self._closed.is_set():
            there, picture = capture.read()
            if not there:
                self._report(trouble)
                break
            moment_s = time.monotonic() - self._delay_s
            exposure = Exposure(np.asarray(picture, dtype=np.uint8), number, round(1e6 * moment_s), moment_s, math.nan)
            with self._news:
                self._newest = exposure
                self._news.notify_all()
            self._first.set()
            number += 1
        capture.release()

    def _report(self, trouble: str) -> None:
        with self._news:
            self._trouble = trouble
            self._news.notify_all()
        self._first.set()


def _open(address: str) -> cv2.VideoCapture:
    if not address.startswith(DEVICE_FOLDER):
        return cv2.VideoCapture(address, cv2.CAP_FFMPEG, TIMEOUT_OPTIONS)
    capture = cv2.VideoCapture(address, cv2.CAP_V4L2)
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # old pictures in a queue would be taken for new ones
    return capture
