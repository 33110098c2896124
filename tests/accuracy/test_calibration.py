"""Calibration from corners with known truth: what it states about itself must be what scatters."""

from dataclasses import replace

import numpy as np
import pytest
from board_truth import BOARD, IMAGE_SIZE, flat_board, observe, random_cameras, random_poses

from vision.calibration.acceptance import CalibrationError
from vision.calibration.checkerboard import Assumption, Board
from vision.calibration.rig import Rig
from vision.calibration.stereo import Calibration, calibrate

N_RIGS = 48


class Setup:
    """Everything one calibration is made from."""

    def __init__(self, seed, noise_px=0.05, k3=0.0, high_error_mm=0.0):
        self.rng = np.random.default_rng(seed)
        self.noise_px = noise_px
        self.cameras = random_cameras(self.rng, k3)
        self.poses = [self.see(points) for points in random_poses(self.rng, self.cameras)]
        self.low = self.see(flat_board(0.0))
        x, y, yaw = self.rng.normal(0.0, [20.0, 20.0, 0.05])
        self.high = self.see(flat_board(200.0 + high_error_mm, x, y, yaw))

    def see(self, points):
        return observe(self.rng, self.cameras, points, self.noise_px)

    def calibrate(self, board=BOARD) -> Calibration:
        return calibrate(self.poses, self.low, self.high, board, IMAGE_SIZE)

    @property
    def baseline_mm(self):
        return float(np.linalg.norm(self.cameras[0].centre - self.cameras[1].centre))


def triangulate(rig: Rig, left_px, right_px):
    """Points nearest to both rays."""
    points = []
    for left, right in zip(rig.left.rays(left_px), rig.right.rays(right_px), strict=True):
        to_left, to_right = (np.eye(3) - np.outer(ray, ray) for ray in (left, right))
        weighed = to_left @ rig.left.centre_mm + to_right @ rig.right.centre_mm
        points.append(np.linalg.solve(to_left + to_right, weighed))
    return np.array(points)


def length_error(setup: Setup, rig: Rig, ends):
    """Error of the triangulated distance between two points, over its stated standard uncertainty."""
    ends = np.array(ends)
    left_px, right_px = (camera.see(ends) for camera in setup.cameras)

    def length(rig: Rig) -> float:
        one, other = triangulate(rig, left_px, right_px)
        return float(np.linalg.norm(one - other))

    truth = np.linalg.norm(ends[0] - ends[1])
    return (length(rig) - truth) / rig.standard_uncertainty(length)


@pytest.fixture(scope="module")
def errors():
    """Errors over stated standard uncertainties, one row per rig."""
    rows = []
    for seed in range(N_RIGS):
        rng = np.random.default_rng([7, seed])
        setup = Setup(seed, rng.uniform(0.03, 0.1), high_error_mm=rng.normal(0.0, np.sqrt(2.0) * BOARD.height_u_mm))
        found = setup.calibrate()
        u = np.sqrt(np.diag(found.rig.covariance))
        rows.append(
            {
                "baseline": (found.baseline_mm - setup.baseline_mm) / found.baseline_u_mm,
                "left focal length": (found.rig.left.K[0, 0] - setup.cameras[0].K[0, 0]) / u[0],
                "right principal point": (found.rig.right.K[0, 2] - setup.cameras[1].K[0, 2]) / u[17],
                "length across": length_error(setup, found.rig, [[-125.0, 0.0, 125.0], [125.0, 0.0, 125.0]]),
                "length upwards": length_error(setup, found.rig, [[0.0, 0.0, 0.0], [0.0, 0.0, 250.0]]),
                "noise": found.noise_px / setup.noise_px,
            }
        )
    return {key: np.array([row[key] for row in rows]) for key in rows[0]}


QUANTITIES = ["baseline", "left focal length", "right principal point", "length across", "length upwards"]


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_stated_uncertainty_is_the_scatter_over_rigs(errors, quantity):
    values = errors[quantity]
    assert np.sqrt(np.mean(values**2)) == pytest.approx(1.0, abs=0.2)
    assert abs(values.mean()) < 3.3 / np.sqrt(N_RIGS)


