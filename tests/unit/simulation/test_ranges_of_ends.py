"""Ends of ingots and what stands around them, drawn at random: each size lies where the docstring says."""

from dataclasses import astuple
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from placed_numbers import PlacedNumbers

from appliance.simulation.bars.background import _mirror_image
from appliance.simulation.bars.bars import Bar
from appliance.simulation.ingots import cast_faces, faces, foreign_faces, glare, hall, tongs
from appliance.simulation.ingots.conditions import ingot_line
from appliance.simulation.ingots.faces import FACE_CELLS
from appliance.simulation.ingots.timetable import Glare, Sight
from appliance.simulation.ingots.view import LineView
from appliance.simulation.sensor import Blur
from appliance.simulation.true_rig import TrueCamera, look_at

ENDS = (0.0, 1.0)
HARD = 0.15625  # of the smooth step a quarter of the way up: a^2 (3 - 2 a)
BLEMISHES = {  # least and largest factor of light, of the weakest and of the strongest
    ("_slope", 0.0): ((1, 1), (0.8, 1.2)),
    ("_slope", 1.0): ((1, 1), (1, 1 + 0.5 * HARD)),
    ("_cool_middle", 0.0): ((0.95, 1), (0.6, 1)),
    ("_flakes", 0.0): ((0.95, 1), (0.55, 1)),
    ("_chamfer", 0.0): ((0.8, 1), (1, 1.12)),
    ("_saw_marks", 0.0): ((0.99, 1.01), (0.95, 1.05)),
}


@pytest.mark.parametrize(("name", "chance"), BLEMISHES)
def test_blemishes_are_as_weak_and_as_strong_as_stated(name, chance):
    for share, stated in zip(ENDS, BLEMISHES[name, chance], strict=True):
        light = getattr(foreign_faces, name)(PlacedNumbers(share, chance))
        assert (light.min(), light.max()) == pytest.approx(stated, abs=0.003), share


@pytest.mark.parametrize("share", [0.0, 0.9])
def test_chips_are_darker_or_lighter_by_as_much_as_stated(share):
    """Strength of 0.1 to 0.4, from wholly dark to 0.3 of it lighter; the very largest would lie beside the end."""
    light = foreign_faces._chips(PlacedNumbers(share))
    strongest = light.ravel()[np.argmax(np.abs(light - 1))]
    assert strongest == pytest.approx(1 + (0.1 + 0.3 * share) * (1.3 * share - 1), abs=1e-4)


LOOKS = {  # kind, whether faint or with scale: wrinkles, contrast, relief, rim, recess, mottling, flakes, their depth
    ("top", True): ((3, 0.07, 0, 0.05, 0, 0.01, 0, 0.05), (11, 0.15, 0.2, 0.28, 0.25, 0.06, 0.06, 0.25)),
    ("top", False): ((3, 0.15, 0, 0.05, 0, 0.01, 0, 0.05), (11, 0.45, 0.2, 0.28, 0.25, 0.06, 0.06, 0.25)),
    ("bottom", True): ((0, 0, 0, 0.03, 0, 0.01, 0.08, 0.2), (0, 0, 0, 0.25, 0.15, 0.06, 0.4, 0.45)),
    ("bottom", False): ((0, 0, 0, 0.03, -0.03, 0.01, 0, 0.05), (0, 0, 0, 0.25, 0.06, 0.06, 0.05, 0.25)),
}


@pytest.mark.parametrize(("label", "hard"), LOOKS)
def test_faces_differ_by_as_much_as_stated(label, hard):
    for share, stated in zip(ENDS, LOOKS[label, hard], strict=True):
        looks = faces.random_looks(label, PlacedNumbers(share, chance=1.0 - hard))
        assert astuple(looks)[:8] == pytest.approx(stated), share
        assert looks.scratches == share * (1 if label == "top" else 5)


def test_blotches_have_the_stated_unevenness():
    assert [foreign_faces._blotches(PlacedNumbers(share)).std() for share in ENDS] == pytest.approx([0.01, 0.07])


def test_a_cool_middle_has_a_border_as_ragged_as_that_of_scale():
    light = foreign_faces._cool_middle(PlacedNumbers(1.0))
    turn = np.linspace(0, 2 * np.pi, 500)
    place = (FACE_CELLS - 1) / 2 * (1 + 0.85 * np.stack([np.cos(turn), np.sin(turn) / 1.25])).astype(np.float32)
    around = cv2.remap(light, *place[..., None], cv2.INTER_LINEAR)[:, 0]
    sides = np.flatnonzero(np.diff(np.sign(around - np.median(around))))
    assert 10 < len(sides) < 30, "blobs of a twelfth of the end's width change side about twenty times"
    assert around.std() > 0.05


@pytest.mark.parametrize(("which", "sign"), [(0.0, -1), (0.5, -1), (1.0, 1)])
def test_two_scratches_in_three_are_dark(which, sign):
    light = foreign_faces._strokes(PlacedNumbers(0.5, whole=which), 1, lambda: 0.0, 0.3)
    strongest = light.ravel()[np.argmax(np.abs(light - 1))]
    assert sign * (strongest - 1) == pytest.approx(0.3 * 0.65, abs=0.12)


