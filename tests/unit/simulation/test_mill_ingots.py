"""The simulated ingot line: solids, faces, timetable and truth against projections of another kind."""

import itertools
import re
from collections import Counter
from functools import lru_cache

import cv2
import numpy as np
import pytest

from appliance.cameras.simulated.ingots import IngotMillSource
from appliance.simulation.ingots.conditions import INGOT_CONDITIONS, ingot_line, ingot_sequence
from appliance.simulation.ingots.faces import FACE_CELLS, LABELS, face, random_looks
from appliance.simulation.ingots.sequence import IngotSequence
from appliance.simulation.ingots.solid import Pose, see
from appliance.simulation.ingots.timetable import timetable
from appliance.simulation.response import encode

SMALL = (480, 270)
NAMES = [row.name for row in INGOT_CONDITIONS]
RED = 2


@lru_cache(maxsize=20)
def drawn(condition, seed=1, ingots=1):
    return list(ingot_sequence(seed, condition, ingots, SMALL).frames)


def projected(camera, points):
    return cv2.projectPoints(points, cv2.Rodrigues(camera.R)[0], camera.t, camera.K, camera.dist)[0][:, 0]


def circle_mm(ingot, pose, along_mm=0.0):
    """Points around the end, or a section further into the body, turned by OpenCV's rotation."""
    turn = np.linspace(0, 2 * np.pi, 721)
    level = np.stack([ingot.radius_mm * np.cos(turn), np.full_like(turn, -along_mm), ingot.radius_mm * np.sin(turn)])
    pitch, yaw = -np.deg2rad(pose.pitch_deg), np.deg2rad(pose.yaw_deg)
    turned = cv2.Rodrigues(np.array([0, 0, yaw]))[0] @ cv2.Rodrigues(np.array([pitch, 0, 0]))[0] @ level
    return turned.T + pose.end_mm


def contrast(picture):
    """Structure of a few pixels, over the light around it."""
    light = picture.astype(np.float32)
    return float(cv2.GaussianBlur(light / cv2.GaussianBlur(light, (0, 0), len(light) / 5), (0, 0), 1).std())


POSES = [
    Pose((20.0, 100.0, 250.0), 3.0),
    Pose((-200.0, 300.0, 400.0), -8.0, 6.0),
    Pose((100.0, 700.0, 300.0), 2.0, 30.0),
]


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("seed", [3, 4, 5])
def test_an_ingot_covers_the_pixels_that_its_projected_rims_enclose(seed, pose):
    line = ingot_line(seed)
    ingot = line.typical_ingot("top", np.random.default_rng(seed))
    seen = see(line.camera, line.camera.rays(line.camera.pixel_grid()).astype(np.float32), ingot, pose, 8)
    rims = [projected(line.camera, circle_mm(ingot, pose, along)) for along in (0.0, ingot.length_mm)]
    rows, columns = np.mgrid[seen.rows, seen.columns]
    for coverage, outline in ((seen.face, rims[0]), (seen.coverage, cv2.convexHull(np.concatenate(rims).astype("f4")))):
        expected = cv2.moments(outline.astype(np.float32))
        area = float(coverage.sum())
        assert area == pytest.approx(expected["m00"], rel=0.004)
        assert (coverage * columns).sum() / area == pytest.approx(expected["m10"] / expected["m00"], abs=0.05)
        assert (coverage * rows).sum() / area == pytest.approx(expected["m01"] / expected["m00"], abs=0.05)


@pytest.mark.parametrize("seed", range(3))
def test_the_end_is_in_the_picture_where_the_truth_says(seed):
    sequence = ingot_sequence(seed, "clean", 1)
    code = 255 * encode(np.linspace(0, 1, 256), sequence.line.sensor.response)
    frames = [(picture, told) for picture, told in itertools.islice(sequence.frames, 32) if told.state == "placed"]
    errors = []
    for picture, told in frames[::4]:
        light = np.interp(
            picture[round(told.y) - 1 : round(told.y) + 2, :, RED].mean(axis=0), code, np.linspace(0, 1, 256)
        )
        inside = np.median(light[round(told.x - told.r / 2) : round(told.x + told.r / 2)])
        for side in (-1, 1):
            place = told.x + side * np.arange(0.85, 1.15, 0.0005) * told.r
            profile = np.interp(place, np.arange(len(light)), light)
            half = (inside + profile[-1]) / 2
            errors.append(side * (place[np.flatnonzero(profile < half)[0]] - (told.x + side * told.r)))
    assert len(errors) >= 6
    assert np.abs(errors).max() < 1.5
    assert np.mean(errors) == pytest.approx(0, abs=0.5)


