"""Medians and quantiles of a few hundred numbers: numpy's bits, without the 15 to 50 us that its checks take a call.

The gauge ranks some 200 such sets a frame.
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


def median(values: Array) -> float:
    """Median of all numbers; NaN where there is none, or one of them is NaN.

    It is one of numpy's numbers: a share of a median of 0, as of a black background, is infinite and raises nothing.
    """
    middle, counted = _middle(_numbers(values))
    return np.float64(middle) if counted == values.size > 0 else math.nan


def median_without_nan(values: Array) -> float:
    """Median of those numbers that are not NaN; NaN without any."""
    middle, counted = _middle(_numbers(values))
    return np.float64(middle) if counted else math.nan


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
    return _middles(np.ascontiguousarray(values))


def _numbers(values: NDArray[Any]) -> Array:
    """One layout and type, so that nothing is compiled twice."""
    return np.ascontiguousarray(values, dtype=np.float64).reshape(-1)


@njit(nogil=True, cache=True)
def _middle(values):  # type: ignore[no-untyped-def]
    """Median of the numbers that are not NaN, and how many they are."""
    ranked, count = np.empty(values.shape[0]), 0
    for value in values:
        if not np.isnan(value):
            ranked[count] = value
            count += 1
    return (_half_way(ranked[:count]) if count else np.nan), count


@njit(nogil=True, cache=True)
def _middles(values):  # type: ignore[no-untyped-def]
    rows, columns = values.shape
    middles, column = np.empty(columns), np.empty(rows)
    for number in range(columns):
        whole = True
        for row in range(rows):
            column[row] = values[row, number]
            whole = whole and not np.isnan(column[row])
        middles[number] = _half_way(column) if whole else np.nan
    return middles


@njit(nogil=True, cache=True)
def _half_way(values):  # type: ignore[no-untyped-def]
    """Mean of the two middle ranks; reorders the values (Hoare's selection)."""
    low, high, rank = 0, values.shape[0] - 1, (values.shape[0] - 1) // 2
    while low < high:
        pivot, i, j = values[(low + high) // 2], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if rank <= j:
            high = j
        elif rank >= i:
            low = i
        else:
            break
    following = values[rank] if values.shape[0] % 2 else values[rank + 1 :].min()
    return 0.5 * (values[rank] + following)


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
