"""An ingot as a solid before the camera: a cylinder with two flat ends, followed ray by ray.

World frame of the ingot line, mm: y along the rolling direction towards the camera, z up from the tops of the
rollers, x = 0 in the middle of the line. An ingot's axis leads from the end that is judged into its body.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.ingots.faces import Label
from appliance.simulation.sensor import Light
from appliance.simulation.true_rig import TrueCamera

Points = NDArray[np.float64]

OUTLINE_POINTS = 64


@dataclass(frozen=True, slots=True, eq=False)
class Ingot:
    """What stays the same while an ingot is handled.

    Attributes
    ----------
    label : str
        Of the end that faces the camera.
    radius_mm, length_mm : float
    temperature_c : float
    face : ndarray of float32, shape (cells, cells)
        Relative light of the end that is judged, the disc inscribed.
    side : ndarray of float32, shape (along, around)
        Relative light of the side.
    """

    label: Label
    radius_mm: float
    length_mm: float
    temperature_c: float
    face: Light
    side: Light


@dataclass(frozen=True, slots=True)
class Pose:
    """Where an ingot is.

    Attributes
    ----------
    end_mm : tuple of float
        Centre of the end that is judged.
    yaw_deg : float
        Of the axis about z; 0 points away from the camera, along -y.
    pitch_deg : float
        How far the body rises over the level; 90 is upright, the end below.
    """

    end_mm: tuple[float, float, float]
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0

    @property
    def axes(self) -> Points:
        """Rows: the axis into the body, across to the right as the camera sees it, and what then points up."""
        yaw, pitch = math.radians(self.yaw_deg), math.radians(self.pitch_deg)
        axis = np.array([math.sin(yaw) * math.cos(pitch), -math.cos(yaw) * math.cos(pitch), math.sin(pitch)])
        across = np.array([-math.cos(yaw), -math.sin(yaw), 0.0])
        return np.stack([axis, across, np.cross(axis, across)])


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What a camera sees of an ingot, in a window of the picture.

    Attributes
    ----------
    rows, columns : slice
        The window.
    coverage : ndarray of float32, shape (rows, columns)
        Part of each pixel that the ingot covers.
    light : ndarray of float32, shape (rows, columns)
        Relative light of what is seen, times `coverage`.
    face : ndarray of float32, shape (rows, columns)
        Part of each pixel that the judged end covers.
    """

    rows: slice
    columns: slice
    coverage: Light
    light: Light
    face: Light


def rim_mm(ingot: Ingot, pose: Pose, along_mm: float = 0.0) -> Points:
    """Points on the rim of the judged end, or of a section further along the axis, shape (n, 3)."""
    axis, across, up = pose.axes
    turn = np.linspace(0, 2 * np.pi, OUTLINE_POINTS, endpoint=False)[:, None]
    centre = np.array(pose.end_mm) + along_mm * axis
    return centre + ingot.radius_mm * (np.cos(turn) * across + np.sin(turn) * up)


def outline_px(camera: TrueCamera, ingot: Ingot, pose: Pose) -> Points:
    """Pixels (x, y) of both rims; NaN where they are behind the camera."""
    return camera.project(np.concatenate([rim_mm(ingot, pose), rim_mm(ingot, pose, ingot.length_mm)]))


def end_circle_px(camera: TrueCamera, ingot: Ingot, pose: Pose) -> tuple[float, float, float]:
    """Pixel x, y of the judged end's centre, and half its width across the line."""
    _, across, _ = pose.axes
    centre = np.array(pose.end_mm)
    points = np.stack([centre, centre - ingot.radius_mm * across, centre + ingot.radius_mm * across])
    (x, y), left, right = camera.project(points)
    return float(x), float(y), float(np.hypot(*(right - left))) / 2


