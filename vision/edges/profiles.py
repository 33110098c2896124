"""Light along straight lines across an edge, from raw pixels."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.light_planes import LightPlane, bilinear_light
from vision.sent_picture import Codes

Array = NDArray[np.float64]


def sample_profiles(
    picture: Codes,
    plane: LightPlane,
    point_px: Array,
    normal: Array,
    offsets_px: Array,
) -> Array:
    """Light along straight profiles, bilinear between pixel centres.

    Parameters
    ----------
    picture : ndarray of uint8 or uint16, shape (rows, columns, channels)
        Code values as they were sent.
    plane : LightPlane
        Which of them count, and their light.
    point_px : ndarray of float64, shape (n, 2)
        Middles of the profiles, (x, y).
    normal : ndarray of float64, shape (n, 2)
        Unit vectors along which they run, (x, y).
    offsets_px : ndarray of float64, shape (m,)
        Offsets of the samples from the middle of each profile.

    Returns
    -------
    ndarray of float64, shape (n, m)
        NaN outside the image.
    """
    return _sample(picture, plane.compiled, point_px, normal, offsets_px)


@njit(nogil=True, cache=True)
def _sample(picture, plane, point, normal, offsets):
    rows, columns = picture.shape[0], picture.shape[1]
    light = np.empty((point.shape[0], offsets.shape[0]))
    for i in range(point.shape[0]):
        for j in range(offsets.shape[0]):
            x = point[i, 0] + offsets[j] * normal[i, 0]
            y = point[i, 1] + offsets[j] * normal[i, 1]
            if not (0.0 <= x <= columns - 1 and 0.0 <= y <= rows - 1):
                light[i, j] = np.nan
                continue
            light[i, j] = bilinear_light(picture, plane, x, y)
    return light
