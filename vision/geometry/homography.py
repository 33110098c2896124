"""Homographies: points transformed, and the map from a horizontal plane to a camera's ideal picture."""

import numpy as np
from numpy.typing import NDArray

from vision.geometry.camera import Camera

Array = NDArray[np.float64]


def transformed(homography: Array, points: Array) -> Array:
    """Points (x, y), shape (..., 2), after a homography."""
    moved = points @ homography[:, :2].T + homography[:, 2]
    return moved[..., :2] / moved[..., 2:]


def solved(homography: Array, of: Array) -> Array:
    """Inverse of a homography, times another."""
    return np.asarray(np.linalg.solve(homography, of), dtype=np.float64)


def plane_to_ideal(camera: Camera, height_mm: float) -> Array:
    """Homography from (x, y), mm, on the plane z = height to the camera's ideal points."""
    return np.column_stack([camera.R[:, 0], camera.R[:, 1], camera.R[:, 2] * height_mm + camera.t])