def test_twice_the_stated_uncertainty_covers_95_percent(errors):
    covered = np.mean([np.abs(errors[quantity]) < 2.0 for quantity in QUANTITIES])
    assert 0.93 <= covered <= 0.98


def test_corner_noise_is_estimated_from_the_residuals(errors):
    assert errors["noise"].mean() == pytest.approx(1.0, abs=0.01)
    assert errors["noise"].std() < 0.03


def test_corners_without_noise_give_the_rig_itself():
    setup = Setup(3, noise_px=0.0)
    found = setup.calibrate()
    for camera, truth in zip((found.rig.left, found.rig.right), setup.cameras, strict=True):
        assert pytest.approx(truth.K, abs=1e-4) == camera.K
        assert camera.dist == pytest.approx(truth.dist, abs=1e-6)
        assert pytest.approx(truth.R, abs=1e-7) == camera.R
        assert camera.centre_mm == pytest.approx(truth.centre, abs=1e-3)


def test_the_same_pictures_give_the_same_rig_to_the_last_bit():
    setup = Setup(5)
    first, *others = (setup.calibrate().rig for _ in range(3))
    for other in others:
        assert np.array_equal(other.covariance, first.covariance)
        for camera, before in ((other.left, first.left), (other.right, first.right)):
            for name in ("K", "dist", "R", "t"):
                assert np.array_equal(getattr(camera, name), getattr(before, name)), name


def test_k3_is_adjusted_only_where_the_lens_has_it():
    without, with_k3 = Setup(4).calibrate().rig, Setup(4, k3=2.0).calibrate().rig
    assert without.left.dist[4] == 0.0
    assert without.covariance[8, 8] == 0.0
    assert with_k3.left.dist[4] == pytest.approx(2.0, abs=4.0 * np.sqrt(with_k3.covariance[8, 8]))
    assert with_k3.covariance[8, 8] > 0.0


def test_a_false_grid_is_left_out_by_name_and_harms_nothing():
    setup = Setup(6)
    clean = setup.calibrate()
    left, right = setup.poses[4]
    shifted = left.reshape(4, 7, 2).copy()
    shifted[:, :-1] = shifted[:, 1:]
    shifted[:, -1] += shifted[:, -1] - shifted[:, -2] + 6.0
    setup.poses[4] = shifted.reshape(-1, 2), right
    found = setup.calibrate()
    assert "left_04" in {drop.name for drop in found.dropped}
    assert {drop.name for drop in found.dropped} <= {"left_04", "right_04"}
    assert found.baseline_mm == pytest.approx(clean.baseline_mm, abs=2.0 * clean.baseline_u_mm)


def test_one_swapped_pair_is_left_out_with_both_pictures():
    setup = Setup(8)
    setup.poses[2] = setup.poses[2][::-1]
    found = setup.calibrate()
    assert {drop.name for drop in found.dropped} == {"left_02", "right_02"}
    assert abs(found.baseline_mm - setup.baseline_mm) < 4.0 * found.baseline_u_mm


def test_a_board_that_moved_between_the_pictures_is_left_out():
    setup = Setup(9)
    left, right = setup.poses[0]
    setup.poses[0] = left + 3.0, right
    assert {drop.name for drop in setup.calibrate().dropped} == {"left_00", "right_00"}


def test_low_and_high_swapped_is_refused():
    setup = Setup(11)
    setup.low, setup.high = setup.high, setup.low
    with pytest.raises(CalibrationError, match="the high board appears at -"):
        setup.calibrate()


@pytest.mark.parametrize("factor", [0.8, 1.02])
def test_a_wrong_square_size_is_refused_because_the_high_board_is_not_where_it_should_be(factor):
    with pytest.raises(CalibrationError, match="check square_mm"):
        Setup(12).calibrate(replace(BOARD, square_mm=50.0 * factor))


def test_too_few_boards_are_refused_and_the_unusable_pictures_named():
    setup = Setup(13)
    setup.poses = [(left, None) for left, _ in setup.poses[:4]] + setup.poses[4:7]
    with pytest.raises(CalibrationError, match="5 boards are usable in both pictures where 6 are needed"):
        setup.calibrate()