def see(camera: TrueCamera, rays: Light, ingot: Ingot, pose: Pose, margin_px: int) -> Seen | None:
    """An ingot as sharp as its edges' exact places in the pixels allow; None when it is not in the picture.

    Parameters
    ----------
    camera : TrueCamera
    rays : ndarray of float32, shape (rows, columns, 3)
        Unit direction of each pixel's light.
    ingot, pose : Ingot, Pose
    margin_px : int
        Of the window around the ingot.
    """
    outline = outline_px(camera, ingot, pose)
    if np.isnan(outline).any():
        return None
    rows, columns = window(outline, margin_px, camera.image_size)
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return None
    axes = pose.axes
    along, across, up = np.moveaxis(rays[rows, columns] @ axes.T.astype(np.float32), 2, 0)
    from_end = (axes @ (camera.centre_mm - np.array(pose.end_mm))).astype(np.float32)
    cast = _Cast(along, across, up, from_end, np.float32(ingot.radius_mm), np.float32(ingot.length_mm))
    near, far = cast.disc(0.0), cast.disc(ingot.length_mm)
    side, side_light = cast.side(ingot.side, far)
    coverage = np.maximum(np.maximum(near.coverage, far.coverage), side)
    light, face = side_light, np.zeros_like(coverage)
    if from_end[0] < 0:
        end_light = _looked_up(ingot.face, near.across, near.up)
        light, face = side_light + near.coverage * (end_light - side_light), near.coverage
    elif from_end[0] > ingot.length_mm:
        light = side_light + far.coverage * (1 - side_light)
    return Seen(rows, columns, coverage, (coverage * light).astype(np.float32), face)


def window(points: Points, margin_px: float, image_size: tuple[int, int]) -> tuple[slice, slice]:
    """Rows and columns around points (x, y), inside the picture."""
    columns, rows = image_size
    low, high = points.min(axis=0) - margin_px, points.max(axis=0) + margin_px + 1
    left, right = np.clip([low[0], high[0]], 0, columns).astype(int).tolist()
    top, bottom = np.clip([low[1], high[1]], 0, rows).astype(int).tolist()
    return slice(top, bottom), slice(left, right)


@dataclass(frozen=True, slots=True, eq=False)
class _Disc:
    coverage: Light
    across: Light
    up: Light


@dataclass(frozen=True, slots=True, eq=False)
class _Cast:
    """Rays in an ingot's own axes, from a camera that is `from_end` away from its judged end."""

    along: Light
    across: Light
    up: Light
    from_end: NDArray[np.float32]
    radius: np.float32
    length: np.float32

    def disc(self, place_mm: float) -> _Disc:
        """The section at a place along the axis; its points over the radius."""
        ahead = np.float32(place_mm) - self.from_end[0]
        depth = ahead / np.where(np.abs(self.along) < 1e-6, np.float32(1e-6), self.along)
        across = (self.from_end[1] + depth * self.across) / self.radius
        up = (self.from_end[2] + depth * self.up) / self.radius
        covered = np.where(depth > 0, _inside(np.hypot(across, up)), np.float32(0))
        return _Disc(covered.astype(np.float32), across, up)

    def side(self, texture: Light, far: _Disc) -> tuple[Light, Light]:
        """Coverage between both ends, and the relative light there."""
        _, across_0, up_0 = self.from_end
        square = np.maximum(self.across**2 + self.up**2, np.float32(1e-9))
        passing = (across_0 * self.up - up_0 * self.across) / np.sqrt(square)
        free = np.maximum(self.radius**2 - passing**2, 0)
        towards = -(across_0 * self.across + up_0 * self.up)
        depth = (towards - np.sqrt(free * square)) / square
        place = self.from_end[0] + depth * self.along
        between = (depth > 0) & (place >= 0) & (place <= self.length)
        coverage = np.where(between, _inside(np.abs(passing) / self.radius), np.float32(0))
        # the body's outline at its far end is that end's rim
        behind = place > self.length - np.float32(0.3) * self.radius
        coverage = np.where(behind, np.minimum(coverage, far.coverage), coverage)
        turn = np.arctan2(up_0 + depth * self.up, across_0 + depth * self.across)
        cells_along, cells_around = texture.shape
        u = turn * np.float32(cells_around / (2 * np.pi))
        v = np.clip(place / self.length, 0, 1) * np.float32(cells_along - 1)
        light = cv2.remap(texture, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
        return coverage.astype(np.float32), np.asarray(light, np.float32)


def _inside(distance: Light) -> Light:
    """Part of each pixel inside of distance 1, from the distance's slope across the pixels."""
    down, across = cv2.Sobel(distance, cv2.CV_32F, 0, 1, ksize=1), cv2.Sobel(distance, cv2.CV_32F, 1, 0, ksize=1)
    slope = np.float32(0.5) * np.hypot(down, across)
    return np.clip(np.float32(0.5) + (1 - distance) / np.maximum(slope, np.float32(1e-6)), 0, 1).astype(np.float32)


def _looked_up(texture: Light, across: Light, up: Light) -> Light:
    half = np.float32((len(texture) - 1) / 2)
    return np.asarray(cv2.remap(texture, half * (1 + across), half * (1 - up), cv2.INTER_LINEAR), np.float32)
