"""One robust cylinder over the edge rays of both views.

A ray that grazes the bar is tangent to its cylinder: with axis point a, axis direction u, camera centre C and ray
direction v, the signed distance of the two lines is d = (a - C) . (u x v) / |u x v|, and s d = R with s = -1 on the
limb at smaller x and s = +1 on the other (docs/methods/diameter.md). No plane of measurement is assumed, and the
silhouette's bias (an edge is a tangent point, not the end of a diameter) does not arise.
"""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtri

from vision.geometry.robust_constants import BIWEIGHT_TUNING, SIGMA_PER_MAD
from vision.order_statistics import median, quantiles

Array = NDArray[np.float64]

CONVERGED_STEP = 1e-4  # mm and mm per mm: the fit has converged when no parameter changes by more
QUIET_SHARE = 0.25  # chosen: the quietest quarter of a limb's neighbouring points surely lies on the bar's own edge
LAG_POINTS = 4  # chosen: points of a limb this far apart, 4 px, share no blur, so that their noise is independent
# Chosen: the biweight's scale begins with the spread of all points (1.4826 MAD) and is multiplied by 0.7 in each of the
# first 8 steps, down to 0.6 of that spread or the quietest neighbours' scatter, so that the fit settles on the bar's
# edge.
NARROWING_ROUNDS, NARROWING_FACTOR, NARROWEST_FACTOR = 8, 0.7, 0.6
PLAIN_STEPS = 3  # Gauss-Newton steps without weights
LAG_WINDOWS = 6  # chosen: windows further apart than 120 mm share no hot air and no patch of scale
LEAST_WINDOWS = 2  # a single one shows no scatter along the bar
LEAST_LEFT = 0.3  # chosen: least share of the variance that the limbs' means leave; a few long waves tell little
LEAST_SCALE_PX = 0.02  # chosen: least scale of the biweight; a chance scatter below it would reject good points
LEAST_INWARDS = 1.1  # chosen: a smaller factor on residuals inwards is worth less than 0.01 px
LARGEST_CONDITION = 1e12  # of the scaled normal equations: beyond it the rays fix no cylinder


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
    return _tangent_distance(parameters, rays.origin_mm, rays.direction, rays.side)


@njit(nogil=True, cache=True)
def _tangent_distance(parameters, origin, direction, side):  # type: ignore[no-untyped-def]
    x0, z0, slope_x, slope_z, R = parameters
    gap, jacobian = np.empty(side.shape[0]), np.empty((side.shape[0], 5))
    for i in range(side.shape[0]):
        s = side[i]
        v_x, v_y, v_z = direction[i]
        w_x, w_y, w_z = x0 - origin[i, 0], -origin[i, 1], z0 - origin[i, 2]
        n_x, n_y, n_z = v_z - slope_z * v_y, slope_z * v_x - slope_x * v_z, slope_x * v_y - v_x  # u x v
        length = np.sqrt(n_x * n_x + n_y * n_y + n_z * n_z)
        d = (w_x * n_x + w_y * n_y + w_z * n_z) / length
        gap[i] = s * d - R
        jacobian[i, 0] = s * n_x / length
        jacobian[i, 1] = s * n_z / length
        # by u: v x w / |n| - (v x n) d / |n|^2
        jacobian[i, 2] = s * ((v_y * w_z - v_z * w_y) - (v_y * n_z - v_z * n_y) * d / length) / length
        jacobian[i, 3] = s * ((v_x * w_y - v_y * w_x) - (v_x * n_y - v_y * n_x) * d / length) / length
        jacobian[i, 4] = -1.0
    return gap, jacobian


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
    parameters = start
    near = _near_each_other(rays)
    scale_px, converged = np.inf, False
    for step_number in range(rounds):
        gap, jacobian = tangent_distance_mm(parameters, rays)
        pixel_per_mm = rays.pixel_per_radian / _depth_mm(parameters, rays)
        residual_px = gap * pixel_per_mm
        if step_number < NARROWING_ROUNDS:  # afterwards the scale is fixed, so that the steps converge
            wide_px = SIGMA_PER_MAD * median(np.abs(residual_px))
            narrow_px = max(LEAST_SCALE_PX, _local_scatter_px(residual_px, near), NARROWEST_FACTOR * wide_px)
            scale_px = max(narrow_px, NARROWING_FACTOR**step_number * wide_px)
        ratio = np.where(residual_px < 0, rays.inwards, 1.0) * residual_px / scale_px
        weight = _biweight(ratio)
        normal = _normal_equations(jacobian, weight * pixel_per_mm**2)
        if normal is None:
            return None
        if converged:
            gain = normal.solved(normal.weighted.T)
            influence = gain * gap * (weight.mean() / _slope(ratio).mean())
            covariance = _clustered_covariance(influence, rays)
            inwards_mm = 2 * (parameters[4] - _alike_radius_mm(rays, parameters, rounds))
            return CylinderFit(parameters, covariance, residual_px, pixel_per_mm, weight, scale_px, gain, inwards_mm)
        step = -normal.solved(normal.weighted.T @ gap)
        parameters = parameters + step
        converged = step_number >= NARROWING_ROUNDS and bool(np.all(np.abs(step) < CONVERGED_STEP))
    return None


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


def _local_scatter_px(residual_px: Array, near: NDArray[np.bool_]) -> float:
    """Standard deviation of the quietest residuals against those a few points further in the same window."""
    differences = np.abs(residual_px[LAG_POINTS:] - residual_px[:-LAG_POINTS])[near]
    if not differences.size:
        return 0.0
    return float(quantiles(differences, (QUIET_SHARE,))[0] / (np.sqrt(2) * ndtri((1 + QUIET_SHARE) / 2)))


def _depth_mm(parameters: Array, rays: EdgeRays) -> Array:
    to_axis = np.array([parameters[0], 0.0, parameters[1]]) - rays.origin_mm
    return np.maximum(np.einsum("ij,ij->i", to_axis, rays.direction), 1.0)


def _biweight(ratio: Array) -> Array:
    return np.where(np.abs(ratio) < BIWEIGHT_TUNING, (1 - (ratio / BIWEIGHT_TUNING) ** 2) ** 2, 0.0)


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
