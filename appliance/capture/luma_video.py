"""A video without loss of luma as a stream sent it, with the colour differences of its colours beside it."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
from av.error import FFmpegError
from numpy.typing import NDArray

from appliance.capture.error import CaptureError
from vision.sent_picture import LUMA_709, Coding, SentPicture

CODEC = "ffv1"  # RFC 9043
TIME_BASE = Fraction(1, 1000)
FULL_RANGE, LIMITED_RANGE = 2, 1  # AVCOL_RANGE_JPEG, AVCOL_RANGE_MPEG
BT_709, BT_601 = 1, 6  # ITU-T H.273, matrix coefficients
CHROMA_SPAN = 224 / 255  # of a limited range's colour differences (ITU-R BT.601-7)


class LumaVideo:
    """A video file of one camera; frames are those of the pictures that are written, each with its moment.

    Parameters
    ----------
    path : Path
        Ends in `.mkv`; its folder is made.
    picture : SentPicture
        The first one, for size and coding.

    Raises
    ------
    CaptureError
        The file cannot be written, or the size is odd, which 4:2:0 does not allow.
    """

    def __init__(self, path: Path, picture: SentPicture) -> None:
        self._path = path
        columns, rows = picture.size
        if columns % 2 or rows % 2:
            raise CaptureError(f"{path}: {columns} x {rows} pixels; set the stream to a size of even numbers")
        self._layout = "yuv420p" if picture.coding.bits == 8 else f"yuv420p{picture.coding.bits}le"
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._container = av.open(str(path), "w")
        except OSError as error:
            raise CaptureError(f"{path}: cannot be written ({error.strerror}); give a writable folder") from error
        self._stream: Any = self._container.add_stream(CODEC, rate=25)  # pyright: ignore[reportUnknownMemberType]
        self._stream.width, self._stream.height, self._stream.pix_fmt = columns, rows, self._layout
        self._stream.codec_context.time_base = TIME_BASE
        self._stream.codec_context.color_range = FULL_RANGE if picture.coding.full_range else LIMITED_RANGE
        self._stream.codec_context.colorspace = BT_709 if picture.coding.luma_weights == LUMA_709 else BT_601
        self._last_ms = -1

    def write(self, _number: int, picture: SentPicture, since_first_s: float) -> None:
        """Write a picture; raises `CaptureError`.

        Parameters
        ----------
        picture : SentPicture
        since_first_s : float
            Time of exposure after the first one.
        """
        luma = picture.measured[:, :, 0]
        planes: NDArray[Any] = np.concatenate([luma.ravel(), _colour_differences(picture).ravel()])
        frame = av.VideoFrame.from_ndarray(planes.reshape(-1, luma.shape[1]), format=self._layout)
        self._last_ms = max(self._last_ms + 1, round(1000 * since_first_s))
        frame.pts, frame.time_base = self._last_ms, TIME_BASE
        self._mux(frame)

    def close(self) -> None:
        """Finish the file; raises `CaptureError`."""
        self._mux(None)
        self._container.close()

    def _mux(self, frame: av.VideoFrame | None) -> None:
        try:
            self._container.mux(self._stream.encode(frame))  # pyright: ignore[reportUnknownMemberType]
        except (FFmpegError, OSError) as error:
            raise CaptureError(f"{self._path}: cannot be written ({error}); make room, or write elsewhere") from error


def _colour_differences(picture: SentPicture) -> NDArray[np.uint8 | np.uint16]:
    """Cb, then Cr, at half resolution, in the picture's range (ITU-R BT.601-7, 2.5)."""
    coding: Coding = picture.coding
    red_weight, blue_weight = coding.luma_weights
    blue, green, red = (picture.shown[:, :, channel].astype(np.float32) for channel in range(3))
    luma = red_weight * red + blue_weight * blue + (1 - red_weight - blue_weight) * green
    span = 1.0 if coding.full_range else CHROMA_SPAN
    half = (picture.shown.shape[1] // 2, picture.shown.shape[0] // 2)
    planes = [
        cv2.resize((colour - luma) * (span / (2 * (1 - weight))), half, interpolation=cv2.INTER_AREA)
        for colour, weight in ((blue, blue_weight), (red, red_weight))
    ]
    codes = np.round((np.stack(planes) + 128) * (1 << coding.bits - 8))
    return np.clip(codes, 0, (1 << coding.bits) - 1).astype(picture.measured.dtype)
