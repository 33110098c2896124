"""What a picture is: 8 bit, grey or blue-green-red; the checks and the conversion that all parts of vision share."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]

COLOURED_RANGE, COLOURED_SHARE = 40, 0.1  # chosen: a tenth of the pixels, channels 40 codes apart: not nearly grey
TINTED_RANGE = 16  # chosen: of a palette's dark end; a grey camera's tint is less
PALETTE_COLOURS = 256  # of a palette of 8-bit values; four times as many pixels of a scene show more
LEAST_CORRELATION = 0.5  # chosen: channels of a scene's light rise together, those of a palette take turns


def check_shape(name: str, picture: NDArray[Any]) -> None:
    """Raise ValueError unless a picture is grey or has three channels, and is not empty.

    Parameters
    ----------
    name : str
        Of the argument, for the error's sentence.
    picture : ndarray

    Raises
    ------
    ValueError
        The shape is neither (rows, columns) nor (rows, columns, 3), or there are no pixels.
    """
    if picture.ndim not in {2, 3} or picture.shape[2:] not in {(), (3,)} or picture.size == 0:
        raise ValueError(f"{name}: shape {picture.shape} is neither (rows, columns) nor (rows, columns, 3), or empty")


def check_picture(name: str, picture: NDArray[Any], image_size: tuple[int, int] | None = None) -> None:
    """Raise ValueError unless a picture is 8 bit, grey or blue-green-red, and of the size that is wanted.

    Parameters
    ----------
    name : str
        Of the argument, for the error's sentence.
    picture : ndarray
    image_size : tuple of int, optional
        (columns, rows) that the camera was calibrated for; any size without it.

    Raises
    ------
    ValueError
        The picture is not of uint8, has another shape, or another size.
    """
    if picture.dtype != np.uint8:
        raise ValueError(f"{name}: a uint8 picture is needed, not of {picture.dtype}")
    check_shape(name, picture)
    size = (picture.shape[1], picture.shape[0])
    if image_size is not None and size != image_size:
        raise ValueError(
            f"{name}: the picture is {size[0]} x {size[1]}, "
            f"the rig was calibrated for {image_size[0]} x {image_size[1]}"
        )


def brightest_channel(picture: Picture) -> Picture:
    """The largest code value of each pixel of a picture, grey or with three channels."""
    if picture.ndim == 2:
        return picture
    blue, green, red = cv2.split(picture)  # numpy's maximum over the last axis takes 20 times longer
    return np.asarray(cv2.max(cv2.max(blue, green), red), dtype=np.uint8)


def grey(picture: Picture) -> Picture:
    """Grey picture, shape (rows, columns), of a grey or blue-green-red one: 0.299 R + 0.587 G + 0.114 B."""
    return picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)


def is_false_colour(picture: Picture) -> bool:
    """Whether a picture's colours are a palette's, as thermal cameras make them of one value a pixel.

    Light that grows makes all channels brighter. A palette lets channels rise and fall in turn, so that some two of
    them do not go together over the picture. One whose channels all rise, as of hot iron, is known by its few colours,
    as long as no coder has mixed them.

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    """
    if picture.ndim == 2:
        return False
    some = picture[::4, ::4].reshape(-1, 3).astype(np.float64)
    apart = np.ptp(some, axis=1)
    colours = np.unique(some @ [1.0, 256.0, 65536.0])
    if len(colours) <= PALETTE_COLOURS and len(some) >= 4 * PALETTE_COLOURS:
        return bool(np.mean(apart > TINTED_RANGE) >= COLOURED_SHARE)
    if np.mean(apart > COLOURED_RANGE) < COLOURED_SHARE:
        return False
    spread = some.std(axis=0) > 1.0
    correlation = np.corrcoef(some[:, spread].T) if spread.sum() > 1 else np.ones((1, 1))
    return bool(np.min(correlation) < LEAST_CORRELATION)
