"""Video files by their planes: luma is measured as it was sent, whatever colours are made of it for people."""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.error import FFmpegError
from av.video.frame import PictureType
from numpy.typing import NDArray

from appliance.cameras.source import CameraError
from vision.sent_picture import LUMA_601, LUMA_709, Codes, Coding, SentPicture, sent_picture

FULL_RANGE = 2  # AVCOL_RANGE_JPEG
BT_709 = 1  # ITU-T H.273, matrix coefficients
UNSPECIFIED = 2
HD_ROWS = 720  # what is not specified is BT.709 from here on, as players take it
QUANTISERS = {"export_side_data": "venc_params"}  # has the decoder say how coarsely each picture was quantised
H264_PARAMETERS = 1  # AV_VIDEO_ENC_PARAMS_H264
COARSEST_PERCENT = 97.0  # chosen: a bar's edges or a board's lie in 6 % of a picture's blocks
BITS_QUANTISER = 6  # by which every bit over 8 raises QP at the same step of light


class VideoFile:
    """Frames of a video file in their order; they are counted by decoding, because containers' stamps mislead.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    announced : int
        Number of frames as the header has it, else of its packets: a recorder that was cut off leaves no length.

    Raises
    ------
    CameraError
        The file cannot be opened, or holds no video.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._open()
        self.announced = self._container.streams.video[0].frames or self._count_packets()

    def read(self, position: int) -> SentPicture | None:
        """SentPicture at a position from 0; None after the end.

        Raises
        ------
        CameraError
            It cannot be decoded.
        """
        if position < self._position:
            self.close()
            self._open()
        try:
            while self._position < position:
                next(self._frames)
                self._position += 1
            frame = next(self._frames)
        except StopIteration:
            return None
        except FFmpegError as error:
            sentence = f"{self.path}: frame {position} cannot be decoded; copy or record the video again"
            raise CameraError(sentence) from error
        self._position += 1
        return turned(picture_of_frame(frame, self._quantiser.of(frame)), frame.rotation)

    def close(self) -> None:
        """Let go of the file."""
        self._container.close()

    def _count_packets(self) -> int:
        packets = self._container.demux(self._container.streams.video[0])
        count = sum(packet.size > 0 for packet in packets)
        self.close()
        self._open()
        return count

    def _open(self) -> None:
        try:
            self._container = av.open(str(self.path))
            stream = self._container.streams.video[0]
        except (FFmpegError, IndexError) as error:
            sentence = f"{self.path}: cannot be opened as a video; copy or record it again"
            raise CameraError(sentence) from error
        stream.thread_type = "AUTO"
        stream.codec_context.options = QUANTISERS
        self._quantiser = QuantiserWatch()
        self._frames: Iterator[av.VideoFrame] = self._container.decode(stream)
        self._position = 0


class QuantiserWatch:
    """How coarsely a stream's edges were quantised, frame by frame.

    Frames between two key frames mostly repeat what stood still, as the key frame left it: its quantiser counts.
    """

    def __init__(self) -> None:
        self._last: float | None = None

    def of(self, frame: av.VideoFrame) -> float | None:
        """QP of the coarsest blocks, as at 8 bits, of the last key frame; None where no decoder says it (H.264 does).

        Coders quantise blocks with edges more coarsely than flat ones.

        Parameters
        ----------
        frame : av.VideoFrame
            The next of its stream.
        """
        if self._last is None or frame.pict_type == PictureType.I:
            self._last = _quantiser(frame)
        return self._last


def picture_of_frame(frame: av.VideoFrame, quantiser: float | None = None) -> SentPicture:
    """SentPicture of a decoded frame: of luma and colour differences luma is measured, else what the frame holds.

    Parameters
    ----------
    frame : av.VideoFrame
        Of any pixel format; range and matrix as its stream states them, else limited range, and BT.709 from 720 rows.
    quantiser : float, optional
        As `QuantiserWatch` has it.
    """
    layout = frame.format
    whole = all(part.width == frame.width and part.height == frame.height for part in layout.components)
    bits = layout.components[0].bits
    if layout.is_rgb or (whole and len(layout.components) == 3 and bits == 8):
        return sent_picture(_converted(frame, "bgr24"), Coding("colour", compression="video", quantiser=quantiser))
    grey = len(layout.components) < 3
    coding = Coding(
        samples="grey" if grey else "luma",
        bits=bits,
        full_range=layout.name.startswith("yuvj") or grey or frame.color_range == FULL_RANGE,
        luma_weights=_luma_weights(frame),
        compression="video",
        quantiser=quantiser,
    )
    return sent_picture(_luma(frame, bits), coding, None if grey else _converted(frame, "bgr24"))


def turned(picture: SentPicture, rotation_deg: int) -> SentPicture:
    """Picture as it is meant to be shown.

    Parameters
    ----------
    picture : SentPicture
    rotation_deg : int
        Against the clock, as the file's display matrix has it (ISO/IEC 14496-12, 8.3.2).
    """
    quarters = round(rotation_deg / 90) % 4
    if quarters == 0:
        return picture
    shown = np.ascontiguousarray(np.rot90(picture.shown, quarters))
    return SentPicture(shown, np.ascontiguousarray(np.rot90(picture.measured, quarters)), picture.coding)


def _quantiser(frame: av.VideoFrame) -> float | None:
    beside: Any = frame.side_data
    try:
        content = bytes(beside["VIDEO_ENC_PARAMS"])
    except KeyError:
        return None
    # AVVideoEncParams and its AVVideoBlockParams of FFmpeg's libavutil/video_enc_params.h
    count, offset, size, kind, base = struct.unpack_from("@INNii", content)
    if kind != H264_PARAMETERS or not count:
        return None
    blocks = np.frombuffer(content, np.int32, count * size // 4, offset).reshape(count, -1)
    above_8_bits = frame.format.components[0].bits - 8
    return base + float(np.percentile(blocks[:, 4], COARSEST_PERCENT)) - BITS_QUANTISER * above_8_bits


def _luma_weights(frame: av.VideoFrame) -> tuple[float, float]:
    matrix = int(frame.colorspace)
    if matrix == UNSPECIFIED:
        return LUMA_709 if frame.height >= HD_ROWS else LUMA_601
    return LUMA_709 if matrix == BT_709 else LUMA_601


def _luma(frame: av.VideoFrame, bits: int) -> Codes:
    """First plane, without the padding of its lines."""
    plane = frame.planes[0]
    kind = np.dtype(np.uint8) if bits == 8 else np.dtype("<u2")
    lines: Codes = np.frombuffer(bytes(plane), kind).reshape(plane.height, plane.line_size // kind.itemsize)
    return np.ascontiguousarray(lines[:, : frame.width])


def _converted(frame: av.VideoFrame, layout: str) -> NDArray[np.uint8]:
    image: NDArray[Any] = frame.to_ndarray(format=layout)
    return np.asarray(image, np.uint8)
