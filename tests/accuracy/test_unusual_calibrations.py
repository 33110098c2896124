"""Calibrations that need no more than the pictures show: cameras as they are mounted, boards as people have them."""

from dataclasses import replace

import numpy as np
import pytest
from board_truth import BOARD, IMAGE_SIZE, flat_board, observe, random_cameras, random_poses
from mill_scenes import perfect_rig

from appliance.simulation.bars.study_scenes import draw
from vision.calibration.acceptance import CalibrationError
from vision.calibration.checkerboard import Board
from vision.calibration.stereo import calibrate
from vision.sizing.gauge import Gauge

NOISE_PX = 0.05
NO_BOARD = (None, None)


class Seen:
    """Corners of one board in both pictures, at many poses and at both heights of registration."""

    def __init__(self, seed, board=BOARD):
        self.rng, self.board = np.random.default_rng(seed), board
        self.cameras = random_cameras(self.rng)
        self.poses = [self._see(corners) for corners in random_poses(self.rng, self.cameras)]
        self.low, self.high = (self._see(flat_board(height_mm)) for height_mm in (0.0, 200.0))

    def _see(self, corners):
        """Corners of `board` on the plane of the corners of `BOARD` at the same place."""
        grid = corners.reshape(4, 7, 3)
        x, y = (axis / np.linalg.norm(axis) for axis in (grid[0, -1] - grid[0, 0], grid[0, 0] - grid[-1, 0]))
        points = self.board.corners_mm[:, :2] @ np.array([x, y]) + corners.mean(axis=0)
        return observe(self.rng, self.cameras, points, NOISE_PX)

    def changed(self, change):
        """All pairs after a change of each."""
        self.poses = [change(*pair) for pair in self.poses]
        self.low, self.high = change(*self.low), change(*self.high)
        return self

    def calibrate(self, board=None, **options):
        return calibrate(self.poses, self.low, self.high, board or self.board, IMAGE_SIZE, **options)

    def assert_true(self, found):
        true_mm = float(np.linalg.norm(self.cameras[0].centre - self.cameras[1].centre))
        assert not found.dropped
        assert abs(found.baseline_mm - true_mm) < 4 * found.baseline_u_mm
        assert found.baseline_u_mm < 2.0


def half_turned(corners):
    """Corners in a picture that was taken upside down."""
    return np.array(IMAGE_SIZE) - 1.0 - corners


def mirrored(corners):
    """Corners in a mirrored picture, in the order in which a board that faces the camera has them."""
    flipped = np.column_stack([IMAGE_SIZE[0] - 1.0 - corners[:, 0], corners[:, 1]])
    return flipped.reshape(4, 7, 2)[:, ::-1].reshape(-1, 2)


@pytest.mark.parametrize(
    "change",
    [
        lambda left, right: (right, left),
        lambda left, right: (half_turned(left), half_turned(right)),
        lambda left, right: (mirrored(left), mirrored(right)),
    ],
    ids=["names exchanged", "upside down", "mirrored"],
)
def test_cameras_are_calibrated_as_they_are_mounted_and_the_report_says_what_is_unusual(change):
    seen = Seen(40).changed(change)
    found = seen.calibrate()
    seen.assert_true(found)
    assert any("mirrored or upside down" in warning for warning in found.warnings)


def test_one_camera_upside_down_is_nothing_unusual():
    seen = Seen(41).changed(lambda left, right: (left, half_turned(right)))
    found = seen.calibrate()
    seen.assert_true(found)
    assert found.warnings == ()


def test_cameras_behind_one_another_along_the_line_are_a_warning():
    seen = Seen(42)
    quarter = Board((8, 5), 50.0, 0.0, 200.0, 0.01, 0.1)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    seen.low, seen.high = (
        observe(seen.rng, seen.cameras, quarter.corners_mm @ turn.T + [0.0, 0.0, height_mm], NOISE_PX)
        for height_mm in (0.0, 200.0)
    )
    assert any("behind one another along the line" in warning for warning in seen.calibrate().warnings)


