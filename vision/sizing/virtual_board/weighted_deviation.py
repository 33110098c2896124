"""Weighted deviation (algorithm 10): how far a window's diameter can be trusted, and which windows to discard."""

import numpy as np
from numpy.typing import NDArray

from vision.geometry.robust_constants import SIGMA_PER_MAD

Array = NDArray[np.float64]

JUMP_MADS = 6.0  # chosen: Sigma 6 robust standard deviations above its median has jumped; few good windows do
LEAST_SPREAD_SHARE = 0.25  # chosen, of the median Sigma: least standard deviation, so that like windows are all kept
ROUNDING_MM = 1e-6  # a smaller Sigma is rounding, which differs from run to run, and discards no window


def window_statistics(sampled_mm: Array) -> tuple[Array, Array]:
    """l_i and sigma_i of eq. 3.15, the sum over t in both.

    Parameters
    ----------
    sampled_mm : ndarray of float64, shape (windows, T)
        l_it: diameter of window i from sample t.

    Returns
    -------
    tuple of two ndarray of float64, shape (windows,)
        Mean and standard deviation over the T samples, mm; NaN where a sample is NaN.
    """
    return sampled_mm.mean(axis=1), sampled_mm.std(axis=1)


def similarity_ratio(areas: Array, uncorrupted_area: float) -> Array:
    """R_i of eq. 3.16: mean area of a window's current boundaries of interest over that of uncorrupted ones.

    Parameters
    ----------
    areas : ndarray of float64, shape (windows, n)
        A_ij, pixels.
    uncorrupted_area : float
        C, pixels.

    Returns
    -------
    ndarray of float64, shape (windows,)
    """
    return areas.mean(axis=1) / uncorrupted_area


def weighted_deviation(ratio: Array, deviation_mm: Array) -> Array:
    """Sigma_i = R_i^2 exp(R_i - 1) sigma_i, eq. 3.17 and 3.18, mm.

    Parameters
    ----------
    ratio : ndarray of float64, shape (windows,)
        R_i.
    deviation_mm : ndarray of float64, shape (windows,)
        sigma_i.

    Returns
    -------
    ndarray of float64, shape (windows,)
    """
    return ratio**2 * np.exp(np.minimum(ratio, 100.0) - 1.0) * deviation_mm


def trusted_windows(sigma_mm: Array) -> NDArray[np.bool_]:
    """Windows whose Sigma does not jump: at most six robust standard deviations above the frame's median.

    Parameters
    ----------
    sigma_mm : ndarray of float64, shape (windows,)
        Weighted deviations; NaN for windows without a diameter, which are not trusted.
    """
    there = np.isfinite(sigma_mm)
    if not there.any():
        return there
    middle = np.median(sigma_mm[there])
    spread = SIGMA_PER_MAD * np.median(np.abs(sigma_mm[there] - middle))
    limit = max(middle + JUMP_MADS * max(spread, LEAST_SPREAD_SHARE * middle), ROUNDING_MM)
    return there & (np.where(there, sigma_mm, np.inf) <= limit)
