"""Picture files with their coding: PNG, TIFF, BMP and PGM of 8 to 16 bits, JPEG with its luma, Bayer mosaics.

A picture that a file marks as turned (EXIF orientation) is turned as every viewer shows it.
"""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.cameras.recording.jpeg_header import read_jpeg_header
from appliance.cameras.source import CameraError
from vision.sent_picture import LUMA_601, MOSAICS, Codes, Coding, Mosaic, SentPicture, sent_picture

JPEG_START, JPEG_END = b"\xff\xd8", b"\xff\xd9"
PNG_END = b"IEND\xaeB`\x82"
PNG_START = b"\x89PNG\r\n\x1a\n"
SIGNIFICANT_BITS = b"sBIT"
TIFF_ORDERS: dict[bytes, Literal["little", "big"]] = {b"II*\0": "little", b"MM\0*": "big"}
TIFF_ENTRY_BYTES = 12
PGM_HEAD = re.compile(rb"P[25]\s+(?:#[^\n]*\n\s*)*\d+\s+(?:#[^\n]*\n\s*)*\d+\s+(?:#[^\n]*\n\s*)*(\d+)\s")
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
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # what it says of files that are broken is said by us


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
        values: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        bits, mosaic = values.pop("bits", None), values.pop("mosaic", None)
    except (OSError, ValueError, AttributeError, TypeError) as error:
        raise CameraError(f"{path}: not a readable JSON object ({error}); correct it or remove it") from error
    if bits is not None and bits not in range(8, 17):
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
        PNG, JPEG, TIFF, BMP or PGM by its content.
    told : ToldCoding
        What the file itself cannot say.

    Returns
    -------
    SentPicture
        Of a JPEG file whose colours are subsampled, luma is measured; of others what they hold.

    Raises
    ------
    CameraError
        The file is missing, truncated, or not a picture that its coding fits.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CameraError(f"{path}: cannot be read ({error.strerror}); check the disk and its permissions") from error
    # OpenCV fills what is missing of a truncated PNG or JPEG with grey and calls it a picture, of others it does not
    end = PNG_END if data.startswith(PNG_START) else JPEG_END if data.startswith(JPEG_START) else b""
    if not data or not data.rstrip(b"\0").endswith(end):
        raise CameraError(f"{path}: the file breaks off before the picture's end; copy or record it again")
    picture = decoded_picture(data, told)
    if picture is None:
        raise CameraError(
            f"{path}: not a readable PNG, JPEG, TIFF, BMP or PGM of 8 to 16 bits; copy or record it again"
        )
    if _pages(data) > 1:
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
    greatest = PGM_HEAD.match(data)
    return max(8, int(greatest[1]).bit_length()) if greatest else None


def _pages(data: bytes) -> int:
    """Pictures in a file; TIFF may hold several, each with the place of the next (TIFF 6.0, section 2)."""
    order = TIFF_ORDERS.get(data[:4])
    if order is None:
        return 1
    place, pages = int.from_bytes(data[4:8], order), 0
    while 0 < place < len(data) - 2 and pages < 2:
        pages += 1
        after = place + 2 + TIFF_ENTRY_BYTES * int.from_bytes(data[place : place + 2], order)
        place = int.from_bytes(data[after : after + 4], order)
    return pages


def _png_bits(data: bytes) -> int | None:
    """Significant bits that a PNG file states in its sBIT chunk (ISO/IEC 15948, 11.3.2.4)."""
    place = len(PNG_START)
    while place + 8 <= len(data):
        length, name = int.from_bytes(data[place : place + 4]), data[place + 4 : place + 8]
        if name == SIGNIFICANT_BITS and length:
            return max(data[place + 8 : place + 8 + min(length, 3)])
        if name == b"IDAT":
            return None
        place += 12 + length
    return None
