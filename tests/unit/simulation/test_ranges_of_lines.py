"""Lines, rigs and scenes that are drawn at random: each size lies where the docstring says, and reaches both ends."""

import math

import numpy as np
import pytest
from placed_numbers import PlacedNumbers

from appliance.simulation.bars.real_line import draw_line
from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.foreign_thermal_line import random_foreign_thermal_line
from appliance.simulation.ingots.conditions import ingot_line
from appliance.simulation.thermal_line import random_thermal_line
from appliance.simulation.true_rig import random_rig

ENDS = (0.0, 1.0)
SEED = 9_000_001  # of no other test: what is drawn here must stay in nobody's cache


@pytest.fixture
def placed(monkeypatch):
    """Draw something whose random numbers all lie at one place of their ranges."""

    def drawn(share, make, *words, chance=0.0, deviation=0.0, whole=None):
        with monkeypatch.context() as patch:
            numbers = PlacedNumbers(share, chance, deviation, whole=whole)
            patch.setattr(np.random, "default_rng", lambda *_: numbers)
            return make(*words)

    return drawn


def pixel_mm(line):
    left, right = line.camera.project(np.array([[-5.0, 0.0, 0.0], [5.0, 0.0, 0.0]]))
    return 10 / np.hypot(*(right - left))


THERMAL = {  # of a line: our own makers', other makers'
    "camera's height, mm": (lambda line: line.camera.centre_mm[2], (2200, 3200), (2200, 3400)),
    "camera's place, mm": (lambda line: -line.camera.centre_mm[1], (400, 1500), (400, 1500)),
    "roll, degrees": (lambda line: np.rad2deg(np.arcsin(-line.camera.R[1, 0])), (-1, 1), (-1.5, 1.5)),
    "pixel, mm": (pixel_mm, (4.4, 5.2), (4.2, 5.4)),
    "k1": (lambda line: line.camera.dist[0], (0, 0), (-0.16, 0.04)),
    "diameter, mm": (lambda line: line.bar.diameter_mm, (120, 220), (120, 220)),
    "offset, mm": (lambda line: line.bar.offset_mm, (-60, 60), (-60, 60)),
    "yaw, degrees": (lambda line: line.bar.yaw_deg, (-0.5, 0.5), (-0.5, 0.5)),
    "warm side, degrees": (lambda line: line.bar.warm_side_deg, (30, 150), (30, 150)),
    "spacing, mm": (lambda line: line.spacing_mm, (420, 620), (420, 700)),
    "height, mm": (lambda line: line.height_mm, (60, 140), (30, 140)),
    "blur, px": (lambda line: line.blur.core_px, (1.0, 1.7), (0.9, 1.7)),
    "halo": (lambda line: line.blur.halo_part, (0.01, 0.03), (0.0, 0.03)),
    "noise": (lambda line: line.noise, (0.004, 0.012), (0.003, 0.012)),
}
FOREIGN = {
    "lower edge over height": (lambda line: line.lower_mm / line.height_mm, (0.3, 0.7)),
    "gap, mm": (lambda line: line.roller_gap_mm, (10, 45)),
    "pitch, mm": (lambda line: line.roller_pitch_mm, (180, 400)),
    "covered": (lambda line: line.roller_mm / line.roller_pitch_mm, (0.45, 0.75)),
    "top": (lambda line: line.top_light, (0.28, 0.55)),
    "face over top": (lambda line: line.face_light / line.top_light, (0.6, 1.05)),
    "floor": (lambda line: line.floor_light, (0.02, 0.1)),
    "roller over floor": (lambda line: (line.roller_light - line.floor_light) / line.top_light, (0.1, 0.5)),
    "wall, mm": (lambda line: line.wall_mm, (40, 110)),
    "exponent": (lambda line: line.exponent, (0.8, 1.0)),
}


