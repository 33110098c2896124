"""A straight line through points of which most may be wrong."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


TRIED_PAIRS = 80  # chosen: lines through two of the points that are tried


def consensus_line(y: Array, x: Array, tolerance: float) -> tuple[Array, NDArray[np.bool_]]:
    """Straight line x(y) on which most points agree, found even when most of them lie elsewhere.

    Parameters
    ----------
    y, x : ndarray of float64, shape (n,)
    tolerance : float
        Largest distance from the line, in x, at which a point agrees.

    Returns
    -------
    line : ndarray of float64, shape (2,)
        Slope and intercept: least squares through the points that agree; NaN with fewer than two points.
    agrees : ndarray of bool, shape (n,)
    """
    line = _best_pair(y, x, tolerance)
    for _ in range(3):
        agrees = np.abs(x - line[0] * y - line[1]) <= tolerance
        if np.count_nonzero(agrees) < 2:
            break
        off_y = y[agrees] - y[agrees].mean()
        slope = off_y @ x[agrees] / max(float(off_y @ off_y), 1e-12)
        line = np.array([slope, x[agrees].mean() - slope * y[agrees].mean()])
    return line, np.abs(x - line[0] * y - line[1]) <= tolerance


@njit(nogil=True, cache=True)
def _best_pair(y, x, tolerance):
    """Line through the pair of points with which most points agree; the pairs are the same for the same points."""
    count, best = y.shape[0], -1
    line = np.full(2, np.nan)
    for trial in range(TRIED_PAIRS):
        first = (trial * 7919) % max(count, 1)
        second = (first + count // 4 + (trial * 104729) % max(count // 2, 1)) % max(count, 1)
        if count < 2 or y[first] == y[second]:
            continue
        slope = (x[second] - x[first]) / (y[second] - y[first])
        intercept = x[first] - slope * y[first]
        agreeing = 0
        for i in range(count):
            agreeing += abs(x[i] - slope * y[i] - intercept) <= tolerance
        if agreeing > best:
            best = agreeing
            line[0], line[1] = slope, intercept
    return line
