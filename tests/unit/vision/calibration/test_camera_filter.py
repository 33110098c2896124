"""A camera's filter on pictures of a board that are drawn here: squares, blur, response, noise and the filter."""

import cv2
import numpy as np
import pytest

from appliance.simulation.coding import filtered, jpeg
from vision.calibration.board_edges import board_edges
from vision.calibration.camera_filter import noise_correlation
from vision.calibration.checkerboard import Board
from vision.calibration.response import chosen_response, measure_response
from vision.geometry.camera import Camera
from vision.sent_picture import Coding, SentPicture, sent_picture

SQUARE_PX, BLUR_PX, NOISE, PICTURES, FINE = 36, 0.8, 0.004, 10, 4
BLACK, WHITE = 0.03, 0.42
SIZE = 400, 280
BOARD = Board((8, 5), 50.0, 0.0, 200.0, 0.01, 0.1)


@pytest.fixture(scope="module")
def camera():
    """One pixel a 36th of a square, seen straight on."""
    K = np.array([[1000.0, 0.0, SIZE[0] / 2], [0.0, 1000.0, SIZE[1] / 2], [0.0, 0.0, 1.0]])
    away_mm = 1000.0 * BOARD.square_mm / SQUARE_PX
    return Camera(K, np.zeros(5), np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, away_mm]), SIZE)


def boards(camera, strength, sent):
    rng = np.random.default_rng(7)
    edges = []
    for _ in range(PICTURES):
        off = rng.uniform(-0.5, 0.5, 2)
        corners = camera.project(BOARD.corners_mm) + off
        picture = sent(filtered(drawn(off, rng), strength))
        edges.append((board_edges(picture, camera, corners, BOARD), picture.coding))
    return edges


def drawn(off, rng):
    """Drawn finely, blurred, collected in pixels and coded with the power 1 / 2.2."""
    x, y = ((np.arange(FINE * size) + 0.5) / FINE - 0.5 - size / 2 - by for size, by in zip(SIZE, off, strict=True))
    white = (np.floor(x / SQUARE_PX)[None] + np.floor(y / SQUARE_PX + 0.5)[:, None]) % 2
    light = cv2.GaussianBlur(BLACK + (WHITE - BLACK) * white, (0, 0), FINE * BLUR_PX)
    light = cv2.resize(light, SIZE, interpolation=cv2.INTER_AREA)
    noisy = np.clip(light + NOISE * rng.standard_normal(light.shape), 0, 1)
    return np.rint(255 * noisy ** (1 / 2.2)).astype(np.uint8)


def lossless(picture):
    return SentPicture.of(picture)


def compressed(picture):
    decoded = cv2.imdecode(np.frombuffer(jpeg(picture, 85), np.uint8), cv2.IMREAD_GRAYSCALE)
    return sent_picture(np.asarray(decoded, np.uint8), Coding("grey", compression="jpeg", quality=85))


@pytest.mark.parametrize(("strength", "kind"), [(0.0, None), (-0.3, "smooths"), (0.5, "sharpens")])
def test_a_filter_is_named_and_its_response_measured(camera, strength, kind):
    measured = measure_response(boards(camera, strength, lossless))
    if kind is None:
        assert measured.filter == ""
    else:
        assert measured.filter.startswith(f"the camera {kind} its pictures")
    assert chosen_response(None, measured).filter == measured.filter


@pytest.mark.parametrize(("strength", "sharpens"), [(0.0, False), (0.6, True)])
def test_sharpening_shows_through_compression(camera, strength, sharpens):
    measured = measure_response(boards(camera, strength, compressed))
    assert ("sharpens" in measured.filter) == sharpens


def test_noise_of_neighbours_is_correlated_as_the_filter_makes_it(camera):
    strength = -0.3
    kernel = cv2.getGaussianKernel(9, 1.0) @ cv2.getGaussianKernel(9, 1.0).T
    kernel *= -strength
    kernel[4, 4] += 1 + strength
    r1, r2, r4 = (np.sum(kernel[:, k:] * kernel[:, :-k]) / np.sum(kernel**2) for k in (1, 2, 4))
    expected = 1 - (6 - 8 * r1 + 2 * r2) / (6 - 8 * r2 + 2 * r4)
    assert noise_correlation(boards(camera, strength, lossless)) == pytest.approx(expected, abs=0.015)
    assert noise_correlation(boards(camera, 0.0, lossless)) == pytest.approx(0.0, abs=0.015)
    assert noise_correlation(boards(camera, strength, compressed)) == 0.0
