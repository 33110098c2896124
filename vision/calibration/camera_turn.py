"""The small turn that a camera has made since its calibration, from its still marks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.calibration.still_marks import MarksMotion
from vision.geometry.camera import Camera, rotation

Array = NDArray[np.float64]

STEP_RAD = 1e-4  # of the numerical derivatives


@dataclass(frozen=True, slots=True, eq=False)
class CameraTurn:
    """A turn about the camera's own projection centre.

    Attributes
    ----------
    omega : ndarray of float64, shape (3,)
        Rotation vector in the camera's own axes, radians.
    covariance : ndarray of float64, shape (3, 3)
        From the scatter of the marks.
    """

    omega: Array
    covariance: Array


NO_TURN = CameraTurn(np.zeros(3), np.zeros((3, 3)))


def camera_turn(camera: Camera, motion: MarksMotion) -> CameraTurn:
    """Turn that moves the marks as they have moved; none where they have moved by no more than their noise.

    Parameters
    ----------
    camera : Camera
        As it was calibrated.
    motion : MarksMotion

    Returns
    -------
    CameraTurn
        Where the sum of the marks' correlations is greatest, each a paraboloid about its own peak. `NO_TURN` where the
        motion is unknown or 0. The covariance is the sandwich over the marks (White, 10.2307/1912934), with one
        unknown in 2 m coordinates for each of the three.
    """
    if not motion.moved_px > 0.0:
        return NO_TURN
    seen = np.column_stack([camera.undistort(motion.place_px), np.ones(len(motion.place_px))])
    columns: list[Array] = []
    for axis in np.eye(3):
        ahead, back = (_pixels(camera, seen @ rotation(way * STEP_RAD * axis).T) for way in (1, -1))
        columns.append((ahead - back) / (2 * STEP_RAD))
    design = np.stack(columns, axis=2)  # of each mark: pixels along x and y by three angles
    inverse = np.linalg.inv(np.einsum("mia,mij,mjb->ab", design, motion.curvature, design))
    omega = inverse @ np.einsum("mia,mi->a", design, motion.slope)
    left = motion.slope - np.einsum("mij,mja,a->mi", motion.curvature, design, omega)
    scores = np.einsum("mia,mi->ma", design, left)
    coordinates = left.size
    covariance = inverse @ scores.T @ scores @ inverse * coordinates / max(coordinates - 3, 1)
    return CameraTurn(omega, covariance)


def _pixels(camera: Camera, seen: Array) -> Array:
    return camera.pixels(seen[:, :2] / seen[:, 2:])
