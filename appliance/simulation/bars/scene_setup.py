"""All that decides the pictures of a simulated line: rig, bars, sensor, and what disturbs them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from appliance.simulation.bars import bars
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.disturbances import Blind, Disturbance, Side
from appliance.simulation.bars.line_scene import Picture, Scene, View, noise_starts
from appliance.simulation.bars.silhouette import Glow
from appliance.simulation.sensor import Blur, Coding, Sensor, coded
from appliance.simulation.true_rig import TrueCamera, TrueRig, nudged

SIDES: tuple[Side, Side] = ("left", "right")


@dataclass(frozen=True, slots=True)
class Setup:
    """Everything that decides a scene's pictures.

    Attributes
    ----------
    seed : int
        Background and noise.
    rig : TrueRig
        As it was when it was calibrated.
    bars : tuple of Bar
    sensor, blur, glow : Sensor, Blur, Glow
    nudges : dict
        Cameras that have turned since, by side: degrees about their own x, y and z axis.
    bounce_mm : float
        How much higher the bars are when the right camera exposes.
    lit_rollers : bool
        Whether the line reflects the first bar's glow.
    disturbances : tuple of Disturbance
        From the bar to the camera.
    gain : float
        Exposure over the usual one.
    coding : str
        Of the pictures.
    """

    seed: int
    rig: TrueRig
    bars: tuple[Bar, ...]
    sensor: Sensor
    blur: Blur
    glow: Glow
    nudges: dict[Side, tuple[float, float, float]] = field(default_factory=dict[Side, tuple[float, float, float]])
    bounce_mm: float = 0.0
    lit_rollers: bool = False
    disturbances: tuple[Disturbance, ...] = ()
    gain: float = 1.0
    coding: Coding = "lossless"

    @property
    def diameter_mm(self) -> float | None:
        """Width of the bar across the views, None when there is no bar that both cameras could measure."""
        if len(self.bars) != 1 or any(isinstance(disturbance, Blind) for disturbance in self.disturbances):
            return None
        if self.bars[0].covered_part(self.rig.region_y_mm) < bars.LEAST_COVERED_PART:
            return None
        return sum(_width_mm(self.bars[0], camera) for camera in self.rig.cameras) / 2

    def truth(self, condition: str, effects: Sequence[str]) -> dict[str, object]:
        """What is true of the scene; see `StudyScene.truth`."""
        return {
            "diameter_mm": self.diameter_mm,
            "condition": condition,
            "effects": list(effects),
            "seed": self.seed,
            "region_y_mm": list(self.rig.region_y_mm),
            "bars": [_bar_truth(bar, self.rig) for bar in self.bars],
        }

    def scene_as_calibrated(self) -> Scene:
        """The line as it was when the cameras were calibrated: cold, and nothing has moved."""
        return _scene(self.rig, self.seed, self.sensor, self.blur, glow=self.glow, lit_by=None)

    def pair(self, frame: int = 0) -> tuple[Picture, Picture]:
        """Left and right picture, blue-green-red; the frame chooses noise and shimmer."""
        lit_by = self.bars[0] if self.lit_rollers and self.bars else None
        scene = _scene(self._rig_now(), self.seed, self.sensor, self.blur, glow=self.glow, lit_by=lit_by)
        starts = noise_starts(self.seed, frame)
        return self._picture("left", scene.left, frame, starts[0]), self._picture(
            "right", scene.right, frame, starts[1]
        )

    def _rig_now(self) -> TrueRig:
        if not self.nudges:
            return self.rig
        still = (0.0, 0.0, 0.0)
        left, right = (
            nudged(camera, self.nudges.get(side, still)) for side, camera in zip(SIDES, self.rig.cameras, strict=True)
        )
        return replace(self.rig, left=left, right=right)

    def _picture(self, side: Side, view: View, frame: int, noise_start: int) -> Picture:
        light = view.background.copy()
        lift_mm = self.bounce_mm if side == "right" else 0.0
        for bar in sorted(self.bars, key=lambda bar: -abs(bar.offset_mm - view.camera.centre_mm[0])):
            view.add_bar(light, replace(bar, lift_mm=bar.lift_mm + lift_mm))
        for disturbance in self.disturbances:
            if disturbance.side == side:
                light = disturbance.changed(light, view, frame)
        return coded(view.exposed(light * np.float32(self.gain), noise_start), self.coding)


# Conditions of one seed share their rig and what stands still in it, which takes longest to draw.
@lru_cache(maxsize=2)
def _scene(rig: TrueRig, seed: int, sensor: Sensor, blur: Blur, *, glow: Glow, lit_by: Bar | None) -> Scene:
    return Scene(rig, seed, sensor, blur, glow, lit_by=lit_by)


def _width_mm(bar: Bar, camera: TrueCamera) -> float:
    """Width of the bar across a camera's line of sight."""
    to_camera = camera.centre_mm - bar.axis_point_mm
    return bar.width_mm(np.array([to_camera @ bar.across, to_camera[2]]))


def _bar_truth(bar: Bar, rig: TrueRig) -> dict[str, object]:
    return {
        "mean_diameter_mm": bar.diameter_mm,
        "width_left_mm": _width_mm(bar, rig.left),
        "width_right_mm": _width_mm(bar, rig.right),
        "ovality_mm": bar.ovality_mm,
        "camber_mm": bar.camber_mm,
        "axis_point_mm": bar.axis_point_mm.tolist(),
        "axis_direction": bar.axis_direction.tolist(),
        "covered_part": bar.covered_part(rig.region_y_mm),
        "temperature_c": bar.temperature_c,
    }
