"""Picture files with their coding: PNG, TIFF, BMP and PGM of 8 to 16 bits, JPEG with its luma, Bayer mosaics.

A picture that a file marks as turned (EXIF orientation) is turned as every viewer shows it.
"""

import json
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.cameras.recording.jpeg_header import JPEG_START, jpeg_is_whole, read_jpeg_header
from appliance.cameras.recording.native_messages import native_messages
from appliance.cameras.recording.other_formats import read_other_head
from appliance.cameras.source import CameraError
from appliance.errors import reading_advice
from vision.sent_picture import LUMA_601, MOSAICS, Codes, Coding, Mosaic, SentPicture, sent_picture

PNG_START = b"\x89PNG\r\n\x1a\n"
PNG_END = b"IEND"
PNG_HEAD_BYTES = 24  # up to columns and rows (ISO/IEC 15948, 11.2.2)
# chosen: about what the largest industrial cameras have; a file of a few bytes can announce 2^62 and more
MOST_PIXELS = 1 << 26
MOST_FILLING_BYTES = 64  # chosen: before a JPEG's end; more are left over when the data have slipped
SIGNIFICANT_BITS = b"sBIT"
CODING_FILE = "coding.json"


@dataclass(frozen=True, slots=True)
class ToldCoding:
    """What a file beside the pictures says of their coding where they cannot say it themselves.

    Attributes
    ----------
    bits : int or None
        Of a code value in files of 16 bits.
    mosaic : str or None
        Colours of a Bayer mosaic's first two rows' first two sites.
    """

    bits: int | None = None
    mosaic: Mosaic | None = None


UNTOLD = ToldCoding()


def read_told_coding(folder: Path) -> ToldCoding:
    """Read `coding.json` of a folder: `{"bits": 12, "mosaic": "RGGB"}`, each key optional; without a file, nothing.

    Raises
    ------
    CameraError
        The file cannot be read or says something else.
    """
    path = folder / CODING_FILE
    if not path.is_file():
        return UNTOLD
    try:
        values: dict[str, Any] = json.loads(path.read_text(encoding="utf-8-sig"))
        bits, mosaic = values.pop("bits", None), values.pop("mosaic", None)
    except (OSError, ValueError, AttributeError, TypeError, RecursionError) as error:
        raise CameraError(f"{path}: not a readable JSON object ({error}); correct it or remove it") from error
    if bits is not None and (type(bits) is not int or bits not in range(8, 17)):
        raise CameraError(f"{path}: bits is {bits!r}; give a whole number from 8 to 16")
    if mosaic is not None and mosaic not in MOSAICS:
        raise CameraError(f"{path}: mosaic is {mosaic!r}; give one of {', '.join(MOSAICS)}")
    if values:
        raise CameraError(f"{path}: {', '.join(values)} is not known; give bits and mosaic only")
    return ToldCoding(bits, mosaic)


