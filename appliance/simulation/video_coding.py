"""H.264 as a camera codes it."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.coding import Subsampling

Plane = NDArray[np.float32]
Matrix = Literal["601", "709"]

RED_BLUE_WEIGHT: dict[Matrix, tuple[float, float]] = {"601": (0.299, 0.114), "709": (0.2126, 0.0722)}
COLOUR_CODES: dict[Matrix, int] = {"601": 6, "709": 1}  # of ITU-T H.273, matrix coefficients
RATE_HZ = 25


@dataclass(frozen=True, slots=True)
class Video:
    """How a camera codes H.264.

    Attributes
    ----------
    crf : int
        Constant rate factor of x264: 0 loses nothing, 18, 23 and 28 are usual.
    subsampling : {"4:4:4", "4:2:0"}
    bits : {8, 10}
    full_range : bool
        Code values from 0 to full scale; else 16 to 235 of 255.
    matrix : {"601", "709"}
        Of ITU-R BT.
    """

    crf: int
    subsampling: Subsampling = "4:2:0"
    bits: int = 8
    full_range: bool = False
    matrix: Matrix = "709"

    def encoded(self, pictures: Sequence[NDArray[np.uint8]]) -> bytes:
        """Matroska file of blue-green-red pictures with an even number of rows and of columns."""
        file = io.BytesIO()
        with av.open(file, "w", format="matroska") as container:
            # x264's assembler codes equal pictures to other bits from run to run; without it a seed is one picture
            options = {"crf": str(self.crf), "preset": "medium", "x264-params": "asm=0"}
            stream = container.add_stream("libx264", rate=RATE_HZ, options=options)  # pyright: ignore[reportUnknownMemberType]  av's stub
            stream.height, stream.width = pictures[0].shape[:2]
            stream.pix_fmt = self._pixel_format
            stream.codec_context.thread_count = 1
            stream.codec_context.color_range = 2 if self.full_range else 1
            stream.codec_context.colorspace = COLOUR_CODES[self.matrix]
            stream.codec_context.time_base = Fraction(1, RATE_HZ)
            for number, picture in enumerate(pictures):
                frame = self._frame(picture)
                frame.pts = number
                container.mux(stream.encode(frame))  # pyright: ignore[reportUnknownMemberType]
            container.mux(stream.encode(None))  # pyright: ignore[reportUnknownMemberType]
        return file.getvalue()

    @property
    def _pixel_format(self) -> str:
        return f"yuv{self.subsampling.replace(':', '')}p" + ("10le" if self.bits == 10 else "")

    def _frame(self, picture: NDArray[np.uint8]) -> av.VideoFrame:
        planes = self.planes(picture)
        kind = np.uint8 if self.bits == 8 else np.dtype("<u2")
        frame = av.VideoFrame(picture.shape[1], picture.shape[0], self._pixel_format)
        for plane, values in zip(frame.planes, planes, strict=True):
            line = np.zeros((plane.height, plane.line_size), np.uint8)
            stored = values.astype(kind).view(np.uint8)
            line[:, : stored.shape[1]] = stored
            plane.update(line.tobytes())
        return frame

    def planes(self, picture: NDArray[np.uint8]) -> tuple[Plane, Plane, Plane]:
        """Whole-numbered Y, Cb and Cr as they are coded (ITU-R BT.601 and BT.709)."""
        blue, green, red = (picture[..., channel].astype(np.float32) / 255 for channel in range(3))
        red_weight, blue_weight = RED_BLUE_WEIGHT[self.matrix]
        luma = red_weight * red + (1 - red_weight - blue_weight) * green + blue_weight * blue
        step = float(1 << (self.bits - 8))
        luma_scale, chroma_scale, low = (255.0, 255.0, 0.0) if self.full_range else (219.0, 224.0, 16.0)
        chroma = [0.5 * (red - luma) / (1 - red_weight), 0.5 * (blue - luma) / (1 - blue_weight)]
        if self.subsampling == "4:2:0":
            size = (picture.shape[1] // 2, picture.shape[0] // 2)
            chroma = [np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA)) for part in chroma]
        top = float((1 << self.bits) - 1)
        cr, cb = (np.clip(np.rint(step * (128 + chroma_scale * part)), 0, top) for part in chroma)
        return np.rint(step * (low + luma_scale * luma)), cb, cr
