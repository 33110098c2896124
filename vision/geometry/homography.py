"""Homographies: points transformed, and the map from a horizontal plane to a camera's ideal picture."""

import numpy as np
from numpy.typing import NDArray

from vision.geometry.camera import Camera

Array = NDArray[np.float64]


def transformed(homography: Array, points: Array) -> Array:
    """Points after a homography.

    Parameters
    ----------
    homography : ndarray of float64, shape (3, 3)
    points : ndarray of float64, shape (..., 2)
        (x, y).

    Returns
    -------
    ndarray of float64, shape (..., 2)
    """
    moved = points @ homography[:, :2].T + homography[:, 2]
    return moved[..., :2] / moved[..., 2:]


def solved(homography: Array, right: Array) -> Array:
    """Inverse of a homography, times another.

    Parameters
    ----------
    homography, right : ndarray of float64, shape (3, 3)

    Returns
    -------
    ndarray of float64, shape (3, 3)
        homography^-1 right.
    """
    return np.asarray(np.linalg.solve(homography, right), dtype=np.float64)


def plane_to_ideal(camera: Camera, height_mm: float) -> Array:
    """Homography from (x, y), mm, on the plane z = height to the camera's ideal points.

    Parameters
    ----------
    camera : Camera
    height_mm : float
        Of the plane over the conveyor plane z = 0.

    Returns
    -------
    ndarray of float64, shape (3, 3)
    """
    return np.column_stack([camera.R[:, 0], camera.R[:, 1], camera.R[:, 2] * height_mm + camera.t])
