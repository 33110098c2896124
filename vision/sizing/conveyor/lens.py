"""Radial distortion of a camera that nobody calibrated, from lines that are straight in space (the plumb line method).

Brown (1971) fits the lens so that straight lines become straight. The model has one parameter, Fitzgibbon's
(doi:10.1109/CVPR.2001.990465): a point at the radius r from the picture's middle, in half widths of the picture,
belongs at r / (1 + lambda r^2).
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import optimize

Array = NDArray[np.float64]
Plane = NDArray[np.float32]

LEAST_BEND_PX = 0.1  # chosen: lines that are straighter are not corrected; noise makes 0.03 px
LEAST_GAIN_FACTOR = 2.0  # chosen: a lens is believed only if correcting it makes the lines straighter by this factor
MOST_BENDING = 0.3  # chosen: bound of lambda either way; the picture's corners move by 47 % of their radius
ROUNDING_PX = 0.01  # chosen: residuals below it are rounding, and do not make lambda more certain
GRID_VALUES = 31  # chosen: first guesses over the range of lambda


@dataclass(frozen=True, slots=True)
class Lens:
    """How a lens bends lines.

    Attributes
    ----------
    bending : float
        lambda; negative for a barrel, 0 for a lens that bends nothing.
    u_bending : float
        Its standard uncertainty; 0 where nothing is corrected.
    """

    bending: float = 0.0
    u_bending: float = 0.0

    def straightened(self, light: Plane) -> Plane:
        """A picture as a lens that bends nothing would show it, 0 where that lies outside; shape (rows, columns)."""
        if self.bending == 0.0:
            return light
        rows, columns = light.shape
        across = (np.arange(columns) - (columns - 1) / 2) * 2 / columns
        down = (np.arange(rows) - (rows - 1) / 2) * 2 / columns
        ideal = self.bending * (across**2 + down[:, None] ** 2)
        factor = 2 / (1 + np.sqrt(np.maximum(1 - 4 * ideal, 0)))  # the root of r_ideal (1 + lambda r^2) = r near 1
        map_x = (columns - 1) / 2 + factor * across * columns / 2
        map_y = (rows - 1) / 2 + factor * down[:, None] * columns / 2
        seen = cv2.remap(light, map_x.astype(np.float32), map_y.astype(np.float32), cv2.INTER_CUBIC)
        return np.clip(seen, 0, 1, dtype=np.float32)


def ideal_points(points_px: Array, bending: float, shape: tuple[int, ...]) -> Array:
    """Places at which a lens that bends nothing would show points.

    Parameters
    ----------
    points_px : ndarray of float64, shape (n, 2)
        (x, y).
    bending : float
        lambda.
    shape : tuple of int
        Rows and columns of the picture.

    Returns
    -------
    ndarray of float64, shape (n, 2)
    """
    rows, columns = shape
    middle = np.array([(columns - 1) / 2, (rows - 1) / 2])
    off = points_px - middle
    square = (off**2).sum(axis=1, keepdims=True) * (2 / columns) ** 2
    return middle + off / (1 + bending * square)


def plumb_line(lines_px: list[Array], shape: tuple[int, ...]) -> Lens:
    """The lens that makes lines straight.

    Parameters
    ----------
    lines_px : list of ndarray of float64, shape (n, 2)
        Points (x, y) along each of two or more upright lines that are straight in space.
    shape : tuple of int
        Rows and columns of the picture.

    Returns
    -------
    Lens
        One that bends nothing where the lines are straight already or no lens makes them much straighter.
    """

    def bends(values: Array) -> Array:
        return np.concatenate([_off_straight(ideal_points(line, float(values[0]), shape)) for line in lines_px])

    grid = np.linspace(-MOST_BENDING, MOST_BENDING, GRID_VALUES)
    start = min(grid.tolist(), key=lambda value: float(np.sum(bends(np.array([value])) ** 2)))
    bound = MOST_BENDING * 1.01
    found = optimize.least_squares(bends, [start], bounds=(-bound, bound))
    before_px, after_px = (float(np.sqrt(np.mean(residual**2))) for residual in (bends(np.zeros(1)), found.fun))
    if before_px < LEAST_BEND_PX or before_px < LEAST_GAIN_FACTOR * after_px or abs(found.x[0]) > MOST_BENDING:
        return Lens()
    u_bending = max(after_px, ROUNDING_PX) / float(np.linalg.norm(found.jac))
    return Lens(float(found.x[0]), u_bending)


def _off_straight(points: Array) -> Array:
    x, y = points.T
    y = y - y.mean()
    return x - np.polyval(np.polyfit(y, x, 1), y)
