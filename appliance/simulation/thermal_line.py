"""The simulated thermal line: one uncalibrated camera above a conveyor with two warm barriers.

Its pictures are 8-bit grey of light linear in what the sensor receives. Every edge is drawn by the exact place at
which each pixel's ray meets the edge's plane, so that no sampling moves it.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import Bar, bar_at, truth
from appliance.simulation.bars.silhouette import Glow, silhouette
from appliance.simulation.sensor import Blur, Light, NoiseStock, blurred_step
from appliance.simulation.true_rig import TrueCamera, look_at

IMAGE_SIZE = (640, 480)
WALL_MM = 60.0
# Grey levels of floor, barrier top, barrier's inner face, over full scale.
FLOOR, TOP, FACE = 0.12, 0.42, 0.30
BAR = 0.9
FADING_PER_M = 0.08  # of the floor's light along the line
THERMAL_BLUR = Blur(core_px=1.3, halo_px=6.0, halo_part=0.02)
GLOW = Glow(limb_darkening=0.03, unevenness=0.05)

Barrier = Literal["left", "right"]
Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class ThermalLine:
    """Camera, barriers and bar of a thermal recording.

    Attributes
    ----------
    camera : TrueCamera
    spacing_mm : float
        Between the barriers' inner faces.
    height_mm : float
        Of the barriers' tops over the rollers.
    bar : Bar or None
    seed : int
        Noise.
    blur : Blur
    noise : float
        Standard deviation over full scale.
    warp_mm : float
        Amplitude of the left barrier's bend, a wave along the line; 0 for straight barriers.
    warp_length_mm : float
        Its wave length.
    hidden : str or None
        Barrier that something cold hides behind `hidden_from_mm`.
    hidden_from_mm : float
        y.
    """

    camera: TrueCamera
    spacing_mm: float = 500.0
    height_mm: float = 100.0
    bar: Bar | None = None
    seed: int = 0
    blur: Blur = THERMAL_BLUR
    noise: float = 0.008
    warp_mm: float = 0.0
    warp_length_mm: float = 1200.0
    hidden: Barrier | None = None
    hidden_from_mm: float = 0.0

    def pictures(self, empty: int, frames: int) -> list[Picture]:
        """Grey pictures, shape (rows, columns): `empty` of the line without the bar, then `frames` with it."""
        rays = self.camera.rays(self.camera.pixel_grid())
        light = self.line_light(rays)
        with_bar = light if self.bar is None else self.with_bar(light, rays.astype(np.float32), self.bar)
        stock = NoiseStock(light.shape, self.seed)
        starts = np.random.default_rng([self.seed, 0x7468]).integers(NoiseStock.EXTRA, size=empty + frames)
        return [
            self.exposed(light if number < empty else with_bar, stock.cut(int(start)))
            for number, start in enumerate(starts)
        ]

    def line_light(self, rays: NDArray[np.float64]) -> Light:
        """Light of the empty line, shape (rows, columns), for unit rays (rows, columns, 3)."""
        _, y = self.on_plane(rays, 0.0)
        light = FLOOR * (1 - FADING_PER_M * y / 1000)
        for side in ("left", "right"):
            light += self._barrier_light(rays, side)
        return light.astype(np.float32)

    def _barrier_light(self, rays: NDArray[np.float64], side: Barrier) -> NDArray[np.float64]:
        """What a barrier adds to the floor's light."""
        half_mm = self.spacing_mm / 2
        beyond_foot = self._beyond(rays, side, half_mm, 0.0)
        beyond_inner = self._beyond(rays, side, half_mm, self.height_mm)
        beyond_outer = self._beyond(rays, side, half_mm + WALL_MM, self.height_mm)
        face_shows = np.maximum(beyond_foot - beyond_inner, 0)
        added = (FACE - FLOOR) * face_shows + (TOP - FLOOR) * (beyond_inner - beyond_outer)
        if side == self.hidden:
            _, y = self.on_plane(rays, self.height_mm)
            added *= 1 - self._blurred(y - self.hidden_from_mm)
        return added

    def _beyond(self, rays: NDArray[np.float64], side: Barrier, from_middle_mm: float, z_mm: float) -> Light:
        """Blurred part of each pixel that is farther out than an edge along the line at a height."""
        x, y = self.on_plane(rays, z_mm)
        if side == "left":
            x = -x + self.warp_mm * np.sin(2 * np.pi * y / self.warp_length_mm)
        return self._blurred(x - from_middle_mm)

    def _blurred(self, beyond_mm: NDArray[np.float64]) -> Light:
        """Half plane where a smooth function over the picture is positive, behind the lens."""
        down, right = np.gradient(beyond_mm)
        distance_px = beyond_mm / np.hypot(down, right)
        core, halo = (blurred_step(distance_px / sigma) for sigma in (self.blur.core_px, self.blur.halo_px))
        return (core + self.blur.halo_part * (halo - core)).astype(np.float32)

    def on_plane(self, rays: NDArray[np.float64], z_mm: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """X and y at which rays meet a level plane; the camera looks down, so that all do."""
        centre_mm = self.camera.centre_mm
        points = centre_mm + rays * ((z_mm - centre_mm[2]) / rays[..., 2:])
        return points[..., 0], points[..., 1]

    def with_bar(self, light: Light, rays: Light, bar: Bar) -> Light:
        """Light of the line with a bar on it, for unit rays as in `line_light`."""
        seen = silhouette(self.camera.centre_mm, rays, bar, GLOW, self.blur)
        if seen is None:
            return light
        light = light.copy()
        part = light[seen.rows, seen.columns]
        part *= 1 - seen.coverage
        part += np.float32(BAR) * seen.glow
        return light

    def exposed(self, light: Light, noise: Light) -> Picture:
        """Picture of light, with standard normal noise of its shape."""
        return np.rint(255 * np.clip(light + np.float32(self.noise) * noise, 0, 1)).astype(np.uint8)


class ThermalSequence:
    """Pictures of a line on which bars pass, drawn one by one; the same seed gives the same pictures.

    Parameters
    ----------
    line : ThermalLine
        Its own bar does not count.
    """

    def __init__(self, line: ThermalLine) -> None:
        self._line = line
        rays = line.camera.rays(line.camera.pixel_grid())
        self._light = line.line_light(rays)
        self._rays = rays.astype(np.float32)
        y = line.on_plane(rays[:, rays.shape[1] // 2], 0.0)[1]
        self._region_y_mm = float(y.min()), float(y.max())
        self._stock = NoiseStock(self._light.shape, line.seed)

    def empty(self, number: int) -> Picture:
        """Picture of the line before the first bar, grey, shape (rows, columns)."""
        return self._exposed(self._light, -1 - number)

    def picture(self, number: int) -> tuple[Picture, dict[str, object]]:
        """Picture of a frame, grey, shape (rows, columns), and what is true of it."""
        bar = bar_at(self._line.seed, number)
        light = self._light if bar is None else self._line.with_bar(self._light, self._rays, bar)
        return self._exposed(light, number), truth(bar, self._region_y_mm)

    def _exposed(self, light: Light, number: int) -> Picture:
        start = np.random.default_rng([self._line.seed, number % 2**32]).integers(NoiseStock.EXTRA)
        return self._line.exposed(light, self._stock.cut(int(start)))


def thermal_camera(
    height_mm: float = 2600.0, back_mm: float = 800.0, roll_deg: float = 0.0, aside_deg: float = 0.0
) -> TrueCamera:
    """Camera over the middle of the line, `back_mm` before the place it looks at; about 4.8 mm per pixel.

    It is turned about its own upright axis by `aside_deg`: then it looks across the line.
    """
    columns, rows = IMAGE_SIZE
    focal_px = math.hypot(height_mm, back_mm) / 4.8
    R, t = look_at(np.array([0.0, -back_mm, height_mm]), np.array([0.0, 0.0, 0.0]), math.radians(roll_deg))
    K = np.array([[focal_px, 0, (columns - 1) / 2], [0, focal_px, (rows - 1) / 2], [0, 0, 1.0]])
    cos, sin = math.cos(math.radians(aside_deg)), math.sin(math.radians(aside_deg))
    aside = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])
    return TrueCamera(K, np.zeros(5), aside @ R, aside @ t, IMAGE_SIZE)


def random_thermal_line(seed: int) -> ThermalLine:
    """A line as another mill might have it, its barriers straight.

    A bar of 120 to 220 mm, within 60 mm of the middle, turned by up to 0.5 degrees, its warm side at 30 to 150
    degrees; a camera 2.2 to 3.2 m above the rollers and 0.4 to 1.5 m back, rolled by up to 1 degree, one pixel of which
    is 4.4 to 5.2 mm; barriers 420 to 620 mm apart and 60 to 140 mm high; blur of 1.0 to 1.7 px with a halo of 1 to 3 %;
    noise of 0.4 to 1.2 % of full scale.
    """
    rng = np.random.default_rng([seed, 0x746C])
    camera = thermal_camera(rng.uniform(2200, 3200), rng.uniform(400, 1500), rng.uniform(-1, 1))
    pixel_mm = rng.uniform(4.4, 5.2)
    camera = replace(camera, K=camera.K * np.array([[4.8 / pixel_mm, 1, 1], [1, 4.8 / pixel_mm, 1], [1, 1, 1]]))
    bar = Bar(rng.uniform(120, 220), rng.uniform(-60, 60), rng.uniform(-0.5, 0.5), warm_side_deg=rng.uniform(30, 150))
    return ThermalLine(
        camera,
        spacing_mm=rng.uniform(420, 620),
        height_mm=rng.uniform(60, 140),
        bar=bar,
        seed=seed,
        blur=Blur(core_px=rng.uniform(1.0, 1.7), halo_px=6.0, halo_part=rng.uniform(0.01, 0.03)),
        noise=rng.uniform(0.004, 0.012),
    )


def thermal_truth(line: ThermalLine, empty: int, frames: int) -> dict[str, object]:
    """`truth.json` of a thermal recording."""
    rows: list[dict[str, object]] = []
    for number in range(empty + frames):
        shown = None if number < empty else line.bar
        rows.append({"frame": f"{number:06}", **truth(shown)})
    camera = line.camera
    return {
        "image_size": list(camera.image_size),
        "units": "mm",
        "world": "z up, roller tops z = 0, bar axis about +y, x across; OpenCV camera, x_cam = R x_world + t",
        "camera": {name: getattr(camera, name).tolist() for name in ("K", "dist", "R", "t")},
        "camera_centre_mm": camera.centre_mm.tolist(),
        "barrier_spacing_mm": line.spacing_mm,
        "barrier_height_mm": line.height_mm,
        "barrier_warp_mm": line.warp_mm,
        "barrier_hidden": line.hidden,
        "diameter_mm": None if line.bar is None else line.bar.diameter_mm,
        "empty_frames": empty,
        "frames": rows,
    }
