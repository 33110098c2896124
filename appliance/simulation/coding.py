"""What a camera sends of a picture: JPEG, deeper PNG and Bayer mosaics, filtered before that if it does so."""

import struct
import zlib
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8 | np.uint16]
Subsampling = Literal["4:4:4", "4:2:0"]
Mosaic = Literal["RGGB", "GRBG", "GBRG", "BGGR"]

SAMPLING: dict[Subsampling, int] = {
    "4:4:4": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    "4:2:0": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
}
FILTER_RADIUS_PX = 1.0


def jpeg(picture: NDArray[np.uint8], quality: int, subsampling: Subsampling = "4:4:4") -> bytes:
    """JPEG file of a grey or blue-green-red picture."""
    options = [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, SAMPLING[subsampling]]
    return cv2.imencode(".jpg", picture, options)[1].tobytes()


def deep_png(picture: NDArray[np.uint16], bits: int) -> bytes:
    """PNG file of 16 bits a sample that says in its sBIT chunk how many of them count.

    Parameters
    ----------
    picture : ndarray of uint16, shape (rows, columns) or (rows, columns, 3)
        Values below 2**bits; they are stored as they are, as cameras' software does.
    bits : int
    """
    data = cv2.imencode(".png", picture)[1].tobytes()
    text = b"sBIT" + bytes([bits] * (1 if picture.ndim == 2 else 3))
    chunk = struct.pack(">I", len(text) - 4) + text + struct.pack(">I", zlib.crc32(text))
    header_end = 8 + 4 + 4 + 13 + 4  # signature; length, name, data and checksum of IHDR
    return data[:header_end] + chunk + data[header_end:]


def mosaic(picture: Picture, pattern: Mosaic) -> Picture:
    """What a sensor with colour filters sees of a blue-green-red picture: one channel at each site."""
    sites = np.empty(picture.shape[:2], picture.dtype)
    for site, colour in enumerate(pattern):
        part = slice(site // 2, None, 2), slice(site % 2, None, 2)
        sites[part] = picture[(*part, "BGR".index(colour))]
    return sites


def filtered(picture: NDArray[np.uint8], strength: float) -> NDArray[np.uint8]:
    """Picture after a filter on its code values, as many cameras have.

    Parameters
    ----------
    picture : ndarray of uint8
    strength : float
        Share of the difference to the smoothed picture that is added; above 0 sharpens, below 0 smooths.
    """
    smooth = cv2.GaussianBlur(picture, (0, 0), FILTER_RADIUS_PX).astype(np.float32)
    return np.clip(np.rint(picture + strength * (picture - smooth)), 0, 255).astype(np.uint8)
