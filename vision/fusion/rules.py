"""Rules by which two coefficients become the fused picture's one."""

from typing import Any, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

Rule = Literal["larger", "weighted"]
Coefficients = NDArray[Any]


def fuse_coefficients(first: Coefficients, second: Coefficients, rule: Rule) -> None:
    """Fuse two arrays of coefficients into the first one.

    Parameters
    ----------
    first, second : ndarray of float32 or complex64, same shape, contiguous
        Coefficients of both views; `first` becomes the fused ones.
    rule : {"larger", "weighted"}
        The one of larger magnitude (at a tie the second, as algorithm 14 says), or the mean of both weighted by their
        magnitudes, (|a| a + |b| b) / (|a| + |b|), which is the former with a soft change from one view to the other.
    """
    keep = _keep_larger if rule == "larger" else _keep_weighted
    keep(first.reshape(-1, copy=False), second.reshape(-1, copy=False))


@njit(nogil=True, cache=True)
def _keep_larger(first: Coefficients, second: Coefficients) -> None:
    for i in range(first.size):
        a, b = first[i], second[i]
        larger = a.real * a.real + a.imag * a.imag > b.real * b.real + b.imag * b.imag
        first[i] = a if larger else b  # without a branch, which would be guessed wrong half of the time


@njit(nogil=True, cache=True)
def _keep_weighted(first: Coefficients, second: Coefficients) -> None:
    for i in range(first.size):
        a, b = first[i], second[i]
        weights = np.abs(a) + np.abs(b)
        first[i] = (np.abs(a) * a + np.abs(b) * b) / weights if weights > 0.0 else a
