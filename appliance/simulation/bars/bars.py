"""Hot bars on the line: what passes, when, and how brightly it glows."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

DIAMETER_MM = (80.0, 300.0)
TEMPERATURE_C = (1050.0, 1100.0)
OFFSET_MM = 50.0
YAW_DEG = 1.5
REGION_Y_MM = (-250.0, 250.0)  # of the embedded line
LEAST_COVERED_PART = 0.5  # of the region: an end of a bar that covers less has no diameter to be measured

# The line's timetable, in frames: at 25 frames per second a bar takes 2.2 s, and the next one comes 0.2 s later.
FRAMES_PER_BAR = 55
GAP_FRAMES = 5
FIRST_FRAME = 12  # of the first bar: a line starts with a bar that covers the region
PAUSE_EVERY = 12  # bars: one is left out, as when rolls are changed
DRIFT_FRAMES = 180.0
STEP_MM = 200.0  # per frame: 5 m/s at 25 frames per second
ENTRY_MM = -700.0
LENGTH_MM = 7500.0

SECOND_RADIATION_CONSTANT_UM_K = 14387.77
ZERO_C_K = 273.15
REFERENCE_C = 1075.0
# Blue, green, red: centre of the channel in micrometres, and its level at the reference temperature with the
# white balance and exposure of a camera that sees red at half scale.
CHANNEL_UM = np.array([0.46, 0.54, 0.62])
CHANNEL_LEVEL = np.array([0.06, 0.24, 0.55])


@dataclass(frozen=True, slots=True)
class Oxide:
    """Scale on a bar: patches with hard edges that are darker, and uneven cooling over the whole surface.

    Attributes
    ----------
    seed : int
        Where the patches are.
    part : float
        Of the surface that patches cover.
    patch_mm : float
        Typical size of a patch.
    cooler_c : float
        How much cooler a patch looks.
    unevenness_c : float
        Standard deviation of the temperature around and along the bar.
    """

    seed: int
    part: float = 0.2
    patch_mm: float = 30.0
    cooler_c: float = 90.0
    unevenness_c: float = 12.0


@dataclass(frozen=True, slots=True)
class Bar:
    """A bar that lies on the rollers: by default an endless, straight, round cylinder.

    Attributes
    ----------
    diameter_mm : float
        Of a bar that is not round, the mean of its greatest and its least width.
    offset_mm : float
        x of the axis at y = 0.
    yaw_deg : float
        Direction of the axis from +y towards +x.
    temperature_c : float
    warm_side_deg : float
        Direction in the section, from +x towards +z, that glows most; one side cools faster than the other.
    ovality_mm : float
        Greatest minus least width; the section is an ellipse.
    ovality_deg : float
        Direction of the greatest width in the section, from +x towards +z.
    camber_mm : float
        Sagitta of the axis over 1 m, towards -x; the axis is a parabola that touches the straight one at y = 0.
    lift_mm : float
        Height of the bar above the rollers.
    tail_mm, head_mm : float
        Where the bar begins and ends: distance along the axis from y = 0.
    travel_mm : float
        How far the bar has moved along its axis, and its scale with it.
    oxide : Oxide or None
    """

    diameter_mm: float
    offset_mm: float = 0.0
    yaw_deg: float = 0.0
    temperature_c: float = REFERENCE_C
    warm_side_deg: float = 90.0
    ovality_mm: float = 0.0
    ovality_deg: float = 0.0
    camber_mm: float = 0.0
    lift_mm: float = 0.0
    tail_mm: float = -math.inf
    head_mm: float = math.inf
    travel_mm: float = 0.0
    oxide: Oxide | None = None

    @property
    def axis_point_mm(self) -> NDArray[np.float64]:
        """Point of the axis at y = 0, shape (3,), mm."""
        half_height_mm = self.width_mm(np.array([1.0, 0.0])) / 2
        return np.array([self.offset_mm, 0.0, half_height_mm + self.lift_mm])

    @property
    def axis_direction(self) -> NDArray[np.float64]:
        """Unit vector along the axis, shape (3,)."""
        yaw = math.radians(self.yaw_deg)
        return np.array([math.sin(yaw), math.cos(yaw), 0.0])

    @property
    def across(self) -> NDArray[np.float64]:
        """Level unit vector across the axis, shape (3,); with z it spans the section."""
        x, y, _ = self.axis_direction
        return np.array([y, -x, 0.0])

    @property
    def levels(self) -> NDArray[np.float64]:
        """Linear light of the bar's middle in blue, green, red; 1 is full scale."""
        return levels(self.temperature_c)

    @property
    def is_endless(self) -> bool:
        """Whether no end of the bar can be in a picture."""
        return math.isinf(self.tail_mm) and math.isinf(self.head_mm)

    def width_mm(self, along: NDArray[np.float64]) -> float:
        """Distance of the two lines in the section that have direction `along` (across, z) and touch the bar."""
        turn = math.atan2(along[1], along[0]) - math.radians(self.ovality_deg)
        greatest, least = self.diameter_mm + self.ovality_mm / 2, self.diameter_mm - self.ovality_mm / 2
        return math.hypot(greatest * math.sin(turn), least * math.cos(turn))

    def covered_part(self, region_y_mm: tuple[float, float]) -> float:
        """Part of a region along the line that the bar covers."""
        low, high = max(self.tail_mm, region_y_mm[0]), min(self.head_mm, region_y_mm[1])
        return max(0.0, high - low) / (region_y_mm[1] - region_y_mm[0])


