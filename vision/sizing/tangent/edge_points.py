"""Edge points of all limbs (edges of the bar) together, and their rays for a given rig (camera calibration)."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Rig
from vision.sizing.tangent.cylinder_fit import EdgeRays
from vision.sizing.tangent.limb_finder import LimbPoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]

PATCHY_SHARE = 0.3  # chosen: where 30 % of a limb's profiles cross patches, residuals inwards count twice


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
    station_mm : ndarray of float64, shape (n,)
        y of the bar's point that is seen.
    window : ndarray of int64, shape (n,)
        Number of the strip along the bar, from 0.
    inwards : ndarray of float64, shape (n,)
        Factor on residuals that point inwards, 1 to 2; see `EdgeRays`.
    """

    point_px: Array
    view: Index
    side: Array
    limb: Index
    station_mm: Array
    window: Index
    inwards: Array

    @classmethod
    def from_limbs(cls, limbs: list[LimbPoints], stations_mm: list[Array], first_y_mm: float, window_mm: float) -> Self:
        """Put the points of several limbs together.

        Parameters
        ----------
        limbs : list of LimbPoints
        stations_mm : list of ndarray of float64
            y of the bar's points that the limbs' points show.
        first_y_mm : float
            Where window 0 begins.
        window_mm : float
            Length of a window along the line.
        """
        count = [len(limb.place_mm) for limb in limbs]
        y_mm = np.concatenate(stations_mm)
        return cls(
            point_px=np.concatenate([limb.point_px for limb in limbs]),
            view=np.repeat([limb.view for limb in limbs], count),
            side=np.repeat([float(limb.side) for limb in limbs], count),
            limb=np.repeat(np.arange(len(limbs)), count),
            station_mm=y_mm,
            window=np.maximum(np.floor((y_mm - first_y_mm) / window_mm), 0).astype(np.int64),
            inwards=np.repeat([1 + min(1.0, limb.uneven_share / PATCHY_SHARE) for limb in limbs], count),
        )

    def only(self, index: Index) -> "EdgePoints":
        """Return the points of the given numbers."""
        return EdgePoints(
            self.point_px[index],
            self.view[index],
            self.side[index],
            self.limb[index],
            self.station_mm[index],
            self.window[index],
            self.inwards[index],
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
        return EdgeRays(origin, direction, self.side, focal, self.limb, self.window, self.inwards)

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
