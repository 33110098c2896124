"""A laser's point of the bar's surface beside the limbs of one view or of two.

The point P lies on the cylinder where its gap g = |P - A| - R is 0, A being its foot on the axis. A cylinder p that two
views fix, with the covariance S of all parts of its budget, is combined with the point by the least variance (Gauss and
Markov; of one quantity alone, the mean by inverse variances):

    p' = p + K g,  K = - S J' / (J S J' + u_g^2),  J = dg/dp

A point that contradicts the views, |g| > 2 sqrt(J S J' + u_g^2), is not combined. One view fixes axis direction and
bearing, but no distance: there the point is one more ray, in the tangent plane of the cylinder at P, and the fit's only
measure of depth.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Rig
from vision.geometry.surface_point import SurfacePoint
from vision.sizing.tangent.bent_cylinder import BentCylinder
from vision.sizing.tangent.cylinder_fit import CylinderFit, EdgeRays, fit_cylinder
from vision.sizing.tangent.edge_points import EdgePoints
from vision.sizing.tangent.limb_finder import LimbPoints
from vision.sizing.tangent.section import SpotView, section_view
from vision.sizing.tangent.tangent_planes import TangentPlane
from vision.sizing.tangent.uncertainty_budget import (
    Circumstances,
    Solution,
    bar_motion,
    parameter_covariance,
    usual_ovality_mm,
)

Array = NDArray[np.float64]

MOST_OBLIQUE = 0.7  # chosen: a beam that passes the axis at more than 0.7 R meets the bar at over 45 degrees
COVERAGE_FACTOR = 2.0
ONE_VIEW_FITS = 3  # the point's tangent plane follows the cylinder; the second fit moves it by less than 1 um


def surface_gap(parameters: Array, point: SurfacePoint) -> tuple[float, Array, Array]:
    """Gap |P - A| - R of a point and a cylinder, its derivatives by the parameters, and the outward normal there.

    Parameters
    ----------
    parameters : ndarray of float64, shape (5,)
        See `CylinderFit.parameters`.
    point : SurfacePoint

    Returns
    -------
    gap_mm : float
    jacobian : ndarray of float64, shape (5,)
    outwards : ndarray of float64, shape (3,)
    """
    x0, z0, slope_x, slope_z, R = parameters
    u = np.array([slope_x, 1.0, slope_z]) / np.sqrt(1 + slope_x**2 + slope_z**2)
    from_axis = point.point_mm - np.array([x0, 0.0, z0])
    foot_mm = float(from_axis @ u)
    away = from_axis - foot_mm * u
    rho_mm = float(np.linalg.norm(away))
    n = away / rho_mm
    y_mm = foot_mm * u[1]
    return rho_mm - R, np.array([-n[0], -n[2], -n[0] * y_mm, -n[2] * y_mm, -1.0]), n


def _meets(parameters: Array, point: SurfacePoint) -> bool:
    """Whether the beam meets a cylinder, and not too obliquely."""
    x0, z0, slope_x, slope_z, R = parameters
    across = np.cross(point.beam, np.array([slope_x, 1.0, slope_z]))
    to_axis = np.array([x0, 0.0, z0]) - point.point_mm
    return abs(float(to_axis @ across)) <= MOST_OBLIQUE * R * float(np.linalg.norm(across))


def of_two_views(
    bent: BentCylinder, points: EdgePoints, rig: Rig, limbs: list[LimbPoints], known: Circumstances
) -> Solution:
    """The cylinder of two views, combined with the laser's point where the beam meets it.

    Parameters
    ----------
    bent : BentCylinder
    points : EdgePoints
        Points that it was fitted to.
    rig : Rig
    limbs : list of LimbPoints
    known : Circumstances
        With the point, if there is one.

    Returns
    -------
    Solution
    """
    fit, point = bent.fit, known.point
    section = section_view(fit, points, bent.rays)
    motion = np.zeros(5) if known.synchronous else bar_motion(fit, section.sideways)
    if point is None or not _meets(fit.parameters, point):
        return Solution(fit, section, motion)
    gap_mm, J, outwards = surface_gap(fit.parameters, point)
    S = parameter_covariance(fit, points, rig, limbs, known) + np.outer(motion, motion)
    radius_u_mm = usual_ovality_mm(fit, known) / 4 / math.sqrt(3)  # of an oval bar where the beam meets it: rectangular
    u2 = float(J @ S @ J) + point.u_mm**2 + radius_u_mm**2
    if abs(gap_mm) > COVERAGE_FACTOR * math.sqrt(u2):
        return Solution(fit, section, motion, gap_mm=gap_mm, agrees=False)
    K = -(S @ J) / u2
    change = np.eye(5) + np.outer(K, J)
    combined = replace(
        fit,
        parameters=fit.parameters + K * gap_mm,
        covariance=change @ fit.covariance @ change.T,
        gain=change @ fit.gain,
    )
    growth = 2 * float(K[4])
    section = section_view(combined, points, bent.rays, SpotView(growth, outwards))
    return Solution(combined, section, change @ motion, abs(growth) * point.u_mm, gap_mm)


def of_one_view(bent: BentCylinder, points: EdgePoints, known: Circumstances, shift: Array) -> Solution:
    """The cylinder of one view and the laser's point, from `fit_with_point`.

    Nothing contradicts the point but the rollers: an axis that is not R above them may be a wrong range, and counts in
    the uncertainty; see `bar_motion`.

    Parameters
    ----------
    bent : BentCylinder
    points : EdgePoints
        Points that it was fitted to.
    known : Circumstances
        With the point.
    shift : ndarray of float64, shape (5,)
        Change of the parameters per mm by which the point lies further outwards.

    Returns
    -------
    Solution
    """
    fit, point = bent.fit, known.point
    if point is None:
        raise ValueError("known: a point is wanted")
    gap_mm, _, outwards = surface_gap(fit.parameters, point)
    growth = 2 * float(shift[4])
    section = section_view(fit, points, bent.rays, SpotView(growth, outwards))
    wrong_range = bar_motion(fit, shift / (shift[1] - shift[4]))
    return Solution(fit, section, wrong_range, abs(growth) * point.u_mm, gap_mm)


def cylinder_of_one_view(planes: list[TangentPlane], point: SurfacePoint) -> Array | None:
    """Cylinder that both tangent planes of one view touch and on which a point lies.

    The planes share the camera's centre C and the axis' direction u = n_1 x n_2. The axis lies on their bisector, in
    the direction b, at R / sin(beta) from C; |P - A| = R is then quadratic in R, and the root nearer to the camera's
    side is the one whose surface faces it.

    Parameters
    ----------
    planes : list of two TangentPlane
        At smaller and at larger x.
    point : SurfacePoint

    Returns
    -------
    ndarray of float64, shape (5,), or None
        x0, z0, dx/dy, dz/dy, R; None without a cylinder that the beam meets.
    """
    u = np.cross(planes[0].normal, planes[1].normal)
    u = u / np.linalg.norm(u)
    if abs(u[1]) < 0.5:
        return None
    # n_i . (p - C) = s_i R with p = C + R w, w across u
    design = np.array([planes[0].normal, planes[1].normal, u])
    w = np.linalg.solve(design, np.array([planes[0].side, planes[1].side, 0.0]))
    to_point = point.point_mm - planes[0].centre_mm
    to_point = to_point - (to_point @ u) * u
    a, b, c = float(w @ w) - 1.0, -2 * float(w @ to_point), float(to_point @ to_point)
    root2 = b * b - 4 * a * c
    if a <= 0 or root2 < 0:
        return None
    R = (-b + math.sqrt(root2)) / (2 * a)  # the larger root: its axis lies behind the point
    if R <= 0:
        return None
    axis = planes[0].centre_mm + R * w
    axis = axis - axis[1] / u[1] * u
    cylinder = np.array([axis[0], axis[2], u[0] / u[1], u[2] / u[1], R])
    return cylinder if _meets(cylinder, point) else None


def fit_with_point(rays: EdgeRays, start: Array, point: SurfacePoint) -> tuple[CylinderFit, Array] | None:
    """Fit the cylinder of one view's edge rays on whose surface a point lies.

    Parameters
    ----------
    rays : EdgeRays
        Of both limbs of one view, n in all.
    start : ndarray of float64, shape (5,)
        First guess, with the point on it.
    point : SurfacePoint

    Returns
    -------
    fit : CylinderFit
        Of the n rays.
    shift : ndarray of float64, shape (5,)
        Change of the parameters per mm by which the point lies further outwards.
        None where the rays do not fix a cylinder.
    """
    parameters, fit = start, None
    for _ in range(ONE_VIEW_FITS):
        fit = fit_cylinder(_with_tangent_ray(rays, parameters, point), parameters)
        if fit is None:
            return None
        parameters = fit.parameters
    if fit is None:
        return None
    of_rays = replace(
        fit,
        residual_px=fit.residual_px[:-1],
        pixel_per_mm=fit.pixel_per_mm[:-1],
        weight=fit.weight[:-1],
        gain=fit.gain[:, :-1],
    )
    return of_rays, -fit.gain[:, -1]


def _with_tangent_ray(rays: EdgeRays, parameters: Array, point: SurfacePoint) -> EdgeRays:
    """The rays, and one across the bar in the cylinder's tangent plane at the point, as a limb of its own."""
    outwards = surface_gap(parameters, point)[2]
    u = np.array([parameters[2], 1.0, parameters[3]])
    across = np.cross(u / np.linalg.norm(u), outwards)
    return EdgeRays(
        np.vstack([rays.origin_mm, point.point_mm]),
        np.vstack([rays.direction, across]),
        np.append(rays.side, 1.0),
        np.append(rays.pixel_per_radian, 1.0),  # one pixel a millimetre; nothing else fixes the depth
        np.append(rays.limb, rays.limb.max() + 1),
        np.append(rays.window, rays.window[0]),
        np.append(rays.inwards, 1.0),
    )