def test_radii_and_positions_differ_from_line_to_line():
    sequences = [ingot_line(seed) for seed in range(60)]
    radii = np.array([line.radius_px() for line in sequences])
    assert radii[:, 0].min() < 39
    assert radii[:, 1].max() > 68
    boxes = np.array([line.roi_crop() for line in sequences])
    assert np.ptp(boxes[:, 0]) > 50
    assert (boxes[:, :2] >= 0).all()
    assert (boxes[:, :2] + boxes[:, 2:] <= [960, 540]).all()


def test_an_ingot_is_lowered_placed_and_taken_away_in_this_order():
    for seed in range(3):
        states = "".join(
            (moment.sights[-1].state if moment.sights else "empty")[:2] + " "
            for moment in timetable(ingot_line(seed), 3)
        )
        assert re.fullmatch(r"((em ){3,}(ha ){5,}(lo ){0,3}(pl ){22,}(le )+){3}(em ){2,}", states)


def test_tops_and_bottoms_come_equally_often_and_in_any_order():
    orders = []
    for seed in range(8):
        ingots = dict.fromkeys(s.ingot for m in timetable(ingot_line(seed, "clean", SMALL), 4) for s in m.sights)
        labels = [ingot.label for ingot in ingots]
        assert Counter(labels) == {"top": 2, "bottom": 2}
        orders.append(tuple(labels))
    assert len(set(orders)) > 2


def test_the_same_seed_gives_the_same_bits_and_another_seed_another_line():
    def first(seed):
        return list(itertools.islice(ingot_sequence(seed, "mixed", 1, SMALL).frames, 14))

    once, again, other = first(7), first(7), first(8)
    assert all(np.array_equal(a, b) and told == same for (a, told), (b, same) in zip(once, again, strict=True))
    assert not np.array_equal(once[0][0], other[0][0])
    assert not np.array_equal(once[0][0], once[1][0])  # each frame has noise of its own


def test_a_line_has_the_same_camera_under_every_condition():
    cameras = [ingot_line(3, name).camera for name in NAMES]
    assert all(np.array_equal(camera.K, cameras[0].K) and np.array_equal(camera.t, cameras[0].t) for camera in cameras)


