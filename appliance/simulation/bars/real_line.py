"""A passing bar with what a real line adds: motion, late exposure, hot air, haze, hop, camber, sections out of round.

`draw_line(seed)` draws a third of the lines with one effect, a tenth with none and the others with several, each of a
random size; the frames of a line show one bar that moves, turns and hops from one to the next.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from appliance.simulation.bars.bars import Bar, Oxide
from appliance.simulation.bars.disturbances import Disturbance, DriftingHaze, Shimmer, Side
from appliance.simulation.bars.line_scene import Picture, Scene, View, noise_starts
from appliance.simulation.bars.scene_setup import SIDES, Setup
from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.sensor import Light
from appliance.simulation.true_rig import TrueRig, nudged

EFFECTS = ("motion", "late", "shimmer", "oval", "camber", "nudge", "haze", "hop", "scale")
FRAME_PERIOD_MS = 40.0
SUB_EXPOSURES = 3  # moments of one exposure whose light is added up
ALONE_SHARE, NONE_SHARE = 0.35, 0.1
TOGETHER_SHARE = 0.35  # of lines with several effects that have any one of them


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """How a bar moves; times in ms, lengths in mm.

    Attributes
    ----------
    along_mm_per_ms : float
        Speed along its axis.
    sway_mm, hop_mm : float
        Amplitudes across the line and over the rollers; a bar hops between 0 and twice the amplitude.
    sway_period_ms, hop_period_ms : float
    phase : float
        Of both at time 0, rad; they are a quarter of a turn apart.
    turn_deg_per_ms : float
        How fast the section turns.
    """

    along_mm_per_ms: float = 0.0
    sway_mm: float = 0.0
    hop_mm: float = 0.0
    sway_period_ms: float = 170.0
    hop_period_ms: float = 130.0
    phase: float = 0.0
    turn_deg_per_ms: float = 0.0

    def at(self, bar: Bar, time_ms: float) -> Bar:
        """The bar at a moment; it is where it was drawn at rest."""
        sway = math.sin(self.phase + 2 * math.pi * time_ms / self.sway_period_ms)
        hop = 1 - math.cos(self.phase + 2 * math.pi * time_ms / self.hop_period_ms)
        return replace(
            bar,
            offset_mm=bar.offset_mm + self.sway_mm * sway,
            lift_mm=bar.lift_mm + self.hop_mm * hop,
            ovality_deg=bar.ovality_deg + self.turn_deg_per_ms * time_ms,
            travel_mm=bar.travel_mm + self.along_mm_per_ms * time_ms,
        )


@dataclass(frozen=True, slots=True)
class Line:
    """A line with its bars and everything that moves.

    Attributes
    ----------
    setup : Setup
        Rig as it was calibrated, bars at rest, sensor, lens.
    effects : tuple of str
        Of `EFFECTS`.
    motion : Motion
    exposure_ms : float
    late_ms : float
        How much later the right camera exposes.
    nudges : dict
        Cameras that have turned since the calibration, by side: degrees about their own x, y and z axis.
    disturbances : tuple of Disturbance
    """

    setup: Setup
    effects: tuple[str, ...] = ()
    motion: Motion = field(default_factory=Motion)
    exposure_ms: float = 0.0
    late_ms: float = 0.0
    nudges: dict[Side, tuple[float, float, float]] = field(default_factory=dict[Side, tuple[float, float, float]])
    disturbances: tuple[Disturbance, ...] = ()

    @property
    def rig(self) -> TrueRig:
        """Cameras as they are now."""
        if not self.nudges:
            return self.setup.rig
        left, right = (
            nudged(camera, self.nudges.get(side, (0.0, 0.0, 0.0)))
            for side, camera in zip(SIDES, self.setup.rig.cameras, strict=True)
        )
        return replace(self.setup.rig, left=left, right=right)

    def pairs(self, frames: int) -> Iterator[tuple[Picture, Picture]]:
        """Left and right pictures, blue-green-red, of so many frames."""
        setup = self.setup
        scene = Scene(self.rig, setup.seed, setup.sensor, setup.blur, setup.glow)
        for frame in range(frames):
            starts = noise_starts(setup.seed, frame)
            yield (
                self._picture("left", scene.left, frame, starts[0]),
                self._picture("right", scene.right, frame, starts[1]),
            )

    def _picture(self, side: Side, view: View, frame: int, noise_start: int) -> Picture:
        time_ms = frame * FRAME_PERIOD_MS + (self.late_ms if side == "right" else 0.0)
        count = SUB_EXPOSURES if self.exposure_ms and self.motion != Motion() else 1
        moments_ms = time_ms + self.exposure_ms * ((np.arange(count) + 0.5) / count - 0.5)
        light = np.zeros_like(view.background)
        for moment in moments_ms:
            light += self._light(view, float(moment)) / np.float32(count)
        for disturbance in self.disturbances:
            if disturbance.side == side:
                light = disturbance.changed(light, view, frame)
        return view.exposed(light, noise_start)

    def _light(self, view: View, time_ms: float) -> Light:
        light = view.background.copy()
        bars = [self.motion.at(bar, time_ms) for bar in self.setup.bars]
        for bar in sorted(bars, key=lambda bar: -abs(bar.offset_mm - view.camera.centre_mm[0])):
            view.add_bar(light, bar)
        return light


def drawn_effects(seed: int) -> tuple[str, ...]:
    """Which effects the line of a seed has."""
    rng = np.random.default_rng([seed, 0x6566])
    kind = rng.random()
    if kind < NONE_SHARE:
        return ()
    if kind < NONE_SHARE + ALONE_SHARE:
        return (EFFECTS[rng.integers(len(EFFECTS))],)
    return tuple(name for name in EFFECTS if rng.random() < TOGETHER_SHARE)


def draw_line(seed: int, effects: tuple[str, ...] | None = None) -> Line:
    """The line of a seed, with the effects of `drawn_effects` unless they are given.

    Sizes: exposure of 0.2 to 1 ms at 2 to 8 m/s with a sway of 0.03 to 0.3 mm/ms; the right camera late by 0.2 to 1.5
    ms while the bar sways with 0.06 to 0.6 mm/ms and hops by 0.4 to 2 mm with 0.05 to 0.4 mm/ms; sways are of 0.5 to
    4 mm to either side; shimmer of 0.05 to 0.4 px; widths that differ by 0.1 to 0.8 % of the diameter, on sections
    that stand still or turn by up to 0.5 degrees/ms; 1 to 6 mm of camber over a metre; a camera turned by 0.01 to
    0.06 degrees about any axis; haze that takes up to 20 % of the light and grows by 1 to 6 % a frame while it drifts
    by 3 to 20 px, in patches of 40 to 149 px; a hop of 0.2 to 2 mm; scale over 5 to 30 % of the bar in patches of 15
    to 60 mm, 70 to 110 degrees C cooler, on a surface that is uneven by 5 to 20 degrees C.

    Raises
    ------
    ValueError
        An effect is not of `EFFECTS`.
    """
    effects = drawn_effects(seed) if effects is None else effects
    if unknown := set(effects) - set(EFFECTS):
        raise ValueError(f"effects: {', '.join(sorted(unknown))} is not of the real line")
    rng = np.random.default_rng([seed, 0x726C])
    line = Line(set_up("clean", seed), effects)
    for name in EFFECTS:  # all sizes are drawn, so that an effect has the same one alone and together
        changed = _CHANGES[name](line, rng)
        line = changed if name in effects else line
    return replace(line, effects=effects)


def several_bars(seed: int, count: int) -> Line:
    """Clean bars side by side, 25 to 50 mm apart, as thick as fits between the barriers, 120 mm at most."""
    rng = np.random.default_rng([seed, 0x7362])
    line = Line(set_up("clean", seed))
    diameters = rng.uniform(0.7, 1.0, count) * min(120.0, (420 - 50 * (count - 1)) / count)
    gaps = rng.uniform(25, 50, count)
    right = np.cumsum(diameters + gaps)
    middle = right - diameters / 2
    middle -= (middle[0] - diameters[0] / 2 + right[-1]) / 2
    bar = line.setup.bars[0]
    bars = tuple(replace(bar, diameter_mm=float(d), offset_mm=float(x)) for d, x in zip(diameters, middle, strict=True))
    return replace(line, setup=replace(line.setup, bars=bars))


def _bars(line: Line, **changes: object) -> Line:
    return replace(line, setup=replace(line.setup, bars=tuple(replace(bar, **changes) for bar in line.setup.bars)))


def _motion(line: Line, rng: np.random.Generator) -> Line:
    motion = replace(_swaying(line.motion, rng, 0.3), along_mm_per_ms=rng.uniform(2, 8))
    return replace(line, motion=motion, exposure_ms=rng.uniform(0.2, 1.0))


def _late(line: Line, rng: np.random.Generator) -> Line:
    motion = _swaying(line.motion, rng, 0.6)
    hop_mm, up = rng.uniform(0.2, 1.0), rng.uniform(0.05, 0.4)
    motion = replace(motion, hop_mm=hop_mm, hop_period_ms=2 * math.pi * hop_mm / up)
    return replace(line, motion=motion, late_ms=rng.uniform(0.2, 1.5))


def _swaying(motion: Motion, rng: np.random.Generator, fastest: float) -> Motion:
    """Sway of 0.5 to 4 mm with a random phase, up to `fastest` mm/ms."""
    sway_mm, speed = rng.uniform(0.5, 4.0), rng.uniform(0.1 * fastest, fastest)
    return replace(
        motion, sway_mm=sway_mm, sway_period_ms=2 * math.pi * sway_mm / speed, phase=rng.uniform(0, 2 * math.pi)
    )


def _shimmer(line: Line, rng: np.random.Generator) -> Line:
    shift_px = rng.uniform(0.05, 0.4)
    more = tuple(Shimmer(side, line.setup.seed, bar, shift_px) for bar in line.setup.bars for side in SIDES)
    return replace(line, disturbances=(*line.disturbances, *more))


def _oval(line: Line, rng: np.random.Generator) -> Line:
    share, turns = rng.uniform(0.001, 0.008), rng.random() < 0.5
    angle = rng.choice([rng.uniform(0, 180), 0.0, 90.0])
    motion = replace(line.motion, turn_deg_per_ms=rng.uniform(-0.5, 0.5)) if turns else line.motion
    return _bars(
        replace(line, motion=motion), ovality_mm=share * line.setup.bars[0].diameter_mm, ovality_deg=float(angle)
    )


def _camber(line: Line, rng: np.random.Generator) -> Line:
    return _bars(line, camber_mm=float(rng.choice([-1, 1]) * rng.uniform(1, 6)))


def _nudge(line: Line, rng: np.random.Generator) -> Line:
    turn = rng.normal(0, 1, 3)
    x, y, z = (turn * rng.uniform(0.01, 0.06) / np.linalg.norm(turn)).tolist()
    return replace(line, nudges={SIDES[rng.integers(2)]: (x, y, z)})


def _haze(line: Line, rng: np.random.Generator) -> Line:
    more = tuple(
        DriftingHaze(
            side,
            int(rng.integers(1 << 32)),
            density=rng.uniform(0, 0.2),
            growth=rng.uniform(0.01, 0.06),
            drift_px=float(rng.choice([-1, 1]) * rng.uniform(3, 20)),
            cell_px=int(rng.integers(40, 150)),
        )
        for side in SIDES
    )
    return replace(line, disturbances=(*line.disturbances, *more))


def _hop(line: Line, rng: np.random.Generator) -> Line:
    hop_mm, phase = rng.uniform(0.1, 1.0), rng.uniform(0, 2 * math.pi)
    return replace(line, motion=replace(line.motion, hop_mm=max(hop_mm, line.motion.hop_mm), phase=phase))


def _scale(line: Line, rng: np.random.Generator) -> Line:
    oxide = Oxide(
        seed=line.setup.seed,
        part=rng.uniform(0.05, 0.3),
        patch_mm=rng.uniform(15, 60),
        cooler_c=rng.uniform(70, 110),
        unevenness_c=rng.uniform(5, 20),
    )
    return _bars(line, oxide=oxide)


_CHANGES = {
    "motion": _motion,
    "late": _late,
    "shimmer": _shimmer,
    "oval": _oval,
    "camber": _camber,
    "nudge": _nudge,
    "haze": _haze,
    "hop": _hop,
    "scale": _scale,
}
