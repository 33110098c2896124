"""Medians and quantiles of a few hundred numbers: numpy's bits, without the 15 to 50 us that its checks take a call.

The gauge ranks some 200 such sets a frame.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def median(values: Array) -> float:
    """Median of all numbers; NaN where there is none, or one of them is NaN.

    It is one of numpy's numbers: a share of a median of 0, as of a black background, is infinite and raises nothing.
    """
    if not values.size:
        return math.nan
    low, high, last = (values.size - 1) // 2, values.size // 2, values.size - 1
    ranked = np.partition(values, (low, high, last), axis=None)  # NaN comes last
    return math.nan if np.isnan(ranked[last]) else np.float64(0.5 * (ranked[low] + ranked[high]))


def median_without_nan(values: Array) -> float:
    """Median of those numbers that are not NaN; NaN without any."""
    return median(values[~np.isnan(values)])


def column_medians(values: Array) -> Array:
    """Medians over the first axis.

    Parameters
    ----------
    values : ndarray of float64, shape (n, m), n at least 1

    Returns
    -------
    ndarray of float64, shape (m,)
        NaN for columns with NaN.
    """
    low, high, last = (len(values) - 1) // 2, len(values) // 2, len(values) - 1
    ranked = np.partition(np.ascontiguousarray(values.T), (low, high, last), axis=1)
    return np.where(np.isnan(ranked[:, last]), np.nan, 0.5 * (ranked[:, low] + ranked[:, high]))


def quantiles(values: NDArray[Any], shares: tuple[float, ...]) -> list[Array]:
    """Quantiles over the first axis, linear between ranks (the seventh of Hyndman and Fan, doi:10.2307/2684934).

    Parameters
    ----------
    values : ndarray of numbers, shape (n, ...), n at least 1
        Without NaN.
    shares : tuple of float
        0 to 1.

    Returns
    -------
    list of ndarray of float64, shape (...)
        One for each share.
    """
    ranked = np.sort(values, axis=0).astype(np.float64)
    return [_between_ranks(ranked, share * (len(ranked) - 1)) for share in shares]


def _between_ranks(ranked: Array, place: float) -> Array:
    low = int(place)
    below, above, part = ranked[low], ranked[min(low + 1, len(ranked) - 1)], place - low
    # from the nearer rank, so that the bits are numpy's
    return below + (above - below) * part if part < 0.5 else above - (above - below) * (1 - part)
