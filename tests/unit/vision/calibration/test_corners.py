"""Corner finding on boards drawn by supersampling a homography, whose corners are known exactly."""

import cv2
import numpy as np
import pytest

from vision.calibration import corners
from vision.calibration.checkerboard import Board
from vision.calibration.corners import find_corners

BOARD = Board((8, 5), 50.0, 0.0, 200.0, 0.01, 0.1, "gamma 2.2")
STRAIGHT = np.array([[1.1, 0.1, 320.0], [0.15, -1.0, 240.0], [0.0, 0.0, 1.0]])
SLANTED = np.array([[0.75, 0.12, 320.0], [-0.2, -0.45, 240.0], [-2e-4, 4e-4, 1.0]])
HALF_TURN = np.diag([-1.0, -1.0, 1.0])


def draw(to_picture, board=BOARD, noise=1.0, supersampling=5):
    """Picture of a board on grey ground: dark square at its -x +y corner, blurred in light, gamma-coded."""
    rows, columns = 480, 640
    fine = (np.arange(supersampling) + 0.5) / supersampling - 0.5
    x, y = (np.arange(count)[:, None] + fine for count in (columns, rows))
    grid = np.stack(np.meshgrid(x.ravel(), y.ravel()), axis=-1)
    on_board = cv2.perspectiveTransform(grid, np.linalg.inv(to_picture))
    across, down = board.squares
    column = np.floor(on_board[..., 0] / board.square_mm + across / 2.0)
    row = np.floor(down / 2.0 - on_board[..., 1] / board.square_mm)
    light = np.where((column + row) % 2 == 0, 0.05, 0.8)
    margin = (column < 0) | (column >= across) | (row < 0) | (row >= down)
    sheet = (column >= -1) & (column <= across) & (row >= -1) & (row <= down)
    light = np.where(margin, np.where(sheet, 0.8, 0.2), light)
    light = light.reshape(rows, supersampling, columns, supersampling).mean(axis=(1, 3))
    light = cv2.GaussianBlur(light, (0, 0), 0.8)
    picture = 255.0 * light ** (1.0 / 2.2) + np.random.default_rng(1).normal(0.0, noise, light.shape)
    return np.clip(np.round(picture), 0, 255).astype(np.uint8)


def true_corners(to_picture, board=BOARD):
    return cv2.perspectiveTransform(board.corners_mm[:, None, :2], to_picture).reshape(-1, 2)


@pytest.mark.parametrize("to_picture", [STRAIGHT, SLANTED], ids=["straight", "slanted"])
@pytest.mark.parametrize("turn", [np.eye(3), HALF_TURN], ids=["upright", "half turned"])
def test_corners_are_found_in_their_order_to_three_hundredths_of_a_pixel(to_picture, turn):
    found = find_corners(draw(to_picture @ turn), BOARD)
    errors = found.corners_px - true_corners(to_picture @ turn)
    assert np.sqrt(np.mean(errors**2)) < 0.03


def test_a_mirrored_picture_gives_the_mirrored_corners():
    """Rows and columns are treated alike, under noise as well."""
    picture, rough = draw(SLANTED, noise=6.0).astype(np.float32), np.round(true_corners(SLANTED))
    mirrored = corners._refined(np.ascontiguousarray(picture.T), rough[:, ::-1], BOARD)
    assert mirrored[:, ::-1] == pytest.approx(corners._refined(picture, rough, BOARD), abs=2e-3)


def test_colour_pictures_give_the_same_corners():
    grey = draw(STRAIGHT)
    colour = find_corners(np.repeat(grey[:, :, None], 3, axis=2), BOARD).corners_px
    assert colour == pytest.approx(find_corners(grey, BOARD).corners_px, abs=1e-3)


@pytest.mark.parametrize("turn", [np.eye(3), HALF_TURN], ids=["upright", "half turned"])
def test_without_colours_to_tell_x_points_right_in_the_picture(turn):
    board = Board((8, 6), 40.0, 0.0, 200.0, 0.01, 0.1, "gamma 2.2")
    found = find_corners(draw(STRAIGHT @ turn, board), board).corners_px
    assert found == pytest.approx(true_corners(STRAIGHT, board), abs=0.1)


@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((480, 640), np.uint8),
        np.full((480, 640, 3), 255, np.uint8),
        np.random.default_rng(2).integers(0, 256, (480, 640), dtype=np.uint8),
        draw(STRAIGHT, Board((6, 4), 50.0, 0.0, 200.0, 0.01, 0.1, "gamma 2.2")),
    ],
    ids=["black", "white", "noise", "a smaller board"],
)
def test_a_picture_without_this_board_gives_no_corners_but_a_reason(picture):
    found = find_corners(picture, BOARD)
    assert found.corners_px is None
    assert "found" in found.reason


def test_a_false_grid_of_the_detectors_is_refused_by_its_irregularity(monkeypatch):
    grid = true_corners(STRAIGHT).reshape(4, 7, 2)
    grid[1::2] += [28.0, 0.0]
    monkeypatch.setattr(corners, "_refined", lambda *given: given[1])
    propose(monkeypatch, grid)
    assert "not regular" in find_corners(draw(STRAIGHT), BOARD).reason


def test_a_false_grid_on_plain_ground_is_refused_by_its_colours(monkeypatch):
    propose(monkeypatch, true_corners(STRAIGHT))
    picture = np.random.default_rng(3).integers(120, 125, (480, 640), dtype=np.uint8)
    assert find_corners(picture, BOARD).corners_px is None


def propose(monkeypatch, grid):
    answer = True, grid.reshape(-1, 1, 2).astype(np.float32)
    monkeypatch.setattr(cv2, "findChessboardCorners", lambda *_, **__: answer)
    monkeypatch.setattr(cv2, "findChessboardCornersSB", lambda *_, **__: answer)


def test_a_picture_that_is_none_is_a_wrong_call():
    with pytest.raises(ValueError, match="image"):
        find_corners(np.zeros((480, 640), np.float64), BOARD)