def levels(temperature_c: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """Linear light in blue, green, red, shape (..., 3), of a surface at a temperature. Wien's approximation."""
    inverse = 1 / (REFERENCE_C + ZERO_C_K) - 1 / (np.asarray(temperature_c)[..., None] + ZERO_C_K)
    return CHANNEL_LEVEL * np.exp(SECOND_RADIATION_CONSTANT_UM_K / CHANNEL_UM * inverse)


def bar_at(seed: int, frame: int) -> Bar | None:
    """Bar of a frame of the endless line with this seed: it enters, passes and leaves; None between two bars."""
    number, position = divmod(frame + FIRST_FRAME, FRAMES_PER_BAR)
    if position >= FRAMES_PER_BAR - GAP_FRAMES or number % PAUSE_EVERY == PAUSE_EVERY - 1:
        return None
    rng = np.random.default_rng([seed, number])
    phase_offset, phase_yaw = 2 * math.pi * (rng.random(2) + frame / DRIFT_FRAMES)
    head_mm = ENTRY_MM + STEP_MM * position
    return Bar(
        diameter_mm=rng.uniform(*DIAMETER_MM),
        offset_mm=OFFSET_MM * math.sin(phase_offset),
        yaw_deg=YAW_DEG * math.sin(phase_yaw),
        temperature_c=rng.uniform(*TEMPERATURE_C),
        warm_side_deg=rng.uniform(30, 150),
        head_mm=head_mm,
        tail_mm=head_mm - LENGTH_MM,
    )


def truth(bar: Bar | None, region_y_mm: tuple[float, float] = REGION_Y_MM) -> dict[str, object]:
    """What is true of a frame, as it stands beside the frame and in `truth.json`; None where nothing is.

    A bar that covers too little of the region has no diameter to be measured.
    """
    covered = 0.0 if bar is None else bar.covered_part(region_y_mm)
    if bar is None or covered == 0:
        return {"diameter_mm": None, "condition": "no bar"}
    return {
        "diameter_mm": bar.diameter_mm if covered >= LEAST_COVERED_PART else None,
        "axis_point_mm": bar.axis_point_mm.tolist(),
        "axis_direction": bar.axis_direction.tolist(),
        "x_offset_mm": bar.offset_mm,
        "yaw_deg": bar.yaw_deg,
        "temperature_c": bar.temperature_c,
        "condition": "clean" if covered == 1 else "bar end",
        **({} if math.isinf(bar.head_mm) else {"head_y_mm": bar.head_mm}),
        **({} if math.isinf(bar.tail_mm) else {"tail_y_mm": bar.tail_mm}),
    }