def test_thermal_lines_are_between_the_sizes_that_are_stated(placed):
    for which, make in ((1, random_thermal_line), (2, random_foreign_thermal_line)):
        ends = [placed(share, make, SEED, chance=1.0) for share in ENDS]
        for name, row in THERMAL.items():
            assert [row[0](line) for line in ends] == pytest.approx(row[which], rel=1e-4, abs=1e-9), name
    for name, (read, stated) in FOREIGN.items():
        assert [read(line) for line in ends] == pytest.approx(stated), name
    assert placed(1.0, random_foreign_thermal_line, SEED, chance=0.0).lower_mm == 0, "a wall"


@pytest.mark.parametrize("away", [0.0, 1.0])
def test_rigs_are_between_the_sizes_that_are_stated(away):
    """Distance, baseline and elevation of both cameras' middle, and each camera's place, aim, roll and lens."""
    stated = [(1500, 500, 40, -12, 150, (-0.12, -0.05, -0.0008, -0.0008, -0.02), 0.998, -0.01)]
    stated += [(4000, 2500, 80, 12, 250, (0.03, 0.08, 0.0008, 0.0008, 0.02), 1.002, 0.01)]
    for share, (distance, baseline, elevation, roll, reach, lens, aspect, shift) in zip(ENDS, stated, strict=True):
        rig = random_rig(PlacedNumbers(share, deviation=away))
        centres = np.array([camera.centre_mm for camera in rig.cameras]) - away * 0.03 * distance
        middle = centres.mean(axis=0) - [0, 0, 120]
        assert np.linalg.norm(centres - [0, 0, 120], axis=1) == pytest.approx(distance)
        assert centres[1] - centres[0] == pytest.approx([baseline, 0, 0], abs=1e-6)
        assert np.rad2deg(np.arctan2(middle[2], -middle[1])) == pytest.approx(elevation)
        assert np.abs(rig.region_y_mm) == pytest.approx(reach)
        for camera in rig.cameras:
            towards = np.array([0, 0, 120]) + 15 * away - camera.centre_mm
            assert camera.R[2] == pytest.approx(towards / np.linalg.norm(towards))
            assert np.rad2deg(np.arcsin(camera.R[0, 2] / np.hypot(*camera.R[2, :2]))) == pytest.approx(-roll)
            assert camera.dist == pytest.approx(lens)
            assert camera.K[1, 1] / camera.K[0, 0] == pytest.approx(aspect)
            assert camera.K[:2, 2] == pytest.approx(np.array([399.5, 299.5]) + 800 * shift)
            corners = np.array([(x, y, z) for x in (-230, 230) for y in (-270, 270) for z in (0, 300)])
            seen = corners @ camera.R.T + camera.t
            filled = np.abs(camera.K[0, 0] * seen[:, :2] / seen[:, 2:]).max(axis=0) / (400, 300)
            assert filled.max() == pytest.approx((0.75, 0.95)[int(share)])


def sway(line):
    return line.motion.sway_mm, 2 * math.pi * line.motion.sway_mm / line.motion.sway_period_ms


def hop(line):
    return 2 * line.motion.hop_mm, 2 * math.pi * line.motion.hop_mm / line.motion.hop_period_ms


def oval(line):
    bar = line.setup.bars[0]
    return 100 * bar.ovality_mm / bar.diameter_mm, line.motion.turn_deg_per_ms


def drifting(line):
    haze = line.disturbances[0]
    return haze.density, haze.growth, haze.drift_px, haze.cell_px


def scale(setup):
    oxide = setup.bars[0].oxide
    return oxide.part, oxide.patch_mm, oxide.cooler_c, oxide.unevenness_c


REAL = {
    "motion": (lambda line: (line.motion.along_mm_per_ms, line.exposure_ms), (2, 0.2), (8, 1)),
    "late": (lambda line: (line.late_ms, *hop(line), *sway(line)), (0.2, 0.4, 0.05, 0.5, 0.06), (1.5, 2, 0.4, 4, 0.6)),
    "shimmer": (lambda line: [one.shift_px for one in line.disturbances], (0.05, 0.05), (0.4, 0.4)),
    "oval": (oval, (0.1, -0.5), (0.8, 0.5)),
    "camber": (lambda line: [line.setup.bars[0].camber_mm], [-1], [6]),
    "nudge": (lambda line: np.linalg.norm(*line.nudges.values()), 0.01, 0.06),
    "haze": (drifting, (0, 0.01, -3, 40), (0.2, 0.06, 20, 149)),
    "hop": (lambda line: hop(line)[0], 0.2, 2),
    "scale": (lambda line: scale(line.setup), (0.05, 15, 70, 5), (0.3, 60, 110, 20)),
}


