"""The picture of a glowing cylinder through a real lens, with exact tangent silhouettes.

A pixel's ray passes the axis at a signed distance q; the silhouette's limbs are q = -R and q = +R, whatever
the lens and the pose. Where a limb is straight over the width of the blur, blurred light depends only on q and on
the local scale g = |grad q| in mm per pixel, so it is computed as a table over (g, q) and looked up per pixel.

An elliptic section becomes a circle, and the silhouette of the one that of the other, when camera and rays are
squeezed along the ellipse's axes. A tube around a curved axis is hidden from a ray that passes the curve at R.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import Bar
from appliance.simulation.sensor import Blur, Light

COARSE_PX = 8
SCALES = 5
CELLS_PER_PX = 20
REACH_IN_HALOS = 5.0
CAMBER_LENGTH_MM = 1000.0
CAMBER_REACH_MM = 2000.0  # beyond, the axis goes on straight
CAMBER_ROUNDS = 2


@dataclass(frozen=True, slots=True)
class Glow:
    """How the light of a bar of uniform emission is changed over its surface.

    Attributes
    ----------
    limb_darkening : float
        Part of the light lost at grazing exit: factor 1 - a (1 - cos theta).
    unevenness : float
        Amplitude around the section of a bar that is warmer on one side.
    """

    limb_darkening: float = 0.04
    unevenness: float = 0.04


@dataclass(frozen=True, slots=True)
class Silhouette:
    """The part of a picture that a bar touches.

    Attributes
    ----------
    rows, columns : slice
        Where it is in the picture.
    coverage : ndarray of float32, shape (rows, columns)
        Blurred part of each pixel that the bar hides, 0 to 1.
    glow : ndarray of float32, shape (rows, columns) or (3, rows, columns)
        Blurred light of the bar, 1 for the middle of a bar without unevenness; per channel where that differs.
    """

    rows: slice
    columns: slice
    coverage: Light
    glow: Light


def silhouette(centre_mm: NDArray[np.float64], rays: Light, bar: Bar, glow: Glow, blur: Blur) -> Silhouette | None:
    """Picture of a bar.

    Parameters
    ----------
    centre_mm : ndarray of float64, shape (3,)
        Projection centre of the camera, world frame.
    rays : ndarray of float32, shape (rows, columns, 3)
        Unit direction of each pixel's light, world frame.
    bar : Bar
    glow : Glow
    blur : Blur

    Returns
    -------
    Silhouette or None
        None when the bar is outside the picture.
    """
    centre_mm, rays = rounded(centre_mm, rays, bar)
    distance = axis_distance(centre_mm, rays[::COARSE_PX, ::COARSE_PX], bar)
    down, right = np.gradient(distance)
    scale = np.hypot(down, right) / COARSE_PX
    reach_mm = bar.diameter_mm / 2 + REACH_IN_HALOS * blur.halo_px * float(scale.max())
    touched = np.abs(distance) < reach_mm
    if not touched.any():
        return None
    scales = np.linspace(0.99 * float(scale[touched].min()), 1.01 * float(scale[touched].max()), SCALES)
    rows, columns = _box(touched, rays.shape[:2])
    q = axis_distance(centre_mm, rays[rows, columns], bar)
    surface = _Surface(bar, centre_mm, glow)
    table, first_q, q_step = _light_table(surface, blur, scales, reach_mm)
    looked_up = cv2.remap(
        table,
        (q - np.float32(first_q)) * np.float32(1 / q_step),
        (_scale(q) - np.float32(scales[0])) * np.float32((SCALES - 1) / (scales[-1] - scales[0])),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    coverage, light = np.moveaxis(looked_up.astype(np.float32, copy=False), -1, 0)
    return Silhouette(rows, columns, coverage, light)


def rounded(centre_mm: NDArray[np.float64], rays: Light, bar: Bar) -> tuple[NDArray[np.float64], Light]:
    """Camera and unit rays, float32 (..., 3), in the space in which the bar's section is the circle of its diameter."""
    if bar.ovality_mm == 0:
        return centre_mm, rays
    turn = math.radians(bar.ovality_deg)
    squeeze = np.eye(3)
    for angle, excess_mm in ((turn, bar.ovality_mm / 2), (turn + math.pi / 2, -bar.ovality_mm / 2)):
        along = math.cos(angle) * bar.across + math.sin(angle) * np.array([0.0, 0.0, 1.0])
        squeeze += (bar.diameter_mm / (bar.diameter_mm + excess_mm) - 1) * np.outer(along, along)
    moved = rays @ squeeze.astype(np.float32)
    moved /= np.linalg.norm(moved, axis=-1, keepdims=True)
    return bar.axis_point_mm + squeeze @ (centre_mm - bar.axis_point_mm), moved


