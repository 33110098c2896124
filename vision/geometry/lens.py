"""Lens distortion of Brown and Conrady, with its exact inverse and its derivatives."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


def distort(normalised: NDArray[np.float64], dist: NDArray[np.float64]) -> NDArray[np.float64]:
    """Move ideal points to where the lens shows them.

    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), and y' likewise with p1 and p2 exchanged
    (Brown 1966; the form and the order of coefficients are OpenCV's).

    Parameters
    ----------
    normalised : ndarray of float64, shape (n, 2)
        x/z, y/z in the camera's frame.
    dist : ndarray of float64, shape (5,)
        k1, k2, p1, p2, k3.

    Returns
    -------
    ndarray of float64, shape (n, 2)
    """
    return _distort(np.ascontiguousarray(normalised, dtype=np.float64), np.asarray(dist, dtype=np.float64))


def distort_slope(normalised: NDArray[np.float64], dist: NDArray[np.float64]) -> NDArray[np.float64]:
    """Derivative of `distort` by the ideal points.

    Parameters
    ----------
    normalised : ndarray of float64, shape (n, 2)
    dist : ndarray of float64, shape (5,)

    Returns
    -------
    ndarray of float64, shape (n, 2, 2)
        Row: distorted x, y; column: ideal x, y.
    """
    return _distort_slope(np.ascontiguousarray(normalised, dtype=np.float64), np.asarray(dist, dtype=np.float64))


def undistort(distorted: NDArray[np.float64], dist: NDArray[np.float64]) -> NDArray[np.float64]:
    """Invert `distort` by Newton's method.

    Parameters
    ----------
    distorted : ndarray of float64, shape (n, 2)
    dist : ndarray of float64, shape (5,)

    Returns
    -------
    ndarray of float64, shape (n, 2)
        Exact to 1e-12; NaN where the lens model shows no point, or only one beyond the fold of its polynomial.
    """
    return _undistort(np.ascontiguousarray(distorted, dtype=np.float64), np.asarray(dist, dtype=np.float64))


# Compiled loops: one point after the other.


@njit(nogil=True, cache=True)
def _shown(x, y, dist):  # type: ignore[no-untyped-def]
    k1, k2, p1, p2, k3 = dist
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return (
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    )


@njit(nogil=True, cache=True)
def _slopes(x, y, dist):  # type: ignore[no-untyped-def]
    """Derivatives of the shown x by x and of the shown y by y, and the mixed one."""
    k1, k2, p1, p2, k3 = dist
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    growth = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
    return (
        radial + growth * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
        radial + growth * y * y + 6.0 * p1 * y + 2.0 * p2 * x,
        growth * x * y + 2.0 * (p1 * x + p2 * y),
    )


@njit(nogil=True, cache=True)
def _distort(normalised, dist):  # type: ignore[no-untyped-def]
    shown = np.empty_like(normalised)
    for i in range(normalised.shape[0]):
        shown[i, 0], shown[i, 1] = _shown(normalised[i, 0], normalised[i, 1], dist)
    return shown


@njit(nogil=True, cache=True)
def _distort_slope(normalised, dist):  # type: ignore[no-untyped-def]
    slope = np.empty((normalised.shape[0], 2, 2))
    for i in range(normalised.shape[0]):
        slope[i, 0, 0], slope[i, 1, 1], across = _slopes(normalised[i, 0], normalised[i, 1], dist)
        slope[i, 0, 1] = slope[i, 1, 0] = across
    return slope


@njit(nogil=True, cache=True)
def _undistort(distorted, dist):  # type: ignore[no-untyped-def]
    ideal = np.empty_like(distorted)
    for i in range(distorted.shape[0]):
        x, y = distorted[i]
        for _ in range(20):
            along_x, along_y, across = _slopes(x, y, dist)
            determinant = along_x * along_y - across * across
            if not determinant > 1e-6:
                x = np.nan
                break
            shown_x, shown_y = _shown(x, y, dist)
            off_x, off_y = shown_x - distorted[i, 0], shown_y - distorted[i, 1]
            step_x = (along_y * off_x - across * off_y) / determinant
            step_y = (along_x * off_y - across * off_x) / determinant
            x, y = x - step_x, y - step_y
            if np.hypot(step_x, step_y) < 1e-12:
                break
        shown_x, shown_y = _shown(x, y, dist)
        if not max(abs(shown_x - distorted[i, 0]), abs(shown_y - distorted[i, 1])) < 1e-11:
            x, y = np.nan, np.nan
        ideal[i, 0], ideal[i, 1] = x, y
    return ideal
