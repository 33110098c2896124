"""A point of the bar's surface that a one-point laser (range sensor) has measured along its calibrated ray."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SurfacePoint:
    """Where the laser's spot lies, in the world frame.

    Attributes
    ----------
    point_mm : ndarray of float64, shape (3,)
    beam : ndarray of float64, shape (3,)
        Unit vector from the sensor to the spot.
    u_mm : float
        Standard uncertainty (k = 1) of the point, alike in all directions: that of the range, and of the ray.
    """

    point_mm: Array
    beam: Array
    u_mm: float

    @classmethod
    def at(cls, origin_mm: Array, direction: Array, range_mm: float, u_mm: float) -> Self:
        """The point at a range along a ray.

        Parameters
        ----------
        origin_mm : ndarray of float64, shape (3,)
            Where the range is 0, in the world frame.
        direction : ndarray of float64, shape (3,)
            Of the beam, of any length but 0.
        range_mm : float
        u_mm : float
            Standard uncertainty (k = 1) of the point.
        """
        beam = np.asarray(direction, np.float64) / np.linalg.norm(direction)
        return cls(np.asarray(origin_mm, np.float64) + range_mm * beam, beam, u_mm)
