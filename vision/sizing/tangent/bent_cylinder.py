"""A cylinder whose axis may be bowed across the line (camber), fitted to all edge rays.

The straight cylinder's residuals tell the bow; rays moved against it graze a straight bar, which is fitted again.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.sizing.tangent.cylinder_fit import CylinderFit, EdgeRays, fit_cylinder, tangent_distance_mm
from vision.sizing.tangent.edge_points import EdgePoints

Array = NDArray[np.float64]

BOW_SIGMAS = 4.0  # chosen: a bow of fewer standard uncertainties is that of the noise, and the axis is straight
BOW_ROUNDS = 2  # fits of the straightened rays
LEAST_BOW_MM = 0.05  # chosen: bow over half of the region below which the axis counts as straight


@dataclass(frozen=True, slots=True)
class Bow:
    """Curvature of the axis across the line.

    Attributes
    ----------
    per_mm : float
        Second derivative of x by y, 1/mm; positive where the ends lie at larger x than the middle.
    u_per_mm : float
        Standard uncertainty.
    """

    per_mm: float
    u_per_mm: float

    def clear(self, reach_mm: float) -> bool:
        """Whether it is more than noise and matters over `reach_mm` to either side."""
        return abs(self.per_mm) > BOW_SIGMAS * self.u_per_mm and abs(self.per_mm) * reach_mm**2 / 2 > LEAST_BOW_MM


UNSEEN_BOW = Bow(math.nan, math.nan)  # of one view, whose bar counts as straight


def axis_bow(fit: CylinderFit, points: EdgePoints, rays: EdgeRays) -> Bow:
    """Bow of the axis that the residuals of a straight cylinder call for.

    The gap of a ray at station y grows by -(dx) d(gap)/dx0 where the axis lies dx aside; dx = k y^2 / 2. The scatter is
    that of windows, as in the fit.

    Parameters
    ----------
    fit : CylinderFit
        With a straight axis.
    points : EdgePoints
    rays : EdgeRays
    """
    gap, jacobian = tangent_distance_mm(fit.parameters, rays)
    weight = fit.weight * fit.pixel_per_mm**2
    bent = -jacobian[:, 0] * points.station_mm**2 / 2
    root = np.sqrt(weight)
    design = jacobian * root[:, None] / np.abs(jacobian).max(axis=0)
    free = bent * root - design @ np.linalg.lstsq(design, bent * root, rcond=None)[0]
    square = float(free @ free)
    if not square > 0:
        return Bow(0.0, math.inf)
    per_mm = float(free @ (root * gap)) / square
    left = free * (root * gap - free * per_mm)
    strips = points.limb * (points.window.max() + 1) + points.window
    return Bow(per_mm, float(np.sqrt(np.sum(np.bincount(strips, left) ** 2)) / square))


def straightened(rays: EdgeRays, station_mm: Array, bow: Bow) -> EdgeRays:
    """Rays that graze a straight bar where the given ones graze the bowed one: each is moved against its axis' bow."""
    origin_mm = rays.origin_mm.copy()
    origin_mm[:, 0] -= bow.per_mm * station_mm**2 / 2
    return EdgeRays(origin_mm, rays.direction, rays.side, rays.pixel_per_radian, rays.limb, rays.window, rays.inwards)


@dataclass(frozen=True, slots=True, eq=False)
class BentCylinder:
    """A fitted cylinder, the rays that it was fitted to, and the bow of its axis.

    Attributes
    ----------
    fit : CylinderFit
    rays : EdgeRays
        Straightened where the axis is bowed.
    bow : Bow
    """

    fit: CylinderFit
    rays: EdgeRays
    bow: Bow


def fit_bent_cylinder(points: EdgePoints, rays: EdgeRays, start: Array, reach_mm: float) -> BentCylinder | None:
    """Fit a cylinder, bowed where the residuals call for it.

    Parameters
    ----------
    points : EdgePoints
    rays : EdgeRays
        Theirs.
    start : ndarray, shape (5,)
        First guess.
    reach_mm : float
        Half length of the measuring region.

    Returns
    -------
    BentCylinder or None
        None when the rays do not fix a cylinder.
    """
    fit = fit_cylinder(rays, start)
    if fit is None:
        return None
    bow = axis_bow(fit, points, rays)
    if not bow.clear(reach_mm):
        return BentCylinder(fit, rays, bow)
    bent, straight = fit, rays
    for _ in range(BOW_ROUNDS):  # the first fit has rejected the ends of a strongly bowed bar
        straight = straightened(rays, points.station_mm, bow)
        again = fit_cylinder(straight, bent.parameters)
        if again is None:
            return BentCylinder(fit, rays, bow)
        bent, more = again, axis_bow(again, points, straight)
        bow = Bow(bow.per_mm + more.per_mm, more.u_per_mm)
    return BentCylinder(bent, straight, bow)
