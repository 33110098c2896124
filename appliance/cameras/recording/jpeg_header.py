"""What a JPEG file says of its coding (ITU-T T.81, annex B)."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

START_OF_FRAME = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
QUANTISATION, START_OF_SCAN = 0xDB, 0xDA
JPEG_START, JPEG_END = b"\xff\xd8", b"\xff\xd9"
WITHOUT_LENGTH = {0x01, *range(0xD0, 0xD9)}
# Mean of T.81's example table K.1, which the Independent JPEG Group's library scales by quality
STANDARD_LUMA_MEAN = 57.625


class JpegHeader(NamedTuple):
    """Coding of a JPEG file.

    Attributes
    ----------
    components : int
        1 for grey, 3 for colour.
    subsampled : bool
        Whether a colour component has fewer samples than luma.
    quality : int or None
        1 to 100 on the scale of the Independent JPEG Group, from the luma table's mean; None without that table.
    size : tuple of int
        (columns, rows).
    """

    components: int
    subsampled: bool
    quality: int | None
    size: tuple[int, int]


def read_jpeg_header(data: bytes) -> JpegHeader | None:
    """Coding of a JPEG file, None where it has no frame header."""
    quality: int | None = None
    for marker, segment, _ in _segments(data):
        if marker == QUANTISATION:
            quality = _quality(segment) or quality
        elif marker in START_OF_FRAME and len(segment) >= 6:
            factors = [segment[7 + 3 * index] for index in range(segment[5]) if 7 + 3 * index < len(segment)]
            size = int.from_bytes(segment[3:5]), int.from_bytes(segment[1:3])
            return JpegHeader(len(factors), len(set(factors)) > 1, quality, size)
    return None


def jpeg_is_whole(data: bytes) -> bool:
    """Whether the end of the picture follows its first scan; what a camera writes after the end does not matter.

    A preview inside the file's head has an end of its own, which lies before the scan.
    """
    scan = max((end for _, _, end in _segments(data)), default=len(JPEG_START))
    return data.find(JPEG_END, scan) >= 0


def _segments(data: bytes) -> Iterator[tuple[int, bytes, int]]:
    """Markers with their segments and the places where these end, up to the first scan."""
    place = len(JPEG_START)
    while place + 4 <= len(data) and data[place] == 0xFF:
        marker = data[place + 1]
        if marker == 0xFF or marker in WITHOUT_LENGTH:
            place += 1 if marker == 0xFF else 2
            continue
        if marker == START_OF_SCAN:
            return
        length = int.from_bytes(data[place + 2 : place + 4])
        yield marker, data[place + 4 : place + 2 + length], place + 2 + length
        place += 2 + length


def _quality(segment: bytes) -> int | None:
    """Quality whose scaled standard table has the mean of table 0; None where the segment does not begin with it."""
    if len(segment) < 65 or segment[0] != 0:
        return None
    percent = 100 * float(np.mean(np.frombuffer(segment[1:65], np.uint8))) / STANDARD_LUMA_MEAN
    quality = (200 - percent) / 2 if percent <= 100 else 5000 / percent
    return int(np.clip(round(quality), 1, 100))
