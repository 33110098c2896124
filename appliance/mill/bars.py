"""Hot bars on the line: what passes, when, and how brightly it glows."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

DIAMETER_MM = (80.0, 300.0)
TEMPERATURE_C = (1050.0, 1100.0)
OFFSET_MM = 50.0
YAW_DEG = 1.5
FRAMES_PER_BAR = 55
GAP_FRAMES = 5
DRIFT_FRAMES = 180.0

SECOND_RADIATION_CONSTANT_UM_K = 14387.77
REFERENCE_K = 1075.0 + 273.15
# Blue, green, red: centre of the channel in micrometres, and its level at the reference temperature with the
# white balance and exposure of a camera that sees red at half scale.
CHANNEL_UM = np.array([0.46, 0.54, 0.62])
CHANNEL_LEVEL = np.array([0.06, 0.24, 0.55])


@dataclass(frozen=True, slots=True)
class Bar:
    """A round bar that lies on the rollers: a cylinder with its axis at height D/2.

    Attributes
    ----------
    diameter_mm : float
    offset_mm : float
        x of the axis at y = 0.
    yaw_deg : float
        Direction of the axis from +y towards +x.
    temperature_c : float
    warm_side_deg : float
        Direction in the section, from +x towards +z, that glows most; one side cools faster than the other.
    """

    diameter_mm: float
    offset_mm: float = 0.0
    yaw_deg: float = 0.0
    temperature_c: float = 1075.0
    warm_side_deg: float = 90.0

    @property
    def axis_point_mm(self) -> NDArray[np.float64]:
        """Point of the axis at y = 0, shape (3,), mm."""
        return np.array([self.offset_mm, 0.0, self.diameter_mm / 2])

    @property
    def axis_direction(self) -> NDArray[np.float64]:
        """Unit vector along the axis, shape (3,)."""
        yaw = math.radians(self.yaw_deg)
        return np.array([math.sin(yaw), math.cos(yaw), 0.0])

    @property
    def levels(self) -> NDArray[np.float64]:
        """Linear light of the bar's middle in blue, green, red; 1 is full scale. Wien's approximation."""
        exponent = SECOND_RADIATION_CONSTANT_UM_K / CHANNEL_UM
        return CHANNEL_LEVEL * np.exp(exponent * (1 / REFERENCE_K - 1 / (self.temperature_c + 273.15)))


def bar_at(seed: int, frame: int) -> Bar | None:
    """Bar of a frame of the endless line with this seed; None in the gap between two bars."""
    number, position = divmod(frame, FRAMES_PER_BAR)
    if position >= FRAMES_PER_BAR - GAP_FRAMES:
        return None
    rng = np.random.default_rng([seed, number])
    phase_offset, phase_yaw = 2 * math.pi * (rng.random(2) + frame / DRIFT_FRAMES)
    return Bar(
        diameter_mm=rng.uniform(*DIAMETER_MM),
        offset_mm=OFFSET_MM * math.sin(phase_offset),
        yaw_deg=YAW_DEG * math.sin(phase_yaw),
        temperature_c=rng.uniform(*TEMPERATURE_C),
        warm_side_deg=rng.uniform(30, 150),
    )


def truth(bar: Bar | None) -> dict[str, object]:
    """What is true of a frame, as it stands beside the frame and in `truth.json`; None where nothing is."""
    if bar is None:
        return {"diameter_mm": None, "condition": "no bar"}
    return {
        "diameter_mm": bar.diameter_mm,
        "axis_point_mm": bar.axis_point_mm.tolist(),
        "axis_direction": bar.axis_direction.tolist(),
        "x_offset_mm": bar.offset_mm,
        "yaw_deg": bar.yaw_deg,
        "temperature_c": bar.temperature_c,
        "condition": "clean",
    }
