"""Thermal lines as other makers build them: barriers that hang over rollers whose ends show, and a lens that bends.

Below a hanging barrier one looks at the rollers' ends, the gap beside them and the floor between rollers; the light
along a barrier's edge changes from roller to roller. Barriers are of other heights, lights and widths than our own.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.bars import Bar
from appliance.simulation.sensor import Blur, Light
from appliance.simulation.thermal_line import Barrier, Picture, ThermalLine, thermal_camera

DISTORTION = (-0.16, 0.04)  # k1
SHARE_OF_WALLS = 0.4  # of lines whose barriers reach down to the rollers


@dataclass(frozen=True, slots=True, eq=False)
class ForeignThermalLine(ThermalLine):
    """A line over rollers.

    Attributes
    ----------
    lower_mm : float
        Of the barriers' lower edges over the rollers; 0 for walls.
    roller_gap_mm : float
        From a roller's end to the barrier's inner face.
    roller_pitch_mm, roller_mm : float
        From roller to roller along the line, and the length of line that one covers.
    roller_light, floor_light, top_light, face_light : float
        Over full scale.
    wall_mm : float
        Width of a barrier's top.
    exponent : float
        Of the response: code values follow light to this power.
    """

    lower_mm: float = 0.0
    roller_gap_mm: float = 20.0
    roller_pitch_mm: float = 250.0
    roller_mm: float = 150.0
    roller_light: float = 0.15
    floor_light: float = 0.05
    top_light: float = 0.42
    face_light: float = 0.35
    wall_mm: float = 60.0
    exponent: float = 1.0

    def line_light(self, rays: NDArray[np.float64]) -> Light:
        """Light of the empty line; see `ThermalLine.line_light`."""
        _, y = self.on_plane(rays, 0.0)
        inside = np.ones(y.shape)
        for side in ("left", "right"):
            inside = inside - self._beyond(rays, side, self.spacing_mm / 2 - self.roller_gap_mm, 0.0)
        light = self.floor_light + (self.roller_light - self.floor_light) * inside * self._on_roller(y)
        light = light.astype(np.float32)
        for side in ("left", "right"):
            light = self._with_barrier(light, rays, side)
        return light

    def _on_roller(self, y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Blurred part of each pixel that lies on a roller, by the place along the line."""
        beyond = np.zeros(y.shape)
        first, last = int(y.min() // self.roller_pitch_mm) - 1, int(y.max() // self.roller_pitch_mm) + 1
        for number in range(first, last + 1):
            start = number * self.roller_pitch_mm
            beyond = beyond + self._blurred(y - start) - self._blurred(y - start - self.roller_mm)
        return beyond

    def _with_barrier(self, light: Light, rays: NDArray[np.float64], side: Barrier) -> Light:
        half_mm = self.spacing_mm / 2
        lower = self._beyond(rays, side, half_mm, self.lower_mm)
        inner = self._beyond(rays, side, half_mm, self.height_mm)
        outer = self._beyond(rays, side, half_mm + self.wall_mm, self.height_mm)
        face = np.maximum(lower - inner, 0)
        top = np.maximum(inner - outer, 0)
        return (light * (1 - face - top) + self.face_light * face + self.top_light * top).astype(np.float32)

    def exposed(self, light: Light, noise: Light) -> Picture:
        """Picture of light, with standard normal noise of its shape."""
        seen = np.clip(light, 0, 1) ** np.float32(self.exponent) + np.float32(self.noise) * noise
        return np.rint(255 * np.clip(seen, 0, 1)).astype(np.uint8)


def random_foreign_thermal_line(seed: int) -> ForeignThermalLine:
    """A line as another maker might build it.

    A bar of 120 to 220 mm, within 60 mm of the middle, turned by up to 0.5 degrees, its warm side at 30 to 150
    degrees; a camera 2.2 to 3.4 m above the rollers and 0.4 to 1.5 m back, rolled by up to 1.5 degrees, one pixel of
    which is 4.2 to 5.4 mm; blur of 0.9 to 1.7 px with a halo of up to 3 %; noise of 0.3 to 1.2 % of full scale; codes
    follow light to a power of 0.8 to 1.

    Barriers are 420 to 700 mm apart and 30 to 140 mm high, 40 to 110 mm wide on top; those that hang begin at 30 to
    70 % of their height, 10 to 45 mm beside the rollers' ends. Rollers come every 180 to 400 mm and cover 45 to 75 % of
    the line. Barriers' tops send 28 to 55 % of full scale, their faces 60 to 105 % of that, the floor 2 to 10 % of full
    scale, rollers 10 to 50 % of the tops' light more than the floor.
    """
    rng = np.random.default_rng([seed, 0x6674])
    camera = thermal_camera(rng.uniform(2200, 3400), rng.uniform(400, 1500), rng.uniform(-1.5, 1.5))
    focal = 4.8 / rng.uniform(4.2, 5.4)
    camera = replace(
        camera,
        K=camera.K * np.array([[focal, 1, 1], [1, focal, 1], [1, 1, 1]]),
        dist=np.array([rng.uniform(*DISTORTION), 0.0, 0.0, 0.0, 0.0]),
    )
    height_mm = rng.uniform(30, 140)
    top = rng.uniform(0.28, 0.55)
    pitch_mm = rng.uniform(180, 400)
    floor = rng.uniform(0.02, 0.1)
    return ForeignThermalLine(
        camera,
        spacing_mm=rng.uniform(420, 700),
        height_mm=height_mm,
        bar=Bar(
            rng.uniform(120, 220), rng.uniform(-60, 60), rng.uniform(-0.5, 0.5), warm_side_deg=rng.uniform(30, 150)
        ),
        seed=seed,
        blur=Blur(core_px=rng.uniform(0.9, 1.7), halo_px=6.0, halo_part=rng.uniform(0.0, 0.03)),
        noise=rng.uniform(0.003, 0.012),
        lower_mm=0.0 if rng.random() < SHARE_OF_WALLS else height_mm * rng.uniform(0.3, 0.7),
        roller_gap_mm=rng.uniform(10, 45),
        roller_pitch_mm=pitch_mm,
        roller_mm=pitch_mm * rng.uniform(0.45, 0.75),
        roller_light=floor + top * rng.uniform(0.1, 0.5),  # they show, if only just
        floor_light=floor,
        top_light=top,
        face_light=top * rng.uniform(0.6, 1.05),
        wall_mm=rng.uniform(40, 110),
        exponent=rng.uniform(0.8, 1.0),
    )
