"""Scenes for studies: a rig, a bar and everything around them drawn from a seed, under a named condition.

`CONDITIONS` is the one table of what can be drawn. The same seed gives the same rig, bar, lens and noise under
every condition, so that conditions are compared on equal terms.
"""

import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars import bars
from appliance.simulation.bars.bars import Bar, Oxide
from appliance.simulation.bars.disturbances import Blind, Disturbance, Glare, Haze, Post, Shimmer
from appliance.simulation.bars.line_scene import Picture
from appliance.simulation.bars.scene_setup import SIDES, Setup
from appliance.simulation.bars.silhouette import Glow
from appliance.simulation.response import Response
from appliance.simulation.sensor import Blur, Sensor
from appliance.simulation.true_rig import TrueCamera, TrueRig, random_rig

ImageSize = tuple[int, int]  # columns, rows

RESPONSES: tuple[Response, ...] = ("srgb", "linear", "gamma 2.2")


@dataclass(frozen=True, slots=True)
class StudyScene:
    """One pair of pictures, what a gauge may know of it, and what is true.

    Attributes
    ----------
    rig : TrueRig
        As calibrated.
    left, right : ndarray of uint8, shape (rows, columns, 3)
        Blue-green-red.
    response : str
        How pixel values follow from light.
    truth : dict
        `diameter_mm` (None: nothing to be measured), `condition`, `effects`, `seed`, `region_y_mm` and `bars`, a list.
    """

    rig: TrueRig
    left: Picture
    right: Picture
    response: Response
    truth: dict[str, object]


def draw(condition: str, seed: int, image_size: ImageSize = (800, 600), effects: Sequence[str] = ()) -> StudyScene:
    """A scene under a condition of `CONDITIONS`, with effects of the same table.

    Raises
    ------
    ValueError
        `condition` or `effects` are not in the table.
    """
    setup = set_up(condition, seed, image_size, effects)
    left, right = setup.pair()
    return StudyScene(setup.rig, left, right, setup.sensor.response, setup.truth(condition, effects))


def set_up(condition: str, seed: int, image_size: ImageSize = (800, 600), effects: Sequence[str] = ()) -> Setup:
    """What `draw` draws.

    Raises
    ------
    ValueError
        `condition` or `effects` are not in the table.
    """
    changes = {row.name: row for row in CONDITIONS}
    for argument, kind, names in (("condition", "condition", (condition,)), ("effects", "effect", effects)):
        article = "an" if kind == "effect" else "a"
        for name in names:
            if name not in changes or changes[name].kind != kind:
                raise ValueError(f"{argument}: {name!r} is not {article} {kind} of the simulated mill")
    setup = _usual(seed, image_size)
    for name in (condition, *effects):
        setup = changes[name].change(setup, np.random.default_rng([seed, zlib.crc32(name.encode())]))
    return setup


@lru_cache(maxsize=2)
def _usual(seed: int, image_size: ImageSize) -> Setup:
    """One bar, its warm side at 30 to 150 degrees, and a camera of any mill.

    Full scale is 5,000 to 15,000 electrons, read noise 5 to 20 electrons, blur 0.6 to 1 px with a halo of 3 to 8 px and
    0.5 to 3 %; limbs are up to 6 % darker, and light is uneven by up to 6 %.
    """
    rng = np.random.default_rng([seed, 0x7363])
    return Setup(
        seed=seed,
        rig=random_rig(rng, image_size),
        bars=(
            Bar(
                diameter_mm=rng.uniform(*bars.DIAMETER_MM),
                offset_mm=rng.uniform(-bars.OFFSET_MM, bars.OFFSET_MM),
                yaw_deg=rng.uniform(-bars.YAW_DEG, bars.YAW_DEG),
                temperature_c=rng.uniform(*bars.TEMPERATURE_C),
                warm_side_deg=rng.uniform(30, 150),
            ),
        ),
        sensor=Sensor(RESPONSES[rng.integers(len(RESPONSES))], rng.uniform(5_000, 15_000), rng.uniform(5, 20)),
        blur=Blur(rng.uniform(0.6, 1.0), rng.uniform(3, 8), rng.uniform(0.005, 0.03)),
        glow=Glow(limb_darkening=rng.uniform(0, 0.06), unevenness=rng.uniform(0, 0.06)),
    )


# Conditions and effects: each takes the usual scene and changes one thing.

Rng = np.random.Generator


def _clean(setup: Setup, _: Rng) -> Setup:
    return setup