def test_folds_are_of_three_kinds_of_which_one_has_a_direction():
    """The part of the squared slopes that one direction has more than the other: 1 where all folds are straight."""
    uneven = []
    for which in (0.0, 0.5, 1.0):
        numbers = PlacedNumbers(None, whole=which)
        shares = []
        for _ in range(6):
            y, x = np.gradient(foreign_faces._folds(7.0, numbers))
            shares.append(np.hypot((x * x - y * y).mean(), 2 * (x * y).mean()) / (x * x + y * y).mean())
        uneven.append(np.mean(shares))
    assert uneven[2] > 0.25
    assert max(uneven[:2]) < 0.18


def test_waves_of_a_labyrinth_are_about_as_many_as_asked_for():
    frequency = np.fft.fftfreq(FACE_CELLS) * FACE_CELLS
    number_of = np.hypot(frequency[:, None], frequency[None, :])
    for share, steepness, width in ((0.0, 0.8, 0.15), (1.0, 2.5, 0.4)):
        height = faces._labyrinth(12.0, PlacedNumbers(share)).astype(float)
        waves = np.arctanh(np.clip(2 * height - 1, -1 + 1e-7, 1 - 1e-7)) / steepness
        assert waves.std() == pytest.approx(1, abs=0.02)
        power = np.abs(np.fft.fft2(waves - waves.mean())) ** 2
        spread = np.sqrt(np.average((number_of - 12) ** 2, weights=power))
        assert spread == pytest.approx(width * 12 / 2, rel=0.15), "the power falls twice as fast as the amplitude"


@pytest.mark.parametrize(("share", "depth"), [(0.5, 0.035), (1.0, 0.06)])
def test_a_furrow_is_as_deep_as_stated(share, depth):
    height = cast_faces._scratches(PlacedNumbers(share, whole=1 / 11))
    assert height.min() == pytest.approx(-depth, rel=0.2)
    assert 0 < height.max() < depth / 2, "lips"


@pytest.mark.parametrize(("share", "depth", "wide"), [(0.5, 0.04, 0.07), (1.0, 0.07, 0.12)])
def test_a_dent_is_as_deep_and_wide_as_stated(share, depth, wide):
    height = cast_faces._dents(PlacedNumbers(share, whole=1 / 4))
    assert height.min() == pytest.approx(-depth, rel=0.05)
    cell = 2 / (FACE_CELLS - 1)
    assert height.sum() * cell**2 == pytest.approx(-depth * np.pi * wide**2, rel=0.1), "a bell of Gauss' shape"


@pytest.fixture(scope="module")
def hall_camera():
    pose = look_at(np.array([0.0, 5000.0, 2500.0]), np.array([0.0, -2000.0, 600.0]), 0.0)
    return TrueCamera(np.array([[160.0, 0, 160], [0, 160, 90], [0, 0, 1]]), np.zeros(5), *pose, (320, 180))


LIGHTS = [(0.05, 0.1, 0.6, (0.7, 0.85, 0.8)), (0.25, 0.45, 1.4, (1.2, 1.1, 1.15))]  # dark hall, floor, frame, tint


@pytest.mark.parametrize("share", [0, 1])
def test_hall_floor_and_frame_are_as_bright_as_stated(hall_camera, share):
    dark, floor, frame, tint = LIGHTS[share]
    rays = hall_camera.rays(hall_camera.pixel_grid()).astype(np.float32)
    numbers = PlacedNumbers(share, whole=0.0)  # posts on the left, no lamp
    drawn = hall.draw(hall_camera, rays, numbers, radius_mm=300.0, brightness=2.0, blur=Blur(0.3, halo_part=0.0))
    light = drawn.light / (0.04 * 2.0 * np.array(tint))
    x, y = drawn.x_mm, drawn.y_mm
    inner_mm, near = 300 * (1.4 + share), (y > -4000) & (y < 2500)
    outer_mm = inner_mm + 300 * (0.25 + 0.45 * share)
    on_frame = near & (y < 1500) & (x > inner_mm + 35) & (x < outer_mm - 10)  # a lamp's reflection lies further on
    assert light[rays[..., 2] > 0.02][-50:] == pytest.approx(dark, rel=1e-3)
    assert light[near & (x > outer_mm + 150)].mean() == pytest.approx(dark + floor, rel=0.1)
    assert light[on_frame].mean() == pytest.approx(frame, rel=0.15)


@pytest.mark.parametrize(("share", "side"), [(0.0, -1), (1.0, 1)])
def test_posts_beside_the_line_are_of_the_stated_sizes(share, side):
    seen = []
    picture = np.zeros((90, 90), np.float32)

    def project(corners):
        seen.append(corners)
        return corners[:, [0, 2]] / 100 + 45

    hall._post(picture, SimpleNamespace(project=project), 500.0, PlacedNumbers(share))
    corners, least, size = seen[0], seen[0].min(axis=0), np.ptp(seen[0], axis=0)
    assert side * (least[0] if side > 0 else corners[0, 0]) - 500 == pytest.approx((150, 2500)[int(share)])
    assert size.tolist() == [(60, 350)[int(share)], 0, 600 + (300, 2500)[int(share)]]
    assert least[2] == -600
    assert picture.max() == pytest.approx((0.05, 0.5)[int(share)])