def axis_distance(centre_mm: NDArray[np.float64], rays: Light, bar: Bar) -> Light:
    """Signed distance in mm between unit rays (..., 3) from a camera and the bar's axis, float32 (...)."""
    if bar.camber_mm != 0:
        point, direction = axis_near(centre_mm, rays, bar)
        normal = np.cross(direction, centre_mm - point)
        along = np.einsum("...i,...i", rays, direction)
        return (np.einsum("...i,...i", rays, normal) / np.sqrt(1 - along**2)).astype(np.float32)
    u = bar.axis_direction
    moment = np.cross(u, centre_mm - bar.axis_point_mm)
    both = rays.reshape(-1, 3) @ np.stack([moment, u], axis=1).astype(np.float32)
    sine = np.sqrt(1 - both[:, 1] ** 2, dtype=np.float32)
    return np.divide(both[:, 0], sine, dtype=np.float32).reshape(rays.shape[:-1])


def axis_near(centre_mm: NDArray[np.float64], rays: Light, bar: Bar) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Point and direction of the axis where each unit ray passes it, shape (..., 3) or (3,) if the axis is straight."""
    point, direction = bar.axis_point_mm, bar.axis_direction
    if bar.camber_mm == 0:
        return point, direction
    for _ in range(CAMBER_ROUNDS):
        near = point + station_mm(centre_mm - point, rays, direction)[..., None] * direction
        s = np.clip((near - bar.axis_point_mm) @ bar.axis_direction, -CAMBER_REACH_MM, CAMBER_REACH_MM)[..., None]
        bend = -4 * bar.camber_mm * (s / CAMBER_LENGTH_MM) ** 2
        slope = -8 * bar.camber_mm * s / CAMBER_LENGTH_MM**2
        point = bar.axis_point_mm + s * bar.axis_direction + bend * bar.across
        direction = (bar.axis_direction + slope * bar.across) / np.sqrt(1 + slope**2)
    return point, direction


def station_mm(
    from_axis_mm: NDArray[np.float64], rays: NDArray[np.floating], direction: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Where rays pass lines of unit `direction` nearest, along the line from the point that is `from_axis_mm` away."""
    cosine = np.einsum("...i,...i", rays, direction)
    ahead = np.einsum("...i,...i", from_axis_mm, direction)
    return (ahead - cosine * np.einsum("...i,...i", rays, from_axis_mm)) / (1 - cosine**2)


def _box(touched: NDArray[np.bool_], shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Pixels around the touched points of the coarse grid."""

    def span(axis: int) -> slice:
        hit = np.flatnonzero(touched.any(axis=1 - axis))
        first, last = int(hit[0]) - 1, int(hit[-1]) + 1
        return slice(max(0, first * COARSE_PX), min(shape[axis], last * COARSE_PX + 1))

    return span(0), span(1)


def _scale(q: Light) -> Light:
    """|grad q|, mm per pixel; along the border of the picture too small, where the table's least scale stands in."""
    right = cv2.Sobel(q, cv2.CV_32F, 1, 0, ksize=1, scale=0.5)
    down = cv2.Sobel(q, cv2.CV_32F, 0, 1, ksize=1, scale=0.5)
    return cv2.magnitude(right, down).astype(np.float32, copy=False)


def _light_table(
    surface: "_Surface", blur: Blur, scales: NDArray[np.float64], reach_mm: float
) -> tuple[Light, float, float]:
    """Coverage and glow over (scale, q); the first q and the step of q, mm.

    The limbs lie on borders between cells, so that no sampling moves them; the blur is exact by Fourier transform.
    """
    diameter_mm = surface.bar.diameter_mm
    inner = round(diameter_mm / float(scales[0]) * CELLS_PER_PX)
    q_step = diameter_mm / inner
    outer = math.ceil((reach_mm - diameter_mm / 2) / q_step)
    cells = 1 << (inner + 2 * outer).bit_length()
    signals = np.zeros((2, cells))
    signals[0, outer : outer + inner] = 1
    signals[1, outer : outer + inner] = surface.light((np.arange(inner) + 0.5) * 2 / inner - 1)
    spectra = np.fft.rfft(signals)
    frequencies = np.fft.rfftfreq(cells, q_step)
    rows = [np.fft.irfft(spectra * blur.transfer(frequencies * scale), cells) for scale in scales]
    table = np.stack(rows).transpose(0, 2, 1)[:, : inner + 2 * outer]
    return np.ascontiguousarray(table, dtype=np.float32), (0.5 - outer) * q_step - diameter_mm / 2, q_step


@dataclass(frozen=True, slots=True)
class _Surface:
    """A bar's surface as a camera sees it."""

    bar: Bar
    camera_mm: NDArray[np.float64]
    glow: Glow

    def light(self, sine: NDArray[np.float64]) -> NDArray[np.float64]:
        """Light that leaves the surface towards the camera, over q/R."""
        to_camera = self.camera_mm - self.bar.axis_point_mm
        x, z = float(to_camera @ self.bar.across), float(to_camera[2])
        exit_angle = np.arcsin(sine)
        ray_turn = np.arcsin(sine * self.bar.diameter_mm / 2 / math.hypot(x, z))
        place = math.atan2(z, x) + ray_turn - exit_angle - math.radians(self.bar.warm_side_deg)
        darkening = 1 - self.glow.limb_darkening * (1 - np.cos(exit_angle))
        return darkening * (1 + self.glow.unevenness * np.cos(place))