def _scale(setup: Setup, rng: Rng) -> Setup:
    oxide = Oxide(
        seed=setup.seed,
        part=rng.uniform(0.05, 0.35),
        patch_mm=rng.uniform(15, 60),
        cooler_c=rng.uniform(70, 110),
        unevenness_c=rng.uniform(5, 20),
    )
    return _with_bars(setup, oxide=oxide)


def _rollers(setup: Setup, _: Rng) -> Setup:
    return replace(setup, lit_rollers=True)


def _post(setup: Setup, rng: Rng) -> Setup:
    """At 35 to 70 % of the way from a camera to the bar it hides 15 to 50 % of the bar's width; soft by 1 to 4 px.

    Dark ones send 0.1 to 2 % of full scale, lit ones 10 to 50 %.
    """
    bar, side = setup.bars[0], SIDES[rng.integers(2)]
    centre_mm = getattr(setup.rig, side).centre_mm
    before_mm = bar.axis_point_mm + rng.uniform(*setup.rig.region_y_mm) * bar.axis_direction
    nearness = rng.uniform(0.35, 0.7)  # of the way from the camera to the bar
    foot_x_mm, foot_y_mm = (centre_mm + nearness * (before_mm - centre_mm))[:2].tolist()
    post = Post(
        side=side,
        foot_mm=(foot_x_mm, foot_y_mm),
        radius_mm=nearness * rng.uniform(0.15, 0.5) * bar.diameter_mm / 2,
        light=rng.choice([rng.uniform(0.001, 0.02), rng.uniform(0.1, 0.5)]),
        soft_px=rng.uniform(1, 4),
    )
    return _disturbed(setup, post)


def _haze(setup: Setup, rng: Rng) -> Setup:
    return _disturbed(setup, *(Haze(side, int(rng.integers(1 << 32)), rng.uniform(0.1, 0.45)) for side in SIDES))


def _glare(setup: Setup, rng: Rng) -> Setup:
    """Radius of 1 to 6 % of the picture's width, 20 to 150 % of full scale, an edge of 10 to 50 % of the radius."""
    side = SIDES[rng.integers(2)]
    radius_px = rng.uniform(0.01, 0.06) * setup.rig.left.image_size[0]
    limb, outwards = _limb_px(getattr(setup.rig, side), setup.bars[0], rng.uniform(*setup.rig.region_y_mm), rng)
    x, y = (limb + rng.uniform(0.2, 1.0) * radius_px * outwards).tolist()
    return _disturbed(setup, Glare(side, (x, y), radius_px, rng.uniform(0.1, 0.5) * radius_px, rng.uniform(0.2, 1.5)))


def _overexposed(setup: Setup, rng: Rng) -> Setup:
    return replace(setup, gain=rng.choice([rng.uniform(2.0, 3.0), rng.uniform(4.5, 6.5)]))


def _bar_end(setup: Setup, rng: Rng) -> Setup:
    end = ("tail_mm", "head_mm")[rng.integers(2)]
    return _with_bars(setup, **{end: rng.uniform(*setup.rig.region_y_mm)})


def _two_bars(setup: Setup, rng: Rng) -> Setup:
    first, second = rng.uniform(80, 180, 2)
    apart_mm = (first + second) / 2 + rng.uniform(20, 100)
    middle_mm = rng.uniform(-30, 30)
    bar = setup.bars[0]
    return replace(
        setup,
        bars=(
            replace(bar, diameter_mm=first, offset_mm=middle_mm - apart_mm / 2),
            replace(bar, diameter_mm=second, offset_mm=middle_mm + apart_mm / 2),
        ),
    )


def _no_bar(setup: Setup, _: Rng) -> Setup:
    return replace(setup, bars=())


def _one_blind(setup: Setup, rng: Rng) -> Setup:
    """Black, or covered by something that sends 0.5 to 30 % of full scale."""
    return _disturbed(setup, Blind(SIDES[rng.integers(2)], rng.choice([0.0, rng.uniform(0.005, 0.3)])))


def _ovality(setup: Setup, rng: Rng) -> Setup:
    return _with_bars(setup, ovality_mm=rng.uniform(0.3, 3.0), ovality_deg=rng.uniform(0, 180))


def _camber(setup: Setup, rng: Rng) -> Setup:
    return _with_bars(setup, camber_mm=rng.choice([-1, 1]) * rng.uniform(1, 6))


def _shimmer(setup: Setup, rng: Rng) -> Setup:
    shift_px = rng.uniform(0.1, 0.4)
    return _disturbed(setup, *(Shimmer(side, setup.seed, bar, shift_px) for bar in setup.bars for side in SIDES))


