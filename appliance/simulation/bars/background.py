"""What stands still around the bar: floor, rollers, barriers and clutter, drawn once per camera by ray casting."""

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import Bar
from appliance.simulation.sensor import Blur, Light

FLOOR_Z_MM = -400.0
FLOOR_LIGHT = 0.012
ROLLER_RADIUS_MM = 150.0
ROLLER_HALF_LENGTH_MM = 450.0
ROLLER_Y_MM = range(-1820, 4500, 520)
ROLLER_LIGHT = 0.04
BARRIER_X_MM = 470.0
BARRIER_Z_MM = (-60.0, 140.0)
BARRIER_LIGHT = 0.03
CLUTTER = 14
LAMP_YZ = np.array([-0.5, 0.81], np.float32)
TINT = np.array([0.85, 1.0, 1.05], np.float32)  # blue, green, red of the hall's lamps
TEXTURE_SIZE = 1024
TEXTURE_MM = 1600.0
# A hot bar lights what is around it: part of the light that a surface scatters, and that worn rollers mirror.
SCATTERED = 0.25
MIRRORED = 0.12
MIRROR_SOFTNESS = 0.5  # of the bar's radius, beyond its limbs
UP = np.array([[0.0], [0.0], [1.0]], np.float32)


def draw(centre_mm: NDArray[np.float64], rays: Light, seed: int, blur: Blur, lit_by: Bar | None = None) -> Light:
    """Blurred linear light of the empty line.

    Parameters
    ----------
    centre_mm : ndarray of float64, shape (3,)
        Projection centre, world frame.
    rays : ndarray of float32, shape (rows, columns, 3)
        Unit direction of each pixel's light.
    seed : int
        Place of clutter and texture; both cameras of a rig take the same.
    blur : Blur
    lit_by : Bar or None
        The bar whose glow rollers, floor and barriers reflect.

    Returns
    -------
    ndarray of float32, shape (3, rows, columns)
        Blue, green, red; 1 is full scale.
    """
    canvas = _line(centre_mm, rays, seed, lit_by)
    grey = blurred(canvas.light.reshape(rays.shape[:2]), blur)
    if lit_by is None:
        return TINT[:, None, None] * grey
    glow = blurred(canvas.glow.reshape(rays.shape[:2]), blur)
    return (TINT[:, None, None] * grey + lit_by.levels[:, None, None] * glow).astype(np.float32)


def parts(centre_mm: NDArray[np.float64], rays: Light, seed: int) -> NDArray[np.uint8]:
    """Number of the thing that each ray of `draw` meets, shape (rows, columns); 0 for none."""
    return _line(centre_mm, rays, seed, None).part.reshape(rays.shape[:2])


def _line(centre_mm: NDArray[np.float64], rays: Light, seed: int, lit_by: Bar | None) -> "_Canvas":
    """Everything that stands still, painted."""
    rng = np.random.default_rng([seed, 0x6261])
    canvas = _Canvas(centre_mm, rays, _texture(rng), lit_by)
    canvas.floor()
    for y_mm in ROLLER_Y_MM:
        canvas.roller(y_mm)
    for x_mm in (-BARRIER_X_MM, BARRIER_X_MM):
        canvas.wall(x_mm, (-9000, 9000), BARRIER_Z_MM, BARRIER_LIGHT)
    for _ in range(CLUTTER):
        _add_clutter(rng, canvas)
    return canvas


def blurred(plane: Light, blur: Blur) -> Light:
    """A plane of light seen through the point spread function."""
    core = cv2.GaussianBlur(plane, (0, 0), blur.core_px, borderType=cv2.BORDER_REPLICATE)
    halo = cv2.GaussianBlur(plane, (0, 0), blur.halo_px, borderType=cv2.BORDER_REPLICATE)
    return np.float32(1 - blur.halo_part) * core + np.float32(blur.halo_part) * halo


def _texture(rng: np.random.Generator) -> Light:
    """Factor around 1 that repeats seamlessly: the sum of noise at several scales."""
    texture = np.ones((TEXTURE_SIZE, TEXTURE_SIZE), np.float32)
    for cells in (8, 32, 128):
        noise = np.pad(rng.uniform(-0.25, 0.25, (cells, cells)).astype(np.float32), 4, mode="wrap")
        zoom = TEXTURE_SIZE // cells
        smooth = cv2.resize(noise, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_CUBIC)
        texture += smooth[4 * zoom : -4 * zoom, 4 * zoom : -4 * zoom]
    return np.maximum(texture, np.float32(0.2))


def _add_clutter(rng: np.random.Generator, canvas: "_Canvas") -> None:
    """Box-like thing beside the line, of which the side that faces the line shows."""
    x_mm = rng.choice([-1, 1]) * rng.uniform(BARRIER_X_MM + 50, 1500)
    y_mm = rng.uniform(-900, 1800)
    length_mm = rng.uniform(60, 500)
    top_mm = rng.uniform(-250, 120)
    canvas.wall(x_mm, (y_mm, y_mm + length_mm), (FLOOR_Z_MM, top_mm), rng.uniform(0.004, 0.06))


