"""Thinning of edge strength: the direction across an edge, and the ridge of its strength."""

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

NORMAL_RADIUS_PX = 4  # chosen, as in Dollar and Zitnick's code: radius of the triangle that smooths before directions
NORMAL_REACH_PX = NORMAL_RADIUS_PX + 1  # pixels further away do not change a direction
RIDGE_RADIUS_PX = 2  # chosen: a ridge is compared with strengths up to 2 pixels away across it
PLATEAU_TOLERANCE = np.float32(1.01)  # chosen: up to 1 % weaker than a neighbour still counts, so plateaus stay

_TRIANGLE = np.bartlett(2 * NORMAL_RADIUS_PX + 3)[1:-1]
_TRIANGLE /= _TRIANGLE.sum()

Floats = NDArray[np.float32]


def ridge_normals(strength: Floats) -> Floats:
    """Direction across the ridges of edge strength.

    Parameters
    ----------
    strength : ndarray of float32, shape (rows, columns)

    Returns
    -------
    ndarray of float32, shape (rows, columns)
        Angle from x towards y, [0, pi), of the direction in which the smoothed strength bends most; 0 where it is flat,
        and where there is no strength.
    """
    smooth = cv2.sepFilter2D(strength, cv2.CV_32F, _TRIANGLE, _TRIANGLE, borderType=cv2.BORDER_REFLECT)
    xx, yy, xy = (
        cv2.Sobel(smooth, cv2.CV_32F, dx, dy, ksize=3, borderType=cv2.BORDER_REPLICATE)
        for dx, dy in ((2, 0), (0, 2), (1, 1))
    )
    xx, yy, xy = (np.asarray(part, np.float32) for part in (xx, yy, xy))  # Sobel's three masks have the same gain
    return _normals(strength, xx, yy, xy)


@njit(nogil=True, cache=True)
def _normals(strength: Floats, xx: Floats, yy: Floats, xy: Floats) -> Floats:
    rows, columns = strength.shape
    normal = np.zeros((rows, columns), np.float32)
    for row in range(rows):
        for column in range(columns):
            if strength[row, column] <= 0:
                continue
            across, down = xx[row, column], yy[row, column]
            bend = 1.0 if across + down > 0 else -1.0  # hollow beside a ridge, bulging on it
            turn = 0.5 * np.arctan2(2 * bend * xy[row, column], bend * (across - down))
            folded = np.float32(np.mod(turn, np.pi))
            normal[row, column] = folded if folded < np.float32(np.pi) else np.float32(0)
    return normal


def ridges(strength: Floats, normal_rad: Floats, radius_px: int = RIDGE_RADIUS_PX) -> Floats:
    """Edge strength where none is greater across the edge (non-maximum suppression), 0 elsewhere.

    Parameters
    ----------
    strength : ndarray of float32, shape (rows, columns)
    normal_rad : ndarray of float32, shape (rows, columns)
        Direction across the edge, from x towards y.
    radius_px : int
        Distance up to which strengths across the edge are compared, pixels.

    Returns
    -------
    ndarray of float32, shape (rows, columns)
    """
    return _ridges(strength, normal_rad, radius_px)


@njit(nogil=True, cache=True)
def _ridges(strength: Floats, normal_rad: Floats, radius_px: int) -> Floats:
    rows, columns = strength.shape
    kept = np.zeros_like(strength)
    for row in range(rows):
        for column in range(columns):
            here = strength[row, column]
            if here <= 0:
                continue
            across, down = np.cos(normal_rad[row, column]), np.sin(normal_rad[row, column])
            if _is_highest(strength, row, column, down, across, radius_px):
                kept[row, column] = here
    return kept


@njit(nogil=True, cache=True)
def _is_highest(strength: Floats, row: int, column: int, down: float, across: float, radius_px: int) -> bool:
    """Whether nothing across the edge, up to so many pixels away, is clearly stronger."""
    most = strength[row, column] * PLATEAU_TOLERANCE
    for step in range(1, radius_px + 1):
        for side in (-step, step):
            if _between(strength, row + side * down, column + side * across) > most:
                return False
    return True


@njit(nogil=True, cache=True)
def _between(strength: Floats, row: float, column: float) -> float:
    """Bilinear between pixels; the border's values reach outwards."""
    rows, columns = strength.shape
    row, column = min(max(row, 0.0), rows - 1.001), min(max(column, 0.0), columns - 1.001)
    top, left = int(row), int(column)
    down, right = np.float32(row - top), np.float32(column - left)
    upper = strength[top, left] + right * (strength[top, left + 1] - strength[top, left])
    lower = strength[top + 1, left] + right * (strength[top + 1, left + 1] - strength[top + 1, left])
    return upper + down * (lower - upper)
