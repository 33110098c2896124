"""Route T with rigs that the product calibrated itself, from corners with detector noise and boards with errors.

Each seed draws its own rig, board, calibration and bar; the uncertainty must cover what all of them bring.
"""

import json

import numpy as np
import pytest
from mill_scenes import random_bar

from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.boards.boards import Board as TrueBoard
from appliance.simulation.boards.boards import board_document, observe
from appliance.simulation.true_rig import random_rig
from vision.calibration.checkerboard import Board
from vision.calibration.stereo import calibrate
from vision.sizing.tangent.gauge import TangentGauge

SEEDS = range(200, 212)


@pytest.fixture(scope="module")
def readings():
    return [one_reading(seed) for seed in SEEDS]


def one_reading(seed):
    rng = np.random.default_rng(seed)
    true_rig, bar = random_rig(rng), random_bar(rng)
    true_board = TrueBoard.with_errors(rng)
    seen = observe(true_rig, rng, true_board)
    board = Board.from_json(json.dumps(board_document(true_board, "srgb")))
    rig = calibrate(seen.calibration, seen.low, seen.high, board, true_rig.left.image_size).rig
    reading = TangentGauge(rig, 0.0).measure(*Scene(true_rig, seed).pair(bar, 0))
    return reading.diameter_mm - bar.diameter_mm, reading


def test_every_clean_bar_gets_a_value(readings):
    assert all(reading.valid for _, reading in readings)


def test_a_gauge_calibrated_from_pictures_errs_by_less_than_0_15_mm_rms(readings):
    error = np.array([error for error, _ in readings])
    assert np.sqrt(np.mean(error**2)) < 0.15


def test_the_stated_uncertainty_covers_the_error(readings):
    covered = [abs(error) <= reading.expanded_uncertainty_mm for error, reading in readings]
    assert np.mean(covered) >= 0.9


def test_the_calibration_s_part_is_there_and_grows_with_its_noise(readings):
    assert all(reading.u_calibration_mm > 0 for _, reading in readings)
    assert all(reading.u_board_mm > 0 for _, reading in readings)
