"""Live judgement of board pictures: blur, light, novelty and coverage of drawn boards."""

import cv2
import numpy as np
import pytest

from vision.calibration.board_judgement import EDGE_WIDTH_MOST_PX, is_new, judge_board, mean_way_px, seen_so_far
from vision.calibration.checkerboard import Board
from vision.sent_picture import SentPicture

BOARD = Board((8, 5), 50.0, 0.0, 100.0, 0.05, 0.1)
SIZE = (800, 600)
FOCAL_PX = 900.0


def corners_at(x_mm=0.0, y_mm=0.0, z_mm=900.0, tilt_deg=0.0):
    """Corners of a board before a camera of known focal length, pixels."""
    turn = np.array([0.0, np.radians(tilt_deg), 0.0])
    matrix = np.array([[FOCAL_PX, 0, 399.5], [0, FOCAL_PX, 299.5], [0, 0, 1.0]])
    points = BOARD.corners_mm * [1, -1, 1]
    return cv2.projectPoints(points, turn, np.array([x_mm, y_mm, z_mm]), matrix, np.zeros(5))[0].reshape(-1, 2)


def picture(black=30, white=200, blur_px=0.7, motion_px=0):
    """A board looked at straight, drawn finely and made smaller, then blurred by a known amount."""
    fine = np.full((4 * SIZE[1], 4 * SIZE[0]), white, np.uint8)
    for row in range(5):
        for column in range(row % 2, 8, 2):
            left, top = 4 * (200 + 50 * column), 4 * (175 + 50 * row)
            fine[top : top + 200, left : left + 200] = black
    image = cv2.resize(fine, SIZE, interpolation=cv2.INTER_AREA)
    image = cv2.GaussianBlur(image, (0, 0), blur_px)
    if motion_px:
        image = cv2.blur(image, (motion_px, 1))
    noise = np.random.default_rng(1).normal(0, 1.5, image.shape)
    return SentPicture.of(np.clip(image + noise, 0, 255).astype(np.uint8))


@pytest.mark.parametrize("blur_px", [0.7, 1.0, 1.5])
def test_a_sharp_board_is_good_and_its_edges_are_as_wide_as_the_blur(blur_px):
    seen = judge_board(picture(blur_px=blur_px), BOARD)
    assert not seen.trouble
    # contrast over slope of a Gaussian edge, its pixels square and its slope taken over one pixel
    wide_px = np.sqrt(2 * np.pi * (blur_px**2 + 2 / 12))
    assert seen.edge_width_px == pytest.approx(wide_px, rel=0.12)


@pytest.mark.parametrize(
    ("drawn", "said"),
    [
        ({"blur_px": 2.2}, "blurred, edges"),
        ({"motion_px": 7}, "blurred, edges"),
        ({"white": 255}, "overexposed, "),
        ({"black": 30, "white": 55}, "of full light only"),
    ],
)
def test_a_board_that_is_no_good_is_told_why(drawn, said):
    seen = judge_board(picture(**drawn), BOARD)
    assert seen.corners_px is not None
    assert said in seen.trouble


def test_motion_in_one_direction_counts_in_full():
    assert judge_board(picture(motion_px=7), BOARD).edge_width_px > EDGE_WIDTH_MOST_PX
    assert judge_board(picture(), BOARD).edge_width_px < EDGE_WIDTH_MOST_PX


def test_a_picture_without_a_board_says_so():
    seen = judge_board(SentPicture.of(np.full((600, 800), 90, np.uint8)), BOARD)
    assert seen.corners_px is None
    assert "no board of 7 x 4 inner corners" in seen.trouble


def test_a_pose_is_new_when_it_moved_by_half_a_square():
    first = corners_at()
    assert mean_way_px(corners_at(x_mm=10.0), first) == pytest.approx(10.0, rel=1e-6)
    assert not is_new(corners_at(x_mm=20.0), [first])
    assert is_new(corners_at(x_mm=30.0), [first])
    assert not is_new(corners_at(x_mm=30.0), [first, corners_at(x_mm=32.0)])


def test_coverage_tilt_and_missing_corners_are_those_of_the_geometry():
    one = seen_so_far([corners_at()], SIZE, BOARD)
    assert one.covered_share == pytest.approx(300 * 150 / (800 * 600), rel=1e-6)
    assert one.tilt_deg == pytest.approx(0, abs=0.1)
    assert one.missing == ("upper left", "upper right", "lower left", "lower right")
    tilted = [corners_at(tilt_deg=angle) for angle in (-20, 0, 15)]
    spread = seen_so_far(tilted, SIZE, BOARD)
    assert spread.tilt_deg == pytest.approx(35, abs=3)
    corner = seen_so_far([corners_at(x_mm=-240, y_mm=-220)], SIZE, BOARD)
    assert corner.missing == ("upper right", "lower left", "lower right")
    assert seen_so_far([], SIZE, BOARD).covered_share == 0.0
