"""The cylinder to a few millimetres, from its limbs as straight lines on the grid's plane.

From it follow the stations along the bar that each limb's points show, and the line of a limb that is hidden in its
view.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry.measuring_plane import PLANE_HEIGHT_MM

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class TangentPlane:
    """Plane through a camera's centre that touches the bar along one limb.

    Attributes
    ----------
    centre_mm : ndarray of float64, shape (3,)
    normal : ndarray of float64, shape (3,)
        Unit vector, towards smaller x.
    side : int
        -1 for the limb at smaller x, +1 for the other.
    """

    centre_mm: Array
    normal: Array
    side: int

    @classmethod
    def through(cls, centre_mm: Array, line: Array, side: int) -> "TangentPlane":
        """Plane through a camera's centre and a line on the measuring plane.

        Parameters
        ----------
        centre_mm : ndarray of float64, shape (3,)
        line : ndarray of float64, shape (2,)
            Slope dx/dy and x at y = 0, mm.
        side : int
            -1 for the limb at smaller x, +1 for the other.
        """
        on_line = np.array([[line[0] * y + line[1], y, PLANE_HEIGHT_MM] for y in (-250.0, 250.0)])
        normal = _cross(*(on_line - centre_mm))
        return cls(centre_mm, normal * (-np.sign(normal[0]) / np.linalg.norm(normal)), side)

    @classmethod
    def touching(cls, centre_mm: Array, cylinder: Array, side: int) -> "TangentPlane":
        """Plane through a camera's centre that touches a cylinder on one side.

        Parameters
        ----------
        centre_mm : ndarray of float64, shape (3,)
        cylinder : ndarray of float64, shape (5,)
            x0, z0, dx/dy, dz/dy, R.
        side : int
            -1 for the limb at smaller x, +1 for the other.
        """
        axis, u, R = _axis(cylinder)
        away = axis - centre_mm
        away = away - (away @ u) * u
        distance = float(np.linalg.norm(away))
        e = away / distance
        sine = min(R / distance, 1.0)
        across = _cross(u, e)
        across = across * -np.sign(across[0])
        return cls(centre_mm, side * sine * e + np.sqrt(1 - sine**2) * across, side)

    @property
    def line(self) -> Array:
        """Line x(y) in which the plane cuts the measuring plane: slope and intercept."""
        n, C = self.normal, self.centre_mm
        return np.array([-n[1] / n[0], C[0] + (n[1] * C[1] - n[2] * (PLANE_HEIGHT_MM - C[2])) / n[0]])

    def stations_mm(self, cylinder: Array, y_mm: Array) -> Array:
        """Return y of the bar's points that are seen at given y of the line.

        Parameters
        ----------
        cylinder : ndarray of float64, shape (5,)
            x0, z0, dx/dy, dz/dy, R.
        y_mm : ndarray of float64, shape (n,)
            On the plane's line.

        Returns
        -------
        ndarray of float64, shape (n,)
        """
        axis, u, _ = _axis(cylinder)
        line = self.line
        seen = np.column_stack([line[0] * y_mm + line[1], y_mm, np.full(len(y_mm), PLANE_HEIGHT_MM)]) - self.centre_mm
        across = _cross(self.normal, u)
        reach = ((axis - self.centre_mm) @ across) / (seen @ across)
        return ((reach * (seen @ u)) - (axis - self.centre_mm) @ u) * u[1]

    def places_mm(self, cylinder: Array, stations_mm: Array) -> Array:
        """Return y of the line at which the bar's points at given y are seen; the inverse of `stations_mm`.

        Parameters
        ----------
        cylinder : ndarray of float64, shape (5,)
            x0, z0, dx/dy, dz/dy, R.
        stations_mm : ndarray of float64, shape (n,)
            y of points of the bar.

        Returns
        -------
        ndarray of float64, shape (n,)
        """
        axis, u, R = _axis(cylinder)
        touched = axis - self.side * R * self.normal + np.outer(stations_mm / u[1], u)
        onward = touched - self.centre_mm
        return self.centre_mm[1] + onward[:, 1] * (PLANE_HEIGHT_MM - self.centre_mm[2]) / onward[:, 2]


def rough_cylinder(planes: list[TangentPlane]) -> Array | None:
    """Cylinder that tangent planes touch, in the least squares.

    The axis direction u is the smallest singular vector of the stacked normals; then n_i . (p - C_i) = s_i R is linear
    in the axis point p and R.

    Parameters
    ----------
    planes : list of TangentPlane

    Returns
    -------
    ndarray of float64, shape (5,), or None
        x0, z0, dx/dy, dz/dy, R; None with fewer than three planes, or without a cylinder.
    """
    if len(planes) < 3:
        return None
    normals = np.array([plane.normal for plane in planes])
    u = np.linalg.svd(normals)[2][2]
    if abs(u[1]) < 0.5:
        return None
    offsets = np.array([plane.normal @ plane.centre_mm for plane in planes])
    design = np.column_stack([normals[:, 0], normals[:, 2], [-plane.side for plane in planes]])
    x0, z0, R = np.linalg.lstsq(design, offsets, rcond=None)[0]
    return np.array([x0, z0, u[0] / u[1], u[2] / u[1], R]) if R > 0 else None


def _axis(cylinder: Array) -> tuple[Array, Array, float]:
    """Point and unit direction of the axis, radius."""
    x0, z0, slope_x, slope_z, R = cylinder
    u = np.array([slope_x, 1.0, slope_z])
    return np.array([x0, 0.0, z0]), u / np.linalg.norm(u), float(R)


def _cross(first: Array, second: Array) -> Array:
    """Cross product of two vectors in space, without the checks that cost numpy's ten times as much."""
    (a, b, c), (d, e, f) = first.tolist(), second.tolist()
    return np.array([b * f - c * e, c * d - a * f, a * e - b * d])
