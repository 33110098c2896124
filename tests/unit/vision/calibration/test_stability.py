"""Which board a calibration hangs on, and the uncertainty that follows from leaving boards out."""

import json

import numpy as np
import pytest
from calibrated_rigs import board_of

from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.boards import board_document, observe
from vision.calibration.checkerboard import Board
from vision.calibration.stability import Quantity, leave_one_out
from vision.calibration.stereo import calibrate

SEED = 4


@pytest.fixture(scope="module")
def drawn():
    """Corners of a simulated rig, and its board as it is told."""
    setup, (rng, true_board) = set_up("clean", SEED), board_of(SEED)
    board = Board.from_json(json.dumps(board_document(true_board, setup.sensor.response)))
    return observe(setup.rig, rng, true_board), board, setup.rig.left.image_size


def test_u_from_leaving_out_is_that_of_a_mean():
    """For the mean of n numbers the jackknife is exactly s / sqrt n."""
    numbers = np.random.default_rng(1).normal(20.0, 3.0, 12)
    without = (numbers.sum() - numbers) / 11
    mean = Quantity("mean", "mm", numbers.mean(), 1.0, without - numbers.mean())
    assert mean.jackknife_u == pytest.approx(numbers.std(ddof=1) / np.sqrt(12))
    assert mean.largest == np.argmax(np.abs(numbers - numbers.mean()))


def test_the_change_stated_is_that_of_a_calibration_that_never_saw_the_pose(drawn):
    seen, board, size = drawn
    poses = list(seen.calibration)[:8]
    whole = calibrate(poses, seen.low, seen.high, board, size)
    stability = leave_one_out(whole, board)
    never_seen = calibrate([*poses[:3], *poses[4:]], seen.low, seen.high, board, size)
    left, _, baseline, length = stability.quantities
    assert left.changes[3] == pytest.approx(never_seen.rig.left.K[0, 0] - whole.rig.left.K[0, 0], abs=1e-3)
    assert baseline.changes[3] == pytest.approx(never_seen.baseline_mm - whole.baseline_mm, abs=1e-4)
    assert length.value == pytest.approx(100.0, abs=1e-6)
    assert stability.poses == tuple(f"{number:02d}" for number in range(8))


def test_with_the_least_number_of_poses_none_can_be_left_out_and_nothing_is_claimed(drawn):
    seen, board, size = drawn
    six = leave_one_out(calibrate(list(seen.calibration)[:6], (None, None), (None, None), board, size), board)
    assert set(six.refusals) == set(six.poses)
    assert "6 are needed" in six.refusals["00"]
    assert all(np.isnan(one.jackknife_u) and one.largest is None for one in six.quantities)
