"""One robust cylinder over the edge rays of both views.

A ray that grazes the bar is tangent to its cylinder: with axis point a, axis direction u, camera centre C and ray
direction v, the signed distance of the two lines is d = (a - C) . (u x v) / |u x v|, and s d = R with s = -1 on the
limb at smaller x and s = +1 on the other (docs/methods/diameter.md). No plane of measurement is assumed, and the
silhouette's bias (an edge is a tangent point, not the end of a diameter) does not arise.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.geometry.robust_constants import BIWEIGHT_TUNING
from vision.sizing.tangent.cylinder_steps import LAG_POINTS, LARGEST_CONDITION, robust_steps, tangent_distance

Array = NDArray[np.float64]

PLAIN_STEPS = 3  # Gauss-Newton steps without weights
LAG_WINDOWS = 6  # chosen: windows further apart than 120 mm share no hot air and no patch of scale
LEAST_WINDOWS = 2  # a single one shows no scatter along the bar
LEAST_LEFT = 0.3  # chosen: least share of the variance that the limbs' means leave; a few long waves tell little
LEAST_INWARDS = 1.1  # chosen: a smaller factor on residuals inwards is worth less than 0.01 px


@dataclass(frozen=True, slots=True, eq=False)
class EdgeRays:
    """Rays through edge points, n of them, in the world frame.

    Attributes
    ----------
    origin_mm : ndarray of float64, shape (n, 3)
        Camera centres.
    direction : ndarray of float64, shape (n, 3)
        Unit vectors from the camera to the scene.
    side : ndarray of float64, shape (n,)
        -1 on the limb at smaller x, +1 on the other.
    pixel_per_radian : ndarray of float64, shape (n,)
        Focal length of the view.
    limb : ndarray of int64, shape (n,)
        Which limb in which view a ray belongs to, from 0; its rays lie in one tangent plane.
    window : ndarray of int64, shape (n,)
        Strip along the bar; points of one limb and window may be correlated.
    inwards : ndarray of float64, shape (n,)
        Factor on residuals that point inwards, 1 to 2: a sliver of a dark patch along a limb moves its edge inwards, so
        such residuals get less weight.
    """

    origin_mm: Array
    direction: Array
    side: Array
    pixel_per_radian: Array
    limb: NDArray[np.int64]
    window: NDArray[np.int64]
    inwards: Array


@dataclass(frozen=True, slots=True, eq=False)
class CylinderFit:
    """The fitted cylinder, its covariance and the residuals of its rays.

    Attributes
    ----------
    parameters : ndarray of float64, shape (5,)
        x0, z0: axis at y = 0, mm; slopes dx/dy, dz/dy; radius R, mm.
    covariance : ndarray of float64, shape (5, 5)
        From the scatter of clusters, correlation within a cluster counted; NaN where no limb has points in two windows.
    residual_px : ndarray of float64, shape (n,)
        Distance of every edge point from its tangent, pixels, positive outwards.
    pixel_per_mm : ndarray of float64, shape (n,)
        Scale of the picture at the point of tangency.
    weight : ndarray of float64, shape (n,)
        Robust weight, 0 (rejected) to 1.
    scale_px : float
        Robust standard deviation of the residuals.
    gain : ndarray of float64, shape (5, n)
        Change of the parameters, sign reversed, per mm of gap: (J' W J)^-1 J' W.
    inwards_mm : float
        How far the diameter would shrink if residuals inwards counted as those outwards do.
    """

    parameters: Array
    covariance: Array
    residual_px: Array
    pixel_per_mm: Array
    weight: Array
    scale_px: float
    gain: Array
    inwards_mm: float = 0.0

    @property
    def diameter_mm(self) -> float:
        """Diameter, mm."""
        return float(2 * self.parameters[4])

    @property
    def u_diameter_mm(self) -> float:
        """Standard uncertainty of the diameter from the scatter of the edge points, mm."""
        return float(2 * np.sqrt(self.covariance[4, 4]))


def tangent_distance_mm(parameters: Array, rays: EdgeRays) -> tuple[Array, Array]:
    """Signed gap s d - R between every ray and the cylinder, and its derivatives.

    Parameters
    ----------
    parameters : ndarray, shape (5,)
        See `CylinderFit.parameters`.
    rays : EdgeRays

    Returns
    -------
    gap_mm : ndarray of float64, shape (n,)
        Positive where the ray misses the cylinder, negative where it cuts it.
    jacobian : ndarray of float64, shape (n, 5)
        Derivatives of the gap with respect to the parameters.
    """
    return tangent_distance(parameters, rays.origin_mm, rays.direction, rays.side)


def touched_points(parameters: Array, rays: EdgeRays) -> tuple[Array, Array]:
    """Points of the cylinder that rays touch or come nearest to, and the cylinder's outward normals there.

    Parameters
    ----------
    parameters : ndarray, shape (5,)
        See `CylinderFit.parameters`.
    rays : EdgeRays

    Returns
    -------
    points_mm, outwards : ndarray of float64, shape (n, 3)
    """
    x0, z0, slope_x, slope_z, R = parameters
    axis = np.array([x0, 0.0, z0])
    u = np.array([slope_x, 1.0, slope_z]) / np.sqrt(1 + slope_x**2 + slope_z**2)
    v, from_axis = rays.direction, rays.origin_mm - axis
    cosine = v @ u
    reach = (cosine * (from_axis @ u) - np.einsum("ij,ij->i", from_axis, v)) / (1 - cosine**2)
    nearest = from_axis + reach[:, None] * v
    outwards = nearest - np.outer(nearest @ u, u)
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    return axis + np.outer(nearest @ u, u) + R * outwards, outwards


def fit_cylinder(rays: EdgeRays, start: Array, rounds: int = 80) -> CylinderFit | None:
    """Fit one cylinder to all edge rays, outliers weighted down by Tukey's biweight.

    Parameters
    ----------
    rays : EdgeRays
        At least one limb of each view and five rays in all.
    start : ndarray, shape (5,)
        First guess.
    rounds : int
        Limit on Gauss-Newton steps.

    Returns
    -------
    CylinderFit or None
        None when the rays do not fix a cylinder.
    """
    arrays = rays.origin_mm, rays.direction, rays.side, rays.pixel_per_radian, rays.inwards, _near_each_other(rays)
    found, parameters, gap, jacobian, pixel_per_mm, residual_px, weight, scale_px = robust_steps(arrays, start, rounds)
    normal = _normal_equations(jacobian, weight * pixel_per_mm**2) if found else None
    if normal is None:
        return None
    ratio = np.where(residual_px < 0, rays.inwards, 1.0) * residual_px / scale_px
    gain = normal.solved(normal.weighted.T)
    influence = gain * gap * (weight.mean() / _slope(ratio).mean())
    covariance = _clustered_covariance(influence, rays)
    inwards_mm = 2 * (parameters[4] - _alike_radius_mm(rays, parameters, rounds))
    return CylinderFit(parameters, covariance, residual_px, pixel_per_mm, weight, scale_px, gain, inwards_mm)


def _alike_radius_mm(rays: EdgeRays, parameters: Array, rounds: int) -> float:
    """Radius of a fit that weights residuals inwards as it does those outwards."""
    if np.all(rays.inwards < LEAST_INWARDS):
        return float(parameters[4])
    fit = fit_cylinder(replace(rays, inwards=np.ones_like(rays.inwards)), parameters, rounds)
    return float(parameters[4]) if fit is None else float(fit.parameters[4])


def nearest_cylinder(rays: EdgeRays, start: Array) -> Array:
    """First guess for rays that all lie off a first guess, as those of a camera that has turned: plain least squares.

    Parameters
    ----------
    rays : EdgeRays
    start : ndarray, shape (5,)

    Returns
    -------
    ndarray of float64, shape (5,)
        `start` where the rays do not fix a cylinder.
    """
    parameters = start
    for _ in range(PLAIN_STEPS):
        gap, jacobian = tangent_distance_mm(parameters, rays)
        normal = _normal_equations(jacobian, np.ones(len(gap)))
        if normal is None:
            return start
        parameters = parameters - normal.solved(normal.weighted.T @ gap)
    return parameters


def _near_each_other(rays: EdgeRays) -> NDArray[np.bool_]:
    """Which points are in the same window as the one `LAG_POINTS` points further."""
    return (rays.limb[LAG_POINTS:] == rays.limb[:-LAG_POINTS]) & (rays.window[LAG_POINTS:] == rays.window[:-LAG_POINTS])


def _slope(ratio: Array) -> Array:
    """Derivative of ratio times biweight: how fast an estimate follows its points (Huber, ISBN 0-471-41805-6, 6.6)."""
    square = (ratio / BIWEIGHT_TUNING) ** 2
    return np.where(square < 1, (1 - square) * (1 - 5 * square), 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class _NormalEquations:
    """J' W J, scaled to a unit diagonal, and W J, shape (n, 5)."""

    scaled: Array
    size: Array
    weighted: Array

    def solved(self, right: Array) -> Array:
        """(J' W J)^-1 times the right side, shape (5,) or (5, n)."""
        return (np.linalg.solve(self.scaled, (right.T / self.size).T).T / self.size).T


def _normal_equations(jacobian: Array, weight: Array) -> _NormalEquations | None:
    """None when the rays do not fix a cylinder."""
    weighted = jacobian * weight[:, None]
    normal = jacobian.T @ weighted
    size = np.sqrt(np.diag(normal))
    if not np.all(size > 0):
        return None
    scaled = normal / np.outer(size, size)
    return _NormalEquations(scaled, size, weighted) if np.linalg.cond(scaled) <= LARGEST_CONDITION else None


def _clustered_covariance(influence: Array, rays: EdgeRays) -> Array:
    """Sandwich covariance, one sum per limb and window (Liang and Zeger, doi:10.1093/biomet/73.1.13).

    Where neighbouring windows of a limb move together, as hot air and patches of scale move them, all parts are widened
    by what the autocovariances over `LAG_WINDOWS` add to the radius' variance, with a flat-top taper
    (Politis, doi:10.1017/S0266466611000247).
    """
    limbs, windows = int(rays.limb.max()) + 1, int(rays.window.max()) + 1
    strip = rays.limb * windows + rays.window
    sums = np.stack([np.bincount(strip, part, limbs * windows) for part in influence], axis=-1)
    sums = sums.reshape(limbs, windows, len(influence))
    seen = np.any(sums != 0, axis=2)
    if seen.sum(axis=1).max() < LEAST_WINDOWS:
        return np.full((5, 5), np.nan)
    mean = sums.sum(axis=1, keepdims=True) / np.maximum(seen.sum(axis=1), 1)[:, None, None]
    away = np.where(seen[:, :, None], sums - mean, 0.0)  # a limb that lies off as a whole is no scatter
    alone = np.einsum("lwi,lwj->ij", away, away)
    radius = away[:, :, 4]
    together = float(alone[4, 4])
    for lag in range(1, min(LAG_WINDOWS, radius.shape[1])):
        taper = min(1.0, 2 - 2 * lag / LAG_WINDOWS)
        together += 2 * taper * float(np.sum(radius[:, lag:] * radius[:, :-lag]))
    widened = max(1.0, together / alone[4, 4]) if alone[4, 4] > 0 else 1.0
    taken = widened * len(seen) / max(np.count_nonzero(seen), 1)  # of the variance, by the limbs' own means
    widened /= max(1 - taken, LEAST_LEFT)
    count = np.count_nonzero(np.any(sums != 0, axis=2)) / widened  # windows that move on their own
    return alone * widened * (count / max(count - 5, 1))