@pytest.mark.parametrize("squares", [(7, 7), (8, 8)])
def test_a_board_of_equal_sides_is_calibrated_however_the_corners_are_ordered(squares):
    board = replace(BOARD, squares=squares, square_mm=40.0)
    seen = Seen(43, board)
    turns = board.hidden_turns

    def ordered(left, right):
        return tuple(board.turned(corners, int(seen.rng.choice(turns))) for corners in (left, right))

    seen.changed(ordered)
    found = seen.calibrate()
    seen.assert_true(found)
    true_camera = seen.cameras[0]
    assert found.rig.left.centre_mm == pytest.approx(true_camera.centre, abs=5.0)


def test_a_quarter_turn_puts_corners_where_the_turned_board_has_them():
    board = replace(BOARD, squares=(7, 7))
    corners = board.corners_mm[:, :2]
    assert board.turned(corners, 1)[0].tolist() == corners[5].tolist()
    assert board.turned(board.turned(corners, 1), 3) == pytest.approx(corners)


def test_pictures_of_other_moments_are_named_as_such_and_no_false_grids():
    seen = Seen(44)
    rights = [right for _, right in seen.poses]
    seen.poses = [(left, right) for (left, _), right in zip(seen.poses, rights[1:] + rights[:1], strict=True)]
    with pytest.raises(CalibrationError, match="give both pictures of a moment the same number") as caught:
        seen.calibrate()
    assert "grid" not in str(caught.value)


def test_without_pictures_of_the_low_board_no_height_is_needed():
    seen = Seen(45)
    seen.low = seen.high = NO_BOARD
    found = seen.calibrate(replace(BOARD, low_mm=None, high_mm=None))
    seen.assert_true(found)
    assert not found.rig.has_world


def test_a_height_that_is_not_told_is_measured_and_said():
    seen = Seen(46)
    found = seen.calibrate(replace(BOARD, high_mm=None))
    assert found.rig.high_mm == pytest.approx(200.0, abs=1.0)
    assert any(
        "high_mm is not given: 200" in warning or "high_mm is not given: 199" in warning for warning in found.warnings
    )
    told = seen.calibrate()
    assert found.rig.left.centre_mm == pytest.approx(told.rig.left.centre_mm, abs=2.0)


def test_pictures_of_the_low_board_need_its_height():
    with pytest.raises(CalibrationError, match="low_mm is not given"):
        Seen(47).calibrate(replace(BOARD, low_mm=None))


def test_registration_pictures_exchanged_are_refused_without_any_height_told():
    seen = Seen(48)
    seen.low, seen.high = seen.high, seen.low
    with pytest.raises(CalibrationError, match="high board appears 200 mm below"):
        seen.calibrate(replace(BOARD, high_mm=None))


def test_names_of_poses_come_back_in_the_report():
    names = [f"{1_700_000_000 + n}" for n in range(15)]
    found = Seen(49).calibrate(names=names)
    assert {picture.name for picture in found.pictures} >= {"left_1700000000", "right_1700000014"}


@pytest.mark.parametrize("seed", [3, 4])
def test_a_bar_is_measured_by_exchanged_cameras_as_by_others(seed):
    scene = draw("clean", seed)
    rig = perfect_rig(scene.rig, scene.response)
    straight = Gauge(rig).measure(scene.left, scene.right)
    exchanged = Gauge(replace(rig, left=rig.right, right=rig.left)).measure(scene.right, scene.left)
    assert exchanged.valid
    assert exchanged.diameter_mm == pytest.approx(straight.diameter_mm, abs=0.02)
    assert exchanged.diameter_virtual_board_mm == pytest.approx(straight.diameter_virtual_board_mm, abs=0.3)
    assert exchanged.reasons == straight.reasons
