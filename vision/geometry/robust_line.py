"""A straight line through points of which a third may be wrong."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.geometry.robust_constants import BIWEIGHT_TUNING, SIGMA_PER_MAD

Array = NDArray[np.float64]

REWEIGHTINGS = 6  # chosen: rounds of reweighted least squares


def robust_line(row: Array, column: Array) -> Array:
    """Line column = slope x row + start by Tukey's biweight, from the median slope between the outer thirds.

    Parameters
    ----------
    row, column : ndarray of float64, shape (n,)
        At least three points, rows not all the same; `row` increasing.

    Returns
    -------
    ndarray of float64, shape (2,)
        Slope and start.
    """
    return _fitted(np.ascontiguousarray(row), np.ascontiguousarray(column))


@njit(nogil=True, cache=True)
def _fitted(row, column):  # type: ignore[no-untyped-def]
    third = max(1, len(row) // 3)
    rise = np.median(row[-third:]) - np.median(row[:third])
    slope = (np.median(column[-third:]) - np.median(column[:third])) / rise
    start = np.median(column - slope * row)
    for _ in range(REWEIGHTINGS):
        residual = column - (slope * row + start)
        scale = BIWEIGHT_TUNING * max(SIGMA_PER_MAD * np.median(np.abs(residual)), 1e-9)
        ratio = np.minimum(np.abs(residual / scale), 1.0)
        weight = (1.0 - ratio**2) ** 2
        total = weight.sum()
        middle_row, middle_column = (weight * row).sum() / total, (weight * column).sum() / total
        away = weight * (row - middle_row)
        slope = (away * (column - middle_column)).sum() / (away * (row - middle_row)).sum()
        start = middle_column - slope * middle_row
    return np.array([slope, start])
