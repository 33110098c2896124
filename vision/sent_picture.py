"""A picture with its coding: what the camera sent, and what it looks like.

Colour is often sent at half the resolution of luma (4:2:0, 4:2:2): a red edge in the decoded colours is then blurred
and lies 0.05 to 0.09 px inwards. Luma is sent whole, so edges are measured in it and colours only say which is the
bar. More than 8 bits and Bayer mosaics are likewise measured as they are sent; what finds the bar sees 8 bits.
"""

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

Samples = Literal["grey", "colour", "luma", "mosaic"]
Compression = Literal["none", "jpeg", "video"]
Mosaic = Literal["RGGB", "GRBG", "GBRG", "BGGR"]

Codes = NDArray[np.uint8 | np.uint16]
Shown = NDArray[np.uint8]

MOSAICS: tuple[Mosaic, ...] = ("RGGB", "GRBG", "GBRG", "BGGR")
LUMA_601, LUMA_709 = (0.299, 0.114), (0.2126, 0.0722)  # weights of red and of blue, ITU-R BT.601-7 and BT.709-6
DEMOSAIC: dict[Mosaic, int] = {  # OpenCV names a mosaic by its second row's second and third pixel
    "RGGB": cv2.COLOR_BayerBG2BGR,
    "GRBG": cv2.COLOR_BayerGB2BGR,
    "GBRG": cv2.COLOR_BayerGR2BGR,
    "BGGR": cv2.COLOR_BayerRG2BGR,
}


@dataclass(frozen=True, slots=True)
class Coding:
    """What the measured code values of a picture mean.

    Attributes
    ----------
    samples : {"grey", "colour", "luma", "mosaic"}
        Grey; blue-green-red at whole resolution; luma of a picture whose colours are subsampled; one colour a site.
    bits : int
        Of a code value, 8 to 16.
    full_range : bool
        Whether black is 0 and white the largest code; else 16 and 235 of 255 (ITU-R BT.601).
    luma_weights : tuple of float
        Weights of red and of blue in luma; green has the rest.
    mosaic : {"RGGB", "GRBG", "GBRG", "BGGR"} or None
        Colours of the first two rows' first two sites.
    compression : {"none", "jpeg", "video"}
    quality : int or None
        Of a JPEG file, 1 to 100 on the scale of the Independent JPEG Group; None where it is unknown.
    quantiser : float or None
        Of an H.264 picture, QP as at 8 bits; None where it is unknown.
    """

    samples: Samples = "colour"
    bits: int = 8
    full_range: bool = True
    luma_weights: tuple[float, float] = LUMA_601
    mosaic: Mosaic | None = None
    compression: Compression = "none"
    quality: int | None = None
    quantiser: float | None = None

    def __post_init__(self) -> None:
        if not 8 <= self.bits <= 16:
            raise ValueError(f"bits: 8 to 16 are allowed, not {self.bits}")
        if (self.samples == "mosaic") != (self.mosaic is not None):
            raise ValueError(f"mosaic: {self.mosaic!r} does not go with samples {self.samples!r}")

    @property
    def black(self) -> int:
        """Code value of no light."""
        return 0 if self.full_range else 16 << (self.bits - 8)

    @property
    def white(self) -> int:
        """Code value of full scale."""
        return (1 << self.bits) - 1 if self.full_range else 235 << (self.bits - 8)

    @property
    def span_codes(self) -> float:
        """Code values from no light to full scale, of 8 bits."""
        return (self.white - self.black) / 2 ** (self.bits - 8)


@dataclass(frozen=True, slots=True, eq=False)
class SentPicture:
    """One picture of one camera.

    Attributes
    ----------
    shown : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Grey, or blue-green-red as OpenCV has it, full range: what finds the bar, and what people see.
    measured : ndarray of uint8 or uint16, shape (rows, columns, channels)
        Code values as they were sent, in which edges are located.
    coding : Coding
        Of `measured`.
    """

    shown: Shown
    measured: Codes
    coding: Coding

    @property
    def size(self) -> tuple[int, int]:
        """(columns, rows)."""
        return self.shown.shape[1], self.shown.shape[0]

    @classmethod
    def of(cls, image: "SentPicture | Codes") -> "SentPicture":
        """Return a picture of code values whose coding is told by their type alone: lossless, all bits used.

        Parameters
        ----------
        image : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
            A `SentPicture` is returned as it is.

        Raises
        ------
        ValueError
            Another type or shape.
        """
        if isinstance(image, SentPicture):
            return image
        if image.dtype not in {np.dtype(np.uint8), np.dtype(np.uint16)}:
            raise ValueError(f"image: a picture of uint8 or uint16 is needed, not of {image.dtype}")
        return sent_picture(image, Coding("colour" if image.ndim == 3 else "grey", 8 * image.dtype.itemsize))


def sent_picture(image: Codes, coding: Coding, shown: Shown | None = None) -> SentPicture:
    """SentPicture of code values as they were sent.

    Parameters
    ----------
    image : ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
        Grey, luma or a mosaic; or blue-green-red.
    coding : Coding
    shown : ndarray of uint8, optional
        What it looks like, needed for luma; else made of `image`.

    Returns
    -------
    SentPicture

    Raises
    ------
    ValueError
        Neither grey nor three channels, or colours where the coding has one sample a pixel.
    """
    if not (image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3)) or image.size == 0:
        raise ValueError(
            f"image: a picture, grey or with three channels, is needed, not an array of shape {image.shape}"
        )
    if (image.ndim == 3) != (coding.samples == "colour"):
        raise ValueError(f"{image.ndim - 1}-dimensional samples do not go with a coding of {coding.samples}")
    measured = np.ascontiguousarray(image if image.ndim == 3 else image[:, :, None])
    return SentPicture(_looks(image, coding) if shown is None else shown, measured, coding)


def _looks(image: Codes, coding: Coding) -> Shown:
    """8-bit grey or blue-green-red picture, full range."""
    scale = 255 / (coding.white - coding.black)
    if coding.bits == 8 and coding.full_range:
        eight = np.asarray(image, np.uint8)
    elif coding.full_range:
        eight = (image >> (coding.bits - 8)).astype(np.uint8)
    else:
        eight = np.asarray(cv2.convertScaleAbs(np.maximum(image, coding.black), None, scale, -scale * coding.black))
    if coding.mosaic is None:
        return eight.astype(np.uint8, copy=False)
    return np.asarray(cv2.cvtColor(eight, DEMOSAIC[coding.mosaic]), np.uint8)
