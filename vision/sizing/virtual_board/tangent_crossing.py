"""Where the tangents of two cameras cross: the exact model of a round bar in its section plane.

Seen from a camera, the edges of a bar are tangents and not the ends of a diameter. In the section plane, with the
camera at distance d from the axis, the two tangents leave the line to the axis by b, sin b = R / d. On a plane at any
height they cut out a width; the widths of both views have a common middle on one plane only, and there R, the axis'
height and its place across follow from that height, the mean width and the common middle.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_NEWTON_STEPS = 30
CONVERGED_STEP_MM = 1e-9
DIFFERENCE_STEP_MM = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """Round bar in its section plane.

    Attributes
    ----------
    across_mm, height_mm, radius_mm : float
        Place of the axis across the bar, its height, and R.
    diameter_per_width : float
        Change of the diameter per mm of mean width on the plane, its height kept.
    width_mm : ndarray of float64, shape (2,)
        Width of each view on the plane.
    """

    across_mm: float
    height_mm: float
    radius_mm: float
    diameter_per_width: float
    width_mm: Array


def tangent_cuts(cameras_mm: Array, section: Array, plane_mm: float) -> Array:
    """Where the tangents of each camera cut the plane z = `plane_mm`.

    Parameters
    ----------
    cameras_mm : ndarray of float64, shape (2, 2)
        Per camera: place across the bar and height, above the bar.
    section : ndarray of float64, shape (3,)
        Place of the axis across, its height, radius; mm.
    plane_mm : float

    Returns
    -------
    ndarray of float64, shape (2, 2)
        Per camera the place across of the edge at smaller and at larger x; NaN where the camera lies inside the bar or
        a tangent runs level.
    """
    return _cuts(np.ascontiguousarray(cameras_mm), np.ascontiguousarray(section), plane_mm)


def solve_section(cameras_mm: Array, plane_mm: float, width_mm: float, middle_mm: float) -> Section | None:
    """Bar whose outlines share their middle on a plane, from their mean width there.

    For two cameras alike on either side the tangents cross at R / cos g from the axis, on a plane R sin b / cos g above
    it, and the width there is 2 R cos b / cos g, g being half the angle between the views and sin b = R / d. On other
    rigs each view's own angle counts, and only the whole model has it.

    Parameters
    ----------
    cameras_mm : ndarray of float64, shape (2, 2)
        Per camera: place across the bar and height.
    plane_mm : float
        Height at which the middles coincide.
    width_mm : float
        Mean width of both views on that plane.
    middle_mm : float
        Their common middle.

    Returns
    -------
    Section or None
        None when no bar below both cameras does that.
    """
    cameras_mm = np.ascontiguousarray(cameras_mm)
    target = np.array([width_mm, 0.0, middle_mm])
    section = np.array([middle_mm, plane_mm, 0.5 * width_mm])
    for _ in range(MOST_NEWTON_STEPS):
        residual = _seen(cameras_mm, section, plane_mm) - target
        slope = _slope(cameras_mm, section, plane_mm)
        if not (np.all(np.isfinite(slope)) and np.all(np.isfinite(residual))) or abs(np.linalg.det(slope)) < 1e-12:
            return None
        step = np.asarray(np.linalg.solve(slope, residual), dtype=np.float64)
        section = section - step
        if np.abs(step).max() < CONVERGED_STEP_MM:
            cuts = tangent_cuts(cameras_mm, section, plane_mm)
            gain = np.linalg.inv(slope)[2, 0]
            across, height, radius = section.tolist()
            return Section(across, height, radius, float(2 * gain), cuts[:, 1] - cuts[:, 0])
    return None


@njit(nogil=True, cache=True)
def _cuts(cameras_mm, section, plane_mm):  # type: ignore[no-untyped-def]
    across, height, radius = section
    cuts = np.full((2, 2), np.nan)
    for view in range(2):
        away, above = across - cameras_mm[view, 0], cameras_mm[view, 1] - height
        half = np.arcsin(radius / np.hypot(away, above))
        for edge in range(2):
            angle = np.arctan2(away, above) + (2 * edge - 1) * half
            if abs(angle) < 0.5 * np.pi:
                cuts[view, edge] = cameras_mm[view, 0] + (cameras_mm[view, 1] - plane_mm) * np.tan(angle)
    return cuts


@njit(nogil=True, cache=True)
def _seen(cameras_mm, section, plane_mm):  # type: ignore[no-untyped-def]
    """Mean width, difference of the middles, mean of the middles."""
    cuts = _cuts(cameras_mm, section, plane_mm)
    first, second = 0.5 * (cuts[0, 0] + cuts[0, 1]), 0.5 * (cuts[1, 0] + cuts[1, 1])
    width = 0.5 * (cuts[0, 1] - cuts[0, 0] + cuts[1, 1] - cuts[1, 0])
    return np.array([width, first - second, 0.5 * (first + second)])


@njit(nogil=True, cache=True)
def _slope(cameras_mm, section, plane_mm):  # type: ignore[no-untyped-def]
    slope = np.empty((3, 3))
    for number in range(3):
        up, down = section.copy(), section.copy()
        up[number] += DIFFERENCE_STEP_MM
        down[number] -= DIFFERENCE_STEP_MM
        change = _seen(cameras_mm, up, plane_mm) - _seen(cameras_mm, down, plane_mm)
        slope[:, number] = change / (2 * DIFFERENCE_STEP_MM)
    return slope