def test_boards_that_all_lie_flat_are_refused():
    setup = Setup(14)
    setup.poses = [setup.see(flat_board(10.0 * n, 20.0 * n - 100.0, 15.0 * n - 80.0, 0.3 * n)) for n in range(10)]
    with pytest.raises(CalibrationError, match="tilt them more"):
        setup.calibrate()


def test_noisy_corners_are_refused_with_their_residual():
    with pytest.raises(CalibrationError, match="residual"):
        Setup(15, noise_px=1.0).calibrate()


def test_pictures_of_one_camera_alone_improve_that_camera():
    setup = Setup(16)
    without = setup.calibrate()
    extra = [setup.see(points) for points in random_poses(setup.rng, setup.cameras, 10)]
    setup.poses = setup.poses + [(left, None) for left, _ in extra]
    with_extra = setup.calibrate()
    known, better = (np.sqrt(found.rig.covariance[5, 5]) / found.noise_px for found in (without, with_extra))
    assert better < 0.95 * known  # k2, which lives in the corners of the picture


def test_without_registration_pictures_the_world_frame_is_missing():
    setup = Setup(17)
    setup.low = setup.high = (None, None)
    assumed = (Assumption("heights are about right", of_world=True), Assumption("height_u_mm matters to a print too"))
    found = setup.calibrate(replace(BOARD, assumptions=assumed))
    assert not found.rig.has_world
    assert set(found.warnings) & {one.text for one in assumed} == {"height_u_mm matters to a print too"}
    assert any("world frame is missing" in warning for warning in found.warnings)
    assert np.array_equal(found.rig.left.R, np.eye(3))
    assert not found.rig.covariance[9:15].any()
    assert abs(found.baseline_mm - setup.baseline_mm) < 4.0 * found.baseline_u_mm


def test_the_low_board_seen_by_one_camera_still_defines_the_world():
    setup = Setup(18)
    setup.low = (None, setup.low[1])
    found = setup.calibrate()
    assert found.rig.has_world
    assert found.rig.boards["left_low"].shape == (0, 2)
    assert found.rig.left.centre_mm == pytest.approx(setup.cameras[0].centre, abs=5.0)


def test_x_points_right_in_the_left_picture_whichever_way_the_board_lies():
    setup = Setup(19)
    straight = setup.calibrate().rig
    setup.low = tuple(corners[::-1] for corners in setup.low)
    setup.high = tuple(corners[::-1] for corners in setup.high)
    turned = setup.calibrate().rig
    assert pytest.approx(straight.left.R, abs=1e-7) == turned.left.R
    assert turned.boards["left_low"] == pytest.approx(straight.boards["left_low"])


def test_half_turns_of_a_board_that_does_not_show_them_are_resolved_between_the_pictures():
    setup = Setup(20)
    board = Board((8, 6), *(getattr(BOARD, name) for name in list(BOARD.__dataclass_fields__)[1:]))

    def see(turn, centre):
        return setup.see(board.corners_mm @ turn.T + centre)

    corners = [points.reshape(4, 7, 3) for points in random_poses(setup.rng, setup.cameras, 14)]
    setup.poses = []
    for grid in corners:
        x, y = (axis / np.linalg.norm(axis) for axis in (grid[0, -1] - grid[0, 0], grid[0, 0] - grid[-1, 0]))
        left, right = see(np.column_stack([x, y, np.cross(x, y)]), grid.mean(axis=(0, 1)))
        setup.poses.append((left, right[::-1] if setup.rng.random() < 0.4 else right))
    setup.low, setup.high = (see(np.eye(3), [0.0, 0.0, height]) for height in (0.0, 200.0))
    found = setup.calibrate(board)
    assert not found.dropped
    assert abs(found.baseline_mm - setup.baseline_mm) < 4.0 * found.baseline_u_mm


def test_corners_of_another_count_are_a_wrong_call():
    setup = Setup(21)
    setup.poses[3] = setup.poses[3][0][:-1], setup.poses[3][1]
    with pytest.raises(ValueError, match="left_03: 28 finite corners"):
        setup.calibrate()