class _Canvas:
    """Light and depth of the nearest surface, one value per ray."""

    def __init__(self, centre_mm: NDArray[np.float64], rays: Light, texture: Light, lit_by: Bar | None) -> None:
        self._centre = centre_mm.astype(np.float32)
        self._d = np.ascontiguousarray(rays.reshape(-1, 3).T)
        self._texture = texture
        self._lit_by = lit_by
        self._depth = np.full(self._d.shape[1], np.inf, np.float32)
        self.light = np.full(self._d.shape[1], 0.5 * FLOOR_LIGHT, np.float32)
        self.glow = np.zeros(self._d.shape[1], np.float32)
        self.part = np.zeros(self._d.shape[1], np.uint8)
        self._things = 0

    def floor(self) -> None:
        """Horizontal plane under everything."""
        depth = self._plane_depth(2, FLOOR_Z_MM)
        hit = np.flatnonzero(depth > 0)
        points = self._points(hit, depth)
        texture = self._textured(points[0], points[1])
        self._paint(hit, depth, FLOOR_LIGHT * texture)
        self._reflect(hit, points, UP, texture, mirrored=0.0)

    def wall(self, x_mm: float, y_mm: tuple[float, float], z_mm: tuple[float, float], light: float) -> None:
        """Upright rectangle along the line."""
        depth = self._plane_depth(0, x_mm)
        in_front = np.flatnonzero((depth > 0) & (depth < self._depth))
        points = self._points(in_front, depth)
        _, y, z = points
        inside = (y >= y_mm[0]) & (y <= y_mm[1]) & (z >= z_mm[0]) & (z <= z_mm[1])
        texture = self._textured(y[inside], z[inside])
        self._paint(in_front[inside], depth, light * texture)
        facing = np.array([[np.sign(self._centre[0] - x_mm)], [0], [0]], np.float32)
        self._reflect(in_front[inside], points[:, inside], facing, texture, mirrored=0.0)

    def roller(self, y_mm: float) -> None:
        """Cylinder along x whose top is z = 0, lit from above."""
        from_axis = self._centre[1:] - np.array([y_mm, -ROLLER_RADIUS_MM], np.float32)
        _, dy, dz = self._d
        a = dy * dy + dz * dz
        b = dy * from_axis[0] + dz * from_axis[1]
        discriminant = b * b - a * (from_axis @ from_axis - np.float32(ROLLER_RADIUS_MM**2))
        depth = (-b - np.sqrt(np.maximum(discriminant, 0))) / a
        hit = np.flatnonzero((discriminant > 0) & (depth > 0) & (depth < self._depth))
        points = self._points(hit, depth)
        on_roller = np.abs(points[0]) < ROLLER_HALF_LENGTH_MM
        hit, points = hit[on_roller], points[:, on_roller]
        x, y, z = points
        normal = np.stack([np.zeros_like(x), y - y_mm, z + ROLLER_RADIUS_MM]) / ROLLER_RADIUS_MM
        lit = np.float32(0.15) + np.float32(0.85) * np.maximum(LAMP_YZ @ normal[1:], np.float32(0))
        texture = self._textured(x + y_mm, ROLLER_RADIUS_MM * np.arctan2(*normal[1:]))
        self._paint(hit, depth, ROLLER_LIGHT * lit * texture)
        self._reflect(hit, points, normal.astype(np.float32), texture, mirrored=MIRRORED)

    def _plane_depth(self, axis: int, level_mm: float) -> Light:
        with np.errstate(divide="ignore"):
            return np.divide(level_mm - self._centre[axis], self._d[axis], dtype=np.float32)

    def _points(self, which: NDArray[np.intp], depth: Light) -> Light:
        points = self._centre[:, None] + self._d[:, which] * depth[which]
        return points.astype(np.float32, copy=False)

    def _textured(self, u_mm: Light, v_mm: Light) -> Light:
        u, v = (np.rint(c * (TEXTURE_SIZE / TEXTURE_MM)).astype(np.int64) % TEXTURE_SIZE for c in (u_mm, v_mm))
        return self._texture[v, u]

    def _paint(self, which: NDArray[np.intp], depth: Light, light: Light) -> None:
        self._depth[which] = depth[which]
        self.light[which] = light
        self._things += 1
        self.part[which] = self._things

    def _reflect(
        self, which: NDArray[np.intp], points: Light, normal: Light, texture: Light, *, mirrored: float
    ) -> None:
        """Light of the bar that surface points, shape (3, n), send to the camera, over the bar's own."""
        if self._lit_by is None:
            return
        glow = SCATTERED * _irradiance(self._lit_by, points, normal)
        if mirrored:
            rays = self._d[:, which]
            onward = rays - 2 * np.sum(rays * normal, axis=0) * normal
            glow += mirrored * _mirror_image(self._lit_by, points, onward)
        self.glow[which] = texture * glow


def _irradiance(bar: Bar, points: Light, normal: Light) -> NDArray[np.float64]:
    """Light that falls on points from an endless glowing cylinder, over the cylinder's: (R / r) cos of incidence."""
    u = bar.axis_direction
    to_axis = bar.axis_point_mm[:, None] - points
    to_axis -= u[:, None] * (u @ to_axis)
    distance_mm = np.maximum(np.linalg.norm(to_axis, axis=0), bar.diameter_mm / 2)
    cosine = np.sum(to_axis * normal, axis=0) / distance_mm
    return bar.diameter_mm / 2 / distance_mm * np.maximum(cosine, 0)


def _mirror_image(bar: Bar, points: Light, onward: Light) -> NDArray[np.float64]:
    """1 where rays that leave points meet the bar, softly less where they pass it."""
    u = bar.axis_direction
    from_axis = points - bar.axis_point_mm[:, None]
    normal = np.cross(onward, u, axis=0)
    passing_mm = np.abs(np.sum(from_axis * normal, axis=0)) / np.linalg.norm(normal, axis=0)
    radius_mm = bar.diameter_mm / 2
    beside = np.maximum(passing_mm / radius_mm - 1, 0) / MIRROR_SOFTNESS
    towards = np.sum((from_axis - u[:, None] * (u @ from_axis)) * onward, axis=0) < 0
    return towards * np.exp(-(beside**2))
