"""Edge points of all limbs together, and the rays that they are for a given rig."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Rig
from vision.sizing.cylinder import EdgeRays
from vision.sizing.limb import LimbPoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class EdgePoints:
    """Edge points in the raw pictures, n of them.

    Attributes
    ----------
    point_px : ndarray of float64, shape (n, 2)
        (x, y).
    view : ndarray of int64, shape (n,)
        0 left, 1 right camera.
    side : ndarray of float64, shape (n,)
        -1 on the limb at smaller x, +1 on the other.
    limb : ndarray of int64, shape (n,)
        Number of the limb, from 0.
    window : ndarray of int64, shape (n,)
        Number of the strip along the bar, from 0.
    """

    point_px: Array
    view: Index
    side: Array
    limb: Index
    window: Index

    @classmethod
    def of_limbs(cls, limbs: list[LimbPoints], first_y_mm: float, window_mm: float) -> Self:
        """Put the points of several limbs together.

        Parameters
        ----------
        limbs : list of LimbPoints
        first_y_mm : float
            Where window 0 begins.
        window_mm : float
            Length of a window along the line.
        """
        count = [len(limb.y_mm) for limb in limbs]
        y_mm = np.concatenate([limb.y_mm for limb in limbs])
        return cls(
            point_px=np.concatenate([limb.point_px for limb in limbs]),
            view=np.repeat([limb.view for limb in limbs], count),
            side=np.repeat([float(limb.side) for limb in limbs], count),
            limb=np.repeat(np.arange(len(limbs)), count),
            window=np.floor((y_mm - first_y_mm) / window_mm).astype(np.int64),
        )

    def only(self, index: Index) -> "EdgePoints":
        """Return the points of the given numbers."""
        return EdgePoints(
            self.point_px[index],
            self.view[index],
            self.side[index],
            self.limb[index],
            self.window[index],
        )

    def rays(self, rig: Rig) -> EdgeRays:
        """Rays through the points if the cameras are those of a rig."""
        origin = np.empty((len(self.view), 3))
        direction = np.empty_like(origin)
        focal = np.empty(len(self.view))
        for view, camera in enumerate((rig.left, rig.right)):
            mine = self.view == view
            origin[mine] = camera.centre_mm
            direction[mine] = camera.rays(self.point_px[mine])
            focal[mine] = camera.K[0, 0]
        return EdgeRays(origin, direction, self.side, focal, self.limb, self.window)

    def window_medians(self, values: Array, windows: int) -> Array:
        """Median of a value of the points over each window of each limb.

        Parameters
        ----------
        values : ndarray of float64, shape (n,)
            NaN for points that do not count.
        windows : int
            Number of windows; points beyond the last count to it.

        Returns
        -------
        ndarray of float64, shape (limbs, windows)
            NaN where a window has no points.
        """
        counting = np.isfinite(values)
        values = values[counting]
        strip = (self.limb * windows + np.minimum(self.window, windows - 1))[counting]
        order = np.lexsort((values, strip))
        count = np.bincount(strip, minlength=(int(self.limb.max()) + 1) * windows)
        first = np.cumsum(count) - count
        low, high = (first + np.maximum(count - 1, 0) // 2), first + count // 2
        ranked = np.append(values[order], np.nan)
        last = len(values)
        medians = 0.5 * (ranked[np.minimum(low, last)] + ranked[np.minimum(high, last)])
        return np.where(count > 0, medians, np.nan).reshape(-1, windows)