def _bounce(setup: Setup, rng: Rng) -> Setup:
    return replace(setup, bounce_mm=rng.uniform(1, 6))


def _nudged(setup: Setup, rng: Rng) -> Setup:
    turn = rng.normal(0, 1, 3)
    x, y, z = (turn * rng.uniform(0.02, 0.2) / np.linalg.norm(turn)).tolist()
    return replace(setup, nudges={SIDES[rng.integers(2)]: (x, y, z)})


def _defocus(setup: Setup, rng: Rng) -> Setup:
    return replace(setup, blur=replace(setup.blur, core_px=rng.uniform(1.2, 2.2)))


def _jpeg_444(setup: Setup, _: Rng) -> Setup:
    return replace(setup, coding="jpeg 4:4:4")


def _jpeg_420(setup: Setup, _: Rng) -> Setup:
    return replace(setup, coding="jpeg 4:2:0")


def _with_bars(setup: Setup, **changes: object) -> Setup:
    return replace(setup, bars=tuple(replace(bar, **changes) for bar in setup.bars))


def _disturbed(setup: Setup, *more: Disturbance) -> Setup:
    return replace(setup, disturbances=(*setup.disturbances, *more))


def _limb_px(
    camera: TrueCamera, bar: Bar, station_mm: float, rng: Rng
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A point of a limb in the picture, and the unit vector that leads from the bar's axis to it."""
    axis_mm = bar.axis_point_mm + station_mm * bar.axis_direction
    up = np.array([0.0, 0.0, 1.0])
    to_camera = camera.centre_mm - axis_mm
    distance_mm = math.hypot(to_camera @ bar.across, to_camera @ up)
    turn = math.atan2(to_camera @ up, to_camera @ bar.across)
    turn += rng.choice([-1, 1]) * math.acos(bar.diameter_mm / 2 / distance_mm)
    limb_mm = axis_mm + bar.diameter_mm / 2 * (math.cos(turn) * bar.across + math.sin(turn) * up)
    limb, axis = camera.project(limb_mm), camera.project(axis_mm)
    return limb, (limb - axis) / np.linalg.norm(limb - axis)


class Condition(NamedTuple):
    """One row of the table of conditions and effects."""

    name: str
    kind: Literal["condition", "effect"]
    text: str
    change: Callable[[Setup, np.random.Generator], Setup]


CONDITIONS: tuple[Condition, ...] = (
    Condition("clean", "condition", "one smooth bar on a dark line with rollers, barriers and clutter", _clean),
    Condition("scale", "condition", "oxide patches with hard edges, 70 to 110 °C darker, and uneven cooling", _scale),
    Condition("rollers", "condition", "rollers, floor and barriers reflect the bar's glow", _rollers),
    Condition("post", "condition", "a dark or lit post before one camera hides part of the bar", _post),
    Condition("haze", "condition", "steam takes 10 to 45 % of the light and lays a veil over both pictures", _haze),
    Condition("glare", "condition", "a bright blob with a soft edge touches a limb in one picture", _glare),
    Condition("overexposed", "condition", "red, or red and green, are clipped", _overexposed),
    Condition("bar-end", "condition", "a head or a tail lies in the measuring region", _bar_end),
    Condition("two-bars", "condition", "two bars side by side: nothing to be measured", _two_bars),
    Condition("no-bar", "condition", "the empty line: nothing to be measured", _no_bar),
    Condition("one-blind", "condition", "one camera is dark or covered: nothing to be measured", _one_blind),
    Condition("ovality", "effect", "the section is an ellipse, 0.3 to 3 mm out of round", _ovality),
    Condition("camber", "effect", "the axis is curved, 1 to 6 mm over a metre", _camber),
    Condition("shimmer", "effect", "hot air displaces the picture by 0.1 to 0.4 px, anew in each frame", _shimmer),
    Condition("bounce", "effect", "the bar is 1 to 6 mm higher when the right camera exposes", _bounce),
    Condition("nudged", "effect", "a camera has turned by 0.02 to 0.2 degrees since its calibration", _nudged),
    Condition("defocus", "effect", "the pictures are out of focus: core of 1.2 to 2.2 px", _defocus),
    Condition("jpeg-444", "effect", "pictures coded as JPEG, full colour resolution", _jpeg_444),
    Condition("jpeg-420", "effect", "pictures coded as JPEG, halved colour resolution", _jpeg_420),
)