@pytest.mark.parametrize("effect", REAL)
def test_what_a_real_line_adds_is_between_the_sizes_that_are_stated(placed, effect):
    read, *stated = REAL[effect]
    for share, expected in zip(ENDS, stated, strict=True):
        line = placed(share, draw_line, SEED + int(share), (effect,), deviation=1.0)
        assert read(line) == pytest.approx(expected), share
    if effect == "motion":
        lines = [placed(share, draw_line, SEED, ("motion",), deviation=1.0) for share in ENDS]
        assert [sway(line)[1] for line in lines] == pytest.approx([0.03, 0.3])


def test_a_nudged_camera_turns_about_any_axis_to_either_side(placed):
    for make, words, most in (
        (draw_line, (SEED, ("nudge",)), 0.06),
        (set_up, ("clean", SEED, (80, 60), ("nudged",)), 0.2),
    ):
        for deviation in (-1.0, 1.0):
            turned = placed(1.0, make, *words, deviation=deviation).nudges
            assert next(iter(turned.values())) == pytest.approx([deviation * most / math.sqrt(3)] * 3)


def glare_of(glare):
    return glare.radius_px, glare.soft_px, glare.light


SCENES = {
    "scale": (scale, (0.05, 15, 70, 5), (0.35, 60, 110, 20)),
    "haze": (lambda setup: [one.density for one in setup.disturbances], (0.1, 0.1), (0.45, 0.45)),
    "ovality": (lambda setup: setup.bars[0].ovality_mm, 0.3, 3),
    "camber": (lambda setup: setup.bars[0].camber_mm, -1, 6),
    "shimmer": (lambda setup: [one.shift_px for one in setup.disturbances], (0.1, 0.1), (0.4, 0.4)),
    "bounce": (lambda setup: setup.bounce_mm, 1, 6),
    "defocus": (lambda setup: setup.blur.core_px, 1.2, 2.2),
    "overexposed": (lambda setup: setup.gain, 2, 6.5),
    "glare": (lambda setup: glare_of(setup.disturbances[0]), (0.8, 0.08, 0.2), (4.8, 2.4, 1.5)),
    "one-blind": (lambda setup: setup.disturbances[0].light, 0, 0.3),
    "two-bars": (
        lambda setup: [setup.bars[1].offset_mm - setup.bars[0].offset_mm, *(bar.diameter_mm for bar in setup.bars)],
        (100, 80, 80),
        (280, 180, 180),
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_what_a_study_adds_is_between_the_sizes_that_are_stated(placed, name):
    read, *stated = SCENES[name]
    words = ("clean", (name,)) if name in ("ovality", "camber", "shimmer", "bounce", "defocus") else (name, ())
    for share, expected in zip(ENDS, stated, strict=True):
        setup = placed(share, set_up, words[0], SEED + int(share), (80, 60), words[1])
        assert read(setup) == pytest.approx(expected), share


def test_a_post_stands_between_a_camera_and_the_bar_and_hides_the_stated_part(placed):
    for share, (near, part, light, soft_px) in enumerate([(0.35, 0.15, 0.001, 1), (0.7, 0.5, 0.5, 4)]):
        setup = placed(share, set_up, "post", SEED + 20 + share, (80, 60))
        post, bar, camera = setup.disturbances[0], setup.bars[0], setup.rig.cameras[share]
        hidden = bar.axis_point_mm + setup.rig.region_y_mm[share] * bar.axis_direction
        foot_mm = camera.centre_mm + near * (hidden - camera.centre_mm)
        assert post.foot_mm == pytest.approx(foot_mm[:2])
        assert post.radius_mm == pytest.approx(near * part * bar.diameter_mm / 2), "seen over the bar's width"
        assert (post.light, post.soft_px) == pytest.approx((light, soft_px))


USUAL = {  # of any study's scene
    "diameter, mm": (lambda setup: setup.bars[0].diameter_mm, 80, 300),
    "offset, mm": (lambda setup: setup.bars[0].offset_mm, -50, 50),
    "yaw, degrees": (lambda setup: setup.bars[0].yaw_deg, -1.5, 1.5),
    "temperature, degrees C": (lambda setup: setup.bars[0].temperature_c, 1050, 1100),
    "warm side, degrees": (lambda setup: setup.bars[0].warm_side_deg, 30, 150),
    "full scale, electrons": (lambda setup: setup.sensor.full_well_electrons, 5_000, 15_000),
    "read noise, electrons": (lambda setup: setup.sensor.read_noise_electrons, 5, 20),
    "blur, px": (lambda setup: setup.blur.core_px, 0.6, 1.0),
    "halo, px": (lambda setup: setup.blur.halo_px, 3, 8),
    "halo": (lambda setup: setup.blur.halo_part, 0.005, 0.03),
    "limbs": (lambda setup: setup.glow.limb_darkening, 0, 0.06),
    "unevenness": (lambda setup: setup.glow.unevenness, 0, 0.06),
}


def test_usual_scenes_are_between_the_sizes_that_are_stated(placed):
    for share in ENDS:
        setup = placed(share, set_up, "clean", SEED + 10 + int(share), (80, 60))
        for name, (read, *stated) in USUAL.items():
            assert read(setup) == pytest.approx(stated[int(share)]), name


def seen_from(line):
    """How high over an ingot's axis the camera is, and how far along the line."""
    return line.camera.centre_mm[2] - line.radius_mm, line.camera.centre_mm[1]


INGOTS = {  # of an ingot line
    "radius, mm": (lambda line: line.radius_mm, 170, 330),
    "distance, radii": (lambda line: np.hypot(*seen_from(line)) / line.radius_mm, 22, 42),
    "elevation, degrees": (lambda line: np.rad2deg(np.arctan2(*seen_from(line))), 13, 25),
    "travel, radii": (lambda line: line.travel_mm / line.radius_mm, 2.2, 8.4),
    "temperature, degrees C": (lambda line: line.temperature_c, 1030, 1180),
    "k1": (lambda line: line.camera.dist[0], -0.06, 0.02),
    "brightness": (lambda line: line.brightness, 0.4, 2.5),
    "veil": (lambda line: line.veil, 0.003, 0.03),
    "shake, px": (lambda line: line.shake_px, 0, 0.3),
    "blur, px": (lambda line: line.blur.core_px, 0.7, 1.5),
    "halo, px": (lambda line: line.blur.halo_px, 3, 8),
    "halo": (lambda line: line.blur.halo_part, 0.005, 0.03),
    "bloom": (lambda line: line.bloom, 0.005, 0.04),
    "quality": (lambda line: line.quality, 78, 95),
    "full scale, electrons": (lambda line: line.sensor.full_well_electrons, 2_500, 12_000),
    "read noise, electrons": (lambda line: line.sensor.read_noise_electrons, 8, 30),
}


def test_ingot_lines_are_between_the_sizes_that_are_stated(placed):
    for share in ENDS:
        line = placed(share, ingot_line, SEED, "clean", (480, 270))
        for name, (read, *stated) in INGOTS.items():
            assert read(line) == pytest.approx(stated[int(share)]), name
        shown = line.length_mm * np.sin(np.deg2rad((13, 25)[int(share)])) / (2 * line.radius_mm)
        assert shown == pytest.approx((0.3, 0.85)[int(share)])
        ingot = line.ingot("bottom", PlacedNumbers(share))
        ratios = ingot.radius_mm / line.radius_mm, ingot.length_mm / line.length_mm
        assert ratios == pytest.approx([(0.97, 0.9), (1.03, 1.1)][int(share)])
