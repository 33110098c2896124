"""One robust cylinder over the edge rays of both views.

A ray that grazes the bar is tangent to its cylinder: with axis point a, axis direction u, camera centre C and ray
direction v, the signed distance of the two lines is d = (a - C) . (u x v) / |u x v|, and s d = R with s = -1 on the
limb at smaller x and s = +1 on the other. Nothing else is assumed: no plane to guess, no silhouette to correct.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BIWEIGHT = 4.685  # 95 % efficient on Gaussian noise (Beaton and Tukey, doi:10.1080/00401706.1974.10489171)
STEP_END = 1e-6  # mm, and mm per mm
LEAST_SCALE_PX = 0.02  # a lucky small scatter must not reject good points


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
    """

    origin_mm: Array
    direction: Array
    side: Array
    pixel_per_radian: Array
    limb: NDArray[np.int64]
    window: NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class CylinderFit:
    """The cylinder and what its rays say of it.

    Attributes
    ----------
    parameters : ndarray of float64, shape (5,)
        x0, z0: axis at y = 0, mm; slopes dx/dy, dz/dy; radius R, mm.
    covariance : ndarray of float64, shape (5, 5)
        From the scatter of clusters, correlation within a cluster counted.
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
    """

    parameters: Array
    covariance: Array
    residual_px: Array
    pixel_per_mm: Array
    weight: Array
    scale_px: float
    gain: Array

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
    x0, z0, slope_x, slope_z, R = parameters
    u = np.array([slope_x, 1.0, slope_z])
    w = np.array([x0, 0.0, z0]) - rays.origin_mm
    v = rays.direction
    n = np.cross(u, v)
    length = np.linalg.norm(n, axis=1)
    d = np.einsum("ij,ij->i", w, n) / length
    by_u = np.cross(v, w) / length[:, None] - np.cross(v, n) * (d / length**2)[:, None]
    s = rays.side
    jacobian = np.column_stack(
        [s * n[:, 0] / length, s * n[:, 2] / length, s * by_u[:, 0], s * by_u[:, 2], -np.ones_like(s)]
    )
    return s * d - R, jacobian


def linear_start(rays: EdgeRays) -> Array:
    """First guess of the cylinder from one tangent plane per limb and view.

    The planes' normals are fitted to their rays; the axis direction is the smallest singular vector of the stacked
    normals; then n_i . (p - C_i) = s_i R is linear in p and R.

    Returns
    -------
    ndarray of float64, shape (5,)
    """
    normals, offsets, sides = [], [], []
    for limb in np.unique(rays.limb):
        mine = rays.limb == limb
        normal = np.linalg.svd(rays.direction[mine], full_matrices=False)[2][2]
        # towards smaller x, as u x v is when u runs along +y and v downwards
        normal = -normal if normal[0] > 0 else normal
        normals.append(normal)
        offsets.append(normal @ rays.origin_mm[mine][0])
        sides.append(rays.side[mine][0])
    stacked = np.array(normals)
    u = np.linalg.svd(stacked)[2][2]
    u = u / u[1]
    design = np.column_stack([stacked[:, 0], stacked[:, 2], -np.array(sides)])
    x0, z0, R = np.linalg.lstsq(design, np.array(offsets), rcond=None)[0]
    return np.array([x0, z0, u[0], u[2], R])


def fit_cylinder(rays: EdgeRays, start: Array | None = None, rounds: int = 50) -> CylinderFit | None:
    """Fit one cylinder to all edge rays, outliers weighted down by Tukey's biweight.

    Parameters
    ----------
    rays : EdgeRays
        At least one limb of each view and five rays in all.
    start : ndarray, shape (5,), optional
        First guess; `linear_start` by default.
    rounds : int
        Limit on Gauss-Newton steps.

    Returns
    -------
    CylinderFit or None
        None when the rays do not fix a cylinder.
    """
    parameters = linear_start(rays) if start is None else start
    converged = False
    for _ in range(rounds):
        gap, jacobian = tangent_distance_mm(parameters, rays)
        pixel_per_mm = rays.pixel_per_radian / _depth_mm(parameters, rays)
        residual_px = gap * pixel_per_mm
        scale_px = max(LEAST_SCALE_PX, 1.4826 * float(np.median(np.abs(residual_px))))
        weight = _biweight(residual_px / scale_px)
        gain = _gain(jacobian, weight * pixel_per_mm**2)
        if gain is None:
            return None
        if converged:
            influence = gain * gap * (weight.mean() / _slope(residual_px / scale_px).mean())
            covariance = _clustered_covariance(influence, rays)
            return CylinderFit(parameters, covariance, residual_px, pixel_per_mm, weight, scale_px, gain)
        step = -gain @ gap
        parameters = parameters + step
        converged = bool(np.all(np.abs(step) < STEP_END))
    return None


def _depth_mm(parameters: Array, rays: EdgeRays) -> Array:
    to_axis = np.array([parameters[0], 0.0, parameters[1]]) - rays.origin_mm
    return np.maximum(np.einsum("ij,ij->i", to_axis, rays.direction), 1.0)


def _biweight(ratio: Array) -> Array:
    return np.where(np.abs(ratio) < BIWEIGHT, (1 - (ratio / BIWEIGHT) ** 2) ** 2, 0.0)


def _slope(ratio: Array) -> Array:
    """Derivative of ratio times biweight: how fast an estimate follows its points (Huber, ISBN 0-471-41805-6, 6.6)."""
    square = (ratio / BIWEIGHT) ** 2
    return np.where(square < 1, (1 - square) * (1 - 5 * square), 0.0)


def _gain(jacobian: Array, weight: Array) -> Array | None:
    normal = jacobian.T @ (jacobian * weight[:, None])
    size = np.sqrt(np.diag(normal))
    if not np.all(size > 0):
        return None
    scaled = normal / np.outer(size, size)
    if np.linalg.cond(scaled) > 1e12:
        return None
    return np.linalg.solve(scaled, (jacobian * weight[:, None]).T / size[:, None]) / size[:, None]


def _clustered_covariance(influence: Array, rays: EdgeRays) -> Array:
    """Sandwich covariance, one sum per limb and window (Liang and Zeger, doi:10.1093/biomet/73.1.13)."""
    _, index = np.unique(rays.limb * (rays.window.max() + 1) + rays.window, return_inverse=True)
    count = int(index.max()) + 1
    sums = np.zeros((count, 5))
    np.add.at(sums, index, influence.T)
    return sums.T @ sums * (count / max(count - 5, 1))
