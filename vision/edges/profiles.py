"""Light along straight lines across an edge, from raw pixels."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


def sample_profiles(
    picture: NDArray[np.uint8],
    channel: int,
    decode: NDArray[np.float32],
    point_px: Array,
    normal: Array,
    offsets_px: Array,
) -> Array:
    """Light along straight profiles, bilinear between pixel centres.

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns, channels)
    channel : int
        Index of the picture's colour channel.
    decode : ndarray of float32, shape (256,)
        Light of every code value.
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
    return _sample(picture, channel, decode, point_px, normal, offsets_px)


@njit(nogil=True, cache=True)
def _sample(picture, channel, decode, point, normal, offsets):
    rows, columns = picture.shape[0], picture.shape[1]
    light = np.empty((point.shape[0], offsets.shape[0]))
    for i in range(point.shape[0]):
        for j in range(offsets.shape[0]):
            x = point[i, 0] + offsets[j] * normal[i, 0]
            y = point[i, 1] + offsets[j] * normal[i, 1]
            if not (0.0 <= x <= columns - 1 and 0.0 <= y <= rows - 1):
                light[i, j] = np.nan
                continue
            column, row = min(int(x), columns - 2), min(int(y), rows - 2)
            right, down = x - column, y - row
            above = (1 - right) * decode[picture[row, column, channel]]
            above += right * decode[picture[row, column + 1, channel]]
            below = (1 - right) * decode[picture[row + 1, column, channel]]
            below += right * decode[picture[row + 1, column + 1, channel]]
            light[i, j] = (1 - down) * above + down * below
    return light