def read_picture(path: Path, told: ToldCoding = UNTOLD) -> SentPicture:
    """Read a picture file with its coding.

    Parameters
    ----------
    path : Path
        PNG, JPEG, TIFF, BMP or PGM by its content, whatever its suffix.
    told : ToldCoding
        What the file itself cannot say.

    Returns
    -------
    SentPicture
        Of a JPEG file whose colours are subsampled, luma is measured; of others what they hold.

    Raises
    ------
    CameraError
        The file is missing, truncated, not a picture that its coding fits, or one of more than `MOST_PIXELS`.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CameraError(
            f"{path}: cannot be read ({error.strerror}); {reading_advice(error, 'check its name, and the disk')}"
        ) from error
    if not _is_whole(data):  # OpenCV fills what is missing of a truncated file with grey and calls it a picture
        raise CameraError(f"{path}: the file breaks off before the picture's end; copy or record it again")
    if _is_damaged(data):
        raise CameraError(f"{path}: a checksum does not fit, so the file is damaged; copy or record it again")
    columns, rows = _announced_size(data)
    if columns * rows > MOST_PIXELS:
        most = f"{MOST_PIXELS >> 20} million pixels are the most"
        raise CameraError(f"{path}: announces {columns} x {rows} pixels where {most}; copy or record it again")
    with native_messages() as said:
        picture = decoded_picture(data, told)
    if any(map(_tells_damage, said)):
        raise CameraError(f"{path}: its data do not decode, so the file is damaged; copy or record it again")
    if picture is None:
        raise CameraError(
            f"{path}: not a readable PNG, JPEG, TIFF, BMP or PGM of 8 to 16 bits; copy or record it again"
        )
    other = read_other_head(data)
    if other is not None and other.pictures > 1:
        raise CameraError(f"{path}: holds more than one picture; write each to a file of its own")
    return picture


def decoded_picture(data: bytes, told: ToldCoding = UNTOLD) -> SentPicture | None:
    """Picture of a file's bytes; None where they are none, or one of floating point.

    Parameters
    ----------
    data : bytes
    told : ToldCoding
        What the file itself cannot say.
    """
    header = read_jpeg_header(data) if data.startswith(JPEG_START) else None
    depth = cv2.IMREAD_ANYDEPTH if header is None else 0
    image = _decoded(data, cv2.IMREAD_ANYCOLOR | depth)
    if image is None or image.dtype not in {np.dtype(np.uint8), np.dtype(np.uint16)}:
        return None
    if header is None:
        return _lossless(image, told.bits or _stated_bits(data), told.mosaic)
    samples = "grey" if image.ndim == 2 else "colour"
    if header.subsampled and image.ndim == 3:
        luma = _decoded(data, cv2.IMREAD_GRAYSCALE)  # the decoder's own Y, not a mixture of its colours
        coding = Coding("luma", luma_weights=LUMA_601, compression="jpeg", quality=header.quality)
        return None if luma is None else sent_picture(luma, coding, np.asarray(image, np.uint8))
    return sent_picture(image, Coding(samples, compression="jpeg", quality=header.quality))


def _is_whole(data: bytes) -> bool:
    """Whether a PNG or JPEG file has its end; what a camera writes after it does not matter."""
    if data.startswith(PNG_START):
        return any(name == PNG_END for name, _, _ in _png_chunks(data))
    return jpeg_is_whole(data) if data.startswith(JPEG_START) else bool(data)


def _is_damaged(data: bytes) -> bool:
    """Whether a checksum of a PNG file does not fit; JPEG has none."""
    if not data.startswith(PNG_START):
        return False
    return any(zlib.crc32(name + content) != checksum for name, content, checksum in _png_chunks(data))


def _tells_damage(message: str) -> bool:
    """Whether a message of the JPEG decoder is of more than the few bytes with which cameras fill up a file."""
    if filling := re.search(r"(\d+) extraneous bytes before marker 0xd9", message):
        return int(filling[1]) > MOST_FILLING_BYTES
    return "Corrupt JPEG data" in message


def _png_chunks(data: bytes) -> Iterator[tuple[bytes, bytes, int]]:
    """Name, content and checksum of each chunk that is whole, up to the end (ISO/IEC 15948, 5.3)."""
    place = len(PNG_START)
    while place + 12 <= len(data):
        end = place + 8 + int.from_bytes(data[place : place + 4])
        if end + 4 > len(data):
            return
        name = data[place + 4 : place + 8]
        yield name, data[place + 8 : end], int.from_bytes(data[end : end + 4])
        if name == PNG_END:
            return
        place = end + 4


def _announced_size(data: bytes) -> tuple[int, int]:
    """Columns and rows that the head of a file announces; zeros where there is no such head."""
    if data.startswith(PNG_START) and len(data) >= PNG_HEAD_BYTES:
        return int.from_bytes(data[16:20]), int.from_bytes(data[20:24])
    header = read_jpeg_header(data) if data.startswith(JPEG_START) else read_other_head(data)
    return header.size if header else (0, 0)


def _decoded(data: bytes, flags: int) -> Codes | None:
    try:
        image: NDArray[Any] | None = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except cv2.error:  # of a head that cannot be, such as no columns
        return None
    return image


def _lossless(image: Codes, bits: int | None, mosaic: Mosaic | None) -> SentPicture:
    stored = 8 * image.dtype.itemsize
    bits = stored if bits is None or stored == 8 else bits
    if image.max() >= 1 << bits:  # stored at the top of the 16 bits, as the PNG standard wants it
        image = np.asarray(np.right_shift(image, stored - bits), np.uint16)
    if mosaic is not None and image.ndim == 2:
        return sent_picture(image, Coding("mosaic", bits, mosaic=mosaic))
    return sent_picture(image, Coding("grey" if image.ndim == 2 else "colour", bits))


def _stated_bits(data: bytes) -> int | None:
    """Bits of a code value as the file states them; None where it states none."""
    if data.startswith(PNG_START):
        return _png_bits(data)
    head = read_other_head(data)
    return head and head.bits


def _png_bits(data: bytes) -> int | None:
    """Significant bits that a PNG file states in its sBIT chunk (ISO/IEC 15948, 11.3.2.4)."""
    for name, content, _ in _png_chunks(data):
        if name == SIGNIFICANT_BITS and content:
            return max(content[:3])
        if name == b"IDAT":
            break
    return None