def test_wrinkles_show_on_tops_and_yet_some_bottoms_have_more_contrast_than_some_tops():
    middle = slice(FACE_CELLS // 5, -FACE_CELLS // 5)
    measured = {label: [] for label in LABELS}
    for label in LABELS:
        for seed in range(30):
            rng = np.random.default_rng([seed, 9])
            measured[label].append(contrast(face(random_looks(label, rng), rng)[middle, middle]))
    top, bottom = np.array(measured["top"]), np.array(measured["bottom"])
    assert np.median(top) > 2 * np.median(bottom)
    assert 0.85 < np.mean(top[:, None] > bottom) < 0.99


def test_the_label_is_that_of_the_end_in_the_picture():
    measured = {label: [] for label in LABELS}
    for picture, told in drawn("clean", ingots=2):
        if told.present:
            x, y, half = round(told.x), round(told.y), round(0.6 * told.r)
            end = cv2.resize(
                picture[y - half : y + half, x - half : x + half, 1], (40, 40), interpolation=cv2.INTER_AREA
            )
            measured[told.label].append(contrast(end))
    assert min(measured["top"]) > max(measured["bottom"])


def test_two_ingots_have_different_faces():
    line = ingot_line(3, "clean", SMALL)
    one, other = (line.ingot("top", np.random.default_rng(seed)).face for seed in (1, 2))
    assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.8
    assert not np.array_equal(one, other)


@pytest.mark.parametrize("condition", ["clean", "overexposed"])
def test_red_is_clipped_only_where_the_truth_says_so(condition):
    told_over = 0
    for picture, told in drawn(condition):
        if told.present:
            disc = cv2.circle(
                np.zeros(picture.shape[:2], np.uint8), (round(told.x), round(told.y)), round(told.r * 0.7), 1, -1
            )
            clipped = np.mean(picture[disc > 0, RED] >= 254)
            told_over += told.over
            assert clipped > 0.05 if told.over else clipped < 0.25
    assert (told_over >= 10) == (condition == "overexposed")


@pytest.mark.parametrize("condition", ["empty", "glare-alone", "hanging-only"])
def test_without_an_ingot_on_the_line_nothing_is_present(condition):
    frames = drawn(condition)
    assert not any(told.present or told.label or told.x for _, told in frames)
    states = {told.state for _, told in frames}
    assert states == ({"empty", "hanging"} if condition == "hanging-only" else {"empty"})
    still = frames[0][0].astype(int)
    changed = max(np.abs(picture - still).max() for picture, _ in frames)
    assert (changed > 100) == (condition != "empty")


def test_glare_borders_the_ingot_for_a_part_of_its_way():
    touches = [told.touch for _, told in drawn("glare") if told.present]
    assert 3 <= sum(touches) < len(touches)
    assert not any(told.touch for _, told in drawn("clean"))


def test_drift_makes_the_ingot_brighter_towards_the_rolls():
    def green(picture, told):
        return float(picture[round(told.y) - 8 : round(told.y) + 8, round(told.x) - 8 : round(told.x) + 8, 1].mean())

    for condition, low, high in (("drift", 1.15, 1.6), ("clean", 0.9, 1.1)):
        placed = [(picture, told) for picture, told in drawn(condition) if told.state == "placed"]
        assert low < green(*placed[-1]) / green(*placed[0]) < high


def test_two_ingots_are_on_the_line_together_and_the_truth_is_about_the_nearer_one():
    line = ingot_line(2, "two")
    both = [m.sights for m in timetable(line, 2) if [s.state for s in m.sights] == ["placed", "placed"]]
    assert len(both) > 5
    for behind, before in both:
        assert behind.pose.end_mm[1] < before.pose.end_mm[1] - before.ingot.length_mm
    told = [told for _, told in drawn("two", ingots=2) if told.present]
    labels = [label for label, _ in itertools.groupby(t.label for t in told)]
    assert sorted(labels) == ["bottom", "top"]


def test_a_moved_camera_moves_the_picture_by_ten_pixels_and_leaves_the_regions():
    for seed in range(2):
        before, after = (IngotSequence(ingot_line(seed, name, SMALL), 1) for name in ("clean", "camera-moved"))
        assert before.roi_crop == after.roi_crop
        assert all(np.array_equal(before.references[label], after.references[label]) for label in LABELS)
        moments = [
            moment for moment in timetable(before.line, 1) if moment.sights and moment.sights[-1].state == "placed"
        ]
        end_mm = np.array(moments[0].sights[-1].pose.end_mm)
        moved = after._view.camera.project(end_mm) - before._view.camera.project(end_mm)
        assert np.hypot(*moved) == pytest.approx(10, rel=0.05)


def test_the_exposure_changes_by_one_stop():
    gains = {ingot_line(seed, "exposure-changed", SMALL).gain for seed in range(8)}
    assert gains == {0.5, 2.0}


def test_references_show_a_top_and_a_bottom_from_edge_to_edge():
    sequence = ingot_sequence(5, "clean", 1)
    for square in sequence.references.values():
        assert square.shape == (64, 64, 3)
        red = square[..., RED].astype(float)
        assert red[32, 4] > 0.7 * red[32, 32]  # the end reaches to the sides, and to the bottom
        assert red[32, 59] > 0.7 * red[32, 32]
        assert red[59, 32] > 0.7 * red[32, 32]
        assert red[62, 2] < 0.6 * red[32, 32]
    top, bottom = (contrast(sequence.references[label][12:52, 12:52, 1]) for label in LABELS)
    assert top > 2 * bottom


def test_the_ingot_line_as_a_camera_says_that_it_is_simulated_and_what_is_true():
    with IngotMillSource(seed=3, rate_hz=0, condition="clean") as source:
        frames = [source.next(0.0) for _ in range(2)]
        assert source.simulated
    assert [frame.sequence for frame in frames] == [0, 1]
    assert frames[0].truth["state"] == "empty"
    expected = [picture for picture, _ in itertools.islice(ingot_sequence(3, "clean").frames, 2)]
    assert all(np.array_equal(frame.picture, picture) for frame, picture in zip(frames, expected, strict=True))


def test_pictures_that_nobody_took_are_left_out_and_counted():
    with IngotMillSource(seed=3, rate_hz=100, condition="clean") as source:
        source.next(1.0)
        source._pacer._start_s -= 0.2  # twenty periods pass
        frame = source.next(1.0)
    assert frame.sequence >= 20
    assert frame.dropped == frame.sequence - 1
    assert frame.truth["frame"] == frame.sequence


@pytest.mark.parametrize("call", [lambda: ingot_sequence(1, "fog"), lambda: IngotMillSource(1, 10.0, "fog")])
def test_an_unknown_condition_is_a_wrong_call(call):
    with pytest.raises(ValueError, match="condition: 'fog'"):
        call()