@pytest.mark.parametrize(("corner_px", "drawn"), [(9_000, True), (11_000, False)])
def test_a_post_far_beyond_the_picture_is_left_out(corner_px, drawn):
    picture = np.zeros((50, 50), np.float32)
    corners = np.array([[10.0, 20], [corner_px, 20], [corner_px, 40], [10, 40]])
    hall._post(picture, SimpleNamespace(project=lambda _: corners), 500.0, PlacedNumbers(0.5))
    assert (picture[30, 30] > 0) == drawn


@pytest.mark.parametrize(("share", "side_mm", "along_mm", "level"), [(0.0, 30, 80, 0.03), (1.0, 120, 300, 0.12)])
def test_a_lamps_reflection_lies_on_the_line_and_is_of_the_stated_size(share, side_mm, along_mm, level):
    sign = 2 * share - 1
    x = np.array([sign * 500, sign * 500 + side_mm, sign * 500], np.float32)
    y = np.array([sign * 2500, sign * 2500, sign * 2500 + along_mm], np.float32)
    assert hall._shine(x, y, 500.0, PlacedNumbers(share)) == pytest.approx(level * np.exp([0.0, -1.0, -1.0]), rel=1e-4)


def test_a_glare_has_its_size_its_light_and_a_ragged_outline():
    x, y = np.meshgrid(np.arange(-750, 750, 4, np.float32), np.arange(-500, 500, 4, np.float32))
    line = hall.Hall(np.zeros((*x.shape, 3), np.float32), np.ones_like(x), x, y)
    patch = glare.draw(Glare((40.0, -20.0), (200.0, 100.0), 0.8, 0.0, seed=3), line, core_px=0.5)
    rows, columns = np.nonzero(np.hypot((x - 40) / 200, (y + 20) / 100) < 2)
    assert (patch.rows, patch.columns) == (
        slice(rows.min(), rows.max() + 1),
        slice(columns.min(), columns.max() + 1),
    )
    light = patch.light[..., 1] / 0.8
    away = np.hypot((x - 40) / 200, (y + 20) / 100)[patch.rows, patch.columns]
    assert light[away < 0.3] == pytest.approx(1, abs=0.02)
    assert (light > 0.5).sum() * 16 == pytest.approx(np.pi * 200 * 100, rel=0.1)
    assert light[np.abs(away - 1) < 0.02].std() > 0.2, "ragged: a step would be half as bright all around"


def test_the_tongs_arms_grip_an_ingot_from_both_sides():
    line = ingot_line(3)
    ingot = line.typical_ingot("top", np.random.default_rng(3))
    pose = line.place(0.3 * line.travel_mm)
    columns, rows = line.camera.image_size
    for opened, lifted_mm in ((1.0, 0.0), (1.5, 0.4 * ingot.radius_mm)):
        seen = tongs.coverage(line.camera, Sight(ingot, pose, "hanging", tongs_mm=lifted_mm), (0, 0), (rows, columns))
        axis, across, _ = pose.axes
        middle = np.array(pose.end_mm) + 0.45 * ingot.length_mm * axis + [0, 0, lifted_mm]
        elbows = [opened * side * 1.25 * across + [0, 0, 1.3] for side in (-1, 1)]
        points = middle + ingot.radius_mm * np.array([*elbows, np.array([0, 0, 1.3])])
        turn = cv2.Rodrigues(line.camera.R)[0]
        pixels = cv2.projectPoints(points, turn, line.camera.t, line.camera.K, line.camera.dist)[0][:, 0]
        assert (pixels > 0).all()
        assert [seen[round(y), round(x)] for x, y in pixels] == [1, 1, 0], "two elbows, and nothing between them"


def test_an_ingot_reflects_a_hundredth_of_the_lamps():
    line = ingot_line(3)
    sight = Sight(line.typical_ingot("top", np.random.default_rng(3)), line.place(0.0), "placed")
    light = [
        LineView.colour(SimpleNamespace(line=SimpleNamespace(white=line.white, brightness=brightness)), sight)
        for brightness in (0.5, 2.5)
    ]
    assert light[1] - light[0] == pytest.approx(0.02, rel=1e-3)


def test_a_ray_that_leaves_beside_a_bar_mirrors_it_only_where_it_comes_nearer():
    bar = Bar(100.0)
    beside = bar.axis_point_mm + np.array([52.0, 0.0, 0.0])
    onward = np.array([[0.005, 0.0, 1.0], [-0.005, 0.0, 1.0]]).T
    mirrored = _mirror_image(bar, np.column_stack([beside, beside]).astype(np.float32), onward.astype(np.float32))
    assert mirrored[0] == 0
    assert mirrored[1] > 0.3
