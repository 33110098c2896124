"""Lens distortion of Brown and Conrady, with its exact inverse and its derivatives."""

import numpy as np
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
    k1, k2, p1, p2, k3 = dist
    x, y = normalised[:, 0], normalised[:, 1]
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return np.column_stack(
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    )


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
    k1, k2, p1, p2, k3 = dist
    x, y = normalised[:, 0], normalised[:, 1]
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    growth = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
    across = growth * x * y + 2.0 * (p1 * x + p2 * y)
    slope = np.empty((len(x), 2, 2))
    slope[:, 0, 0] = radial + growth * x * x + 2.0 * p1 * y + 6.0 * p2 * x
    slope[:, 1, 1] = radial + growth * y * y + 6.0 * p1 * y + 2.0 * p2 * x
    slope[:, 0, 1] = slope[:, 1, 0] = across
    return slope


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
    ideal = np.array(distorted, dtype=np.float64)
    for _ in range(20):
        slope = distort_slope(ideal, dist)
        error = distort(ideal, dist) - distorted
        determinant = slope[:, 0, 0] * slope[:, 1, 1] - slope[:, 0, 1] * slope[:, 1, 0]
        determinant = np.where(determinant > 1e-6, determinant, np.nan)
        step_x = (slope[:, 1, 1] * error[:, 0] - slope[:, 0, 1] * error[:, 1]) / determinant
        step_y = (slope[:, 0, 0] * error[:, 1] - slope[:, 1, 0] * error[:, 0]) / determinant
        ideal -= np.column_stack([step_x, step_y])
        largest = np.nanmax(np.hypot(step_x, step_y), initial=0.0)
        if largest < 1e-12:
            break
    lost = ~(np.abs(distort(ideal, dist) - distorted).max(axis=1, initial=0.0) < 1e-11)
    ideal[lost] = np.nan
    return ideal
