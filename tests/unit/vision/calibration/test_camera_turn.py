"""The turn of a camera from marks that were projected before and after it."""

import cv2
import numpy as np
import pytest

from vision.calibration.camera_turn import NO_TURN, camera_turn
from vision.calibration.still_marks import MarksMotion
from vision.geometry.camera import Camera


@pytest.fixture
def camera():
    K = np.array([[2000.0, 0, 400], [0, 2001.0, 300], [0, 0, 1]])
    turn = cv2.Rodrigues(np.array([2.2, 0.1, 0.2]))[0]
    return Camera(K, np.array([-0.1, 0.05, 0.001, 0.0, 0.0]), turn, -turn @ [700.0, -1500.0, 2300.0], (800, 600))


def moved(camera, omega, noise_px, seed=0):
    """Marks somewhere behind the line before and after a turn, by OpenCV's projection."""
    rng = np.random.default_rng(seed)
    place = rng.uniform((20, 20), (780, 580), (15, 2))
    far_mm = camera.centre_mm + 4000 * camera.rays(place)
    turn = cv2.Rodrigues(np.array(omega))[0]
    rvec = cv2.Rodrigues(turn @ camera.R)[0]
    after = cv2.projectPoints(far_mm, rvec, turn @ camera.t, camera.K, camera.dist)[0][:, 0]
    shift = after - place + rng.normal(0, noise_px, place.shape)
    moved_px = float(np.sqrt(np.mean(np.sum(shift**2, axis=1))))
    return MarksMotion(moved_px, place, np.tile(np.eye(2), (len(place), 1, 1)), shift)


@pytest.mark.parametrize("omega", [(8e-4, 0, 0), (0, -8e-4, 0), (0, 0, 2e-3), (3e-4, -5e-4, 1e-3)])
def test_the_turn_is_found_again(camera, omega):
    turn = camera_turn(camera, moved(camera, omega, 0.0))
    np.testing.assert_allclose(turn.omega, omega, atol=2e-6)
    np.testing.assert_allclose(camera.turned(turn.omega).centre_mm, camera.centre_mm, atol=1e-6)


def test_its_covariance_is_that_of_the_errors(camera):
    turns = [camera_turn(camera, moved(camera, (4e-4, 4e-4, 0), 0.05, seed)) for seed in range(200)]
    error = np.array([turn.omega for turn in turns]) - [4e-4, 4e-4, 0]
    stated = np.sqrt(np.mean([np.diag(turn.covariance) for turn in turns], axis=0))
    np.testing.assert_allclose(error.std(axis=0), stated, rtol=0.25)


def test_edges_that_say_nothing_of_a_shift_along_themselves_do_not_pull_the_turn(camera):
    motion = moved(camera, (4e-4, -4e-4, 1e-3), 0.0)
    along, across = np.array([0.8, 0.6]), np.array([-0.6, 0.8])
    edge = np.outer(across, across) + 0.05 * np.outer(along, along)
    wrong = motion.slope + np.random.default_rng(1).normal(0, 0.4, (15, 1)) * along  # where the edges' places are found
    found = camera_turn(camera, MarksMotion(motion.moved_px, motion.place_px, np.tile(edge, (15, 1, 1)), wrong @ edge))
    np.testing.assert_allclose(found.omega[:2], (4e-4, -4e-4), atol=1e-4)


@pytest.mark.parametrize("moved_px", [0.0, np.nan])
def test_marks_that_did_not_move_or_are_not_seen_turn_nothing(camera, moved_px):
    still = MarksMotion(moved_px, np.zeros((8, 2)), np.tile(np.eye(2), (8, 1, 1)), np.full((8, 2), 0.02))
    assert camera_turn(camera, still) is NO_TURN
