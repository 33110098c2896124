"""Still marks: a camera that moved is noticed, one that did not is not."""

import cv2
import numpy as np
import pytest

from vision.calibration.json_fields import Fields
from vision.calibration.still_marks import NO_MARKS, Marks, find_marks

BOARD = np.array([(x, y) for x in range(180, 260, 20) for y in range(140, 200, 20)], dtype=np.float64)


def line(seed=1, size=(400, 300)):
    """A cluttered still picture."""
    rng = np.random.default_rng(seed)
    picture = np.full(size[::-1], 40.0)
    for _ in range(60):
        x, y, width, height = (int(n) for n in rng.integers((0, 0, 15, 15), (size[0], size[1], 60, 60)))
        picture[y : y + height, x : x + width] = rng.uniform(20, 90)
    return picture


def taken(picture, seed, light=1.0):
    noisy = light * cv2.GaussianBlur(picture, (0, 0), 0.8) + np.random.default_rng(seed).normal(0, 1.5, picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


def moved(picture, shift=(0.0, 0.0), degrees=0.0):
    turn = cv2.getRotationMatrix2D((200, 150), degrees, 1.0)
    turn[:, 2] += shift
    return cv2.warpAffine(picture, turn, (400, 300), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)


@pytest.fixture(scope="module")
def marks():
    return find_marks(taken(line(), 1), taken(line(), 2), (BOARD, BOARD + 8))


def test_no_mark_lies_on_the_board(marks):
    assert len(marks.patch) >= 10
    on_board = [cv2.pointPolygonTest(cv2.convexHull(BOARD.astype(np.float32)), tuple(map(float, p)), measureDist=False)
                for p in marks.place_px]  # fmt: skip
    assert max(on_board) < 0


@pytest.mark.parametrize("light", [0.5, 1.0, 1.6])
def test_a_camera_that_stands_still_is_not_suspected_in_another_light(marks, light):
    assert marks.moved_px(taken(line(), 3, light)) < 0.15


@pytest.mark.parametrize("shift", [(0.5, 0.0), (-1.2, 0.9), (3.0, -2.0)])
def test_a_shift_is_measured(marks, shift):
    assert marks.moved_px(taken(moved(line(), shift), 4)) == pytest.approx(np.hypot(*shift), abs=0.2)


@pytest.mark.parametrize("shift", [(0.4, 0.0), (0.0, 0.4), (-0.6, 0.3)])
def test_marks_on_lines_that_lean_the_same_way_tell_both_parts_of_a_shift(shift):
    """They look like the rollers and barriers beside a line."""
    lean = np.array([[1.0, 0.9, -130.0], [0.0, 1.0, 0.0]])
    picture = cv2.warpAffine(line(), lean, (400, 300), flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REFLECT)
    found = find_marks(taken(picture, 1), taken(picture, 2), (BOARD, BOARD + 8)).motion(taken(moved(picture, shift), 4))
    told = np.linalg.solve(found.curvature.sum(axis=0), found.slope.sum(axis=0))
    np.testing.assert_allclose(told, shift, atol=0.08)


@pytest.mark.parametrize("shift", [(20.0, -15.0), (-31.0, 8.0), (60.0, 40.0)])
def test_a_camera_that_moved_far_is_not_taken_for_one_without_marks(marks, shift):
    assert marks.moved_px(taken(moved(line(), shift), 4)) == pytest.approx(np.hypot(*shift), abs=1.0)


def test_a_turn_is_noticed_although_its_mean_shift_is_small(marks):
    assert marks.moved_px(taken(moved(line(), degrees=0.4), 5)) > 0.3


def test_colour_pictures_do_as_well(marks):
    assert marks.moved_px(np.dstack([taken(line(), 6)] * 3)) < 0.15


def test_what_hides_marks_does_not_count(marks):
    picture = taken(line(), 7)
    picture[:, 150:260] = 230
    assert marks.moved_px(picture) < 0.15


@pytest.mark.parametrize("picture", [np.zeros((300, 400), np.uint8), taken(line(seed=9), 8)])
def test_marks_give_no_displacement_in_a_picture_of_another_scene(marks, picture):
    assert np.isnan(marks.moved_px(picture))
    assert np.isnan(NO_MARKS.moved_px(picture))


def test_marks_survive_their_file(marks):
    again = Marks.from_fields(Fields(marks.to_values()))
    np.testing.assert_array_equal(again.place_px, marks.place_px)
    np.testing.assert_allclose(again.patch, marks.patch, rtol=1e-3)


def test_a_damaged_patch_is_refused_with_its_key(marks):
    values = marks.to_values()
    for damaged in ("", "AAAA", 7):
        with pytest.raises(ValueError, match="patch"):
            Marks.from_fields(Fields(values | {"patch": damaged}))
