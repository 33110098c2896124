"""The picture of an ingot's end that classifiers judge: cut out of the camera's picture, grey, at one size."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.ingot.classifiers.similarity import SIZE, as_reference
from vision.ingot.end_finder import End

Picture = NDArray[np.uint8]


def end_image(picture: Picture, end: End) -> Picture:
    """The bottom square of an ingot, grey, at the size of the references.

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Grey, or blue-green-red.
    end : End

    Returns
    -------
    ndarray of uint8, shape (64, 64)
        The end's circle touches all four sides.
    """
    step = 2 * end.radius / SIZE
    first = (step - 1) / 2 - end.radius + 0.5
    crop = np.array([[step, 0, end.center_x + first], [0, step, end.center_y + first]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    square = cv2.warpAffine(picture, crop, (SIZE, SIZE), flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return as_reference(np.asarray(square, np.uint8))
