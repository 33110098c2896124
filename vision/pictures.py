"""What a picture is: 8 bit, grey or blue-green-red; the checks and the conversion that all parts of vision share."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]

# Chosen: by how many code values blue exceeds red in a palette's cold colours, or red blue in its hot ones, and from
# which share of a picture's pixels on.
BLUE_CODES, BLUE_SHARE = 40, 0.1
VIOLET_CODES, VIOLET_SHARE = 12, 0.2
RED_CODES, RED_SHARE = 60, 0.005
BOTH_SHARE = 0.02  # of plain blue and of plain red beside each other


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


def grey(picture: Picture) -> Picture:
    """Grey picture, shape (rows, columns), of a grey or blue-green-red one: 0.299 R + 0.587 G + 0.114 B."""
    return picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)


def is_false_colour(picture: Picture) -> bool:
    """Whether a palette has coloured a picture, as thermal cameras can: from blue, or from violet to red or yellow.

    A palette's code values do not follow light: blue may stand for less than red although it is as bright. A line of
    hot steel under lamps is never plainly blue over a tenth of a picture.

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)

    Returns
    -------
    bool
        False for a grey picture.
    """
    if picture.ndim == 2:
        return False
    bluer = picture[..., 0].astype(np.int16) - picture[..., 2]
    blue, red = np.mean(bluer >= BLUE_CODES), np.mean(bluer <= -RED_CODES)
    violet = np.mean(bluer >= VIOLET_CODES) > VIOLET_SHARE and red > RED_SHARE
    return bool(blue > BLUE_SHARE or violet or (blue > BOTH_SHARE and red > BOTH_SHARE))
