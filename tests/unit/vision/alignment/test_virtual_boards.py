"""Virtual boards at heights where no board lay, against the cameras' own projection."""

import cv2
import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.true_rig import random_rig
from vision.alignment.view_alignment import Alignment
from vision.alignment.virtual_boards import STAND_IN_MM, VirtualBoards
from vision.geometry.homography import transformed
from vision.geometry.turned_region import whole_picture

RIGS = [perfect_rig(random_rig(np.random.default_rng(seed))) for seed in range(10)]


def true_corners(camera, height_mm):
    return camera.undistort(camera.project(np.column_stack([STAND_IN_MM, np.full(len(STAND_IN_MM), height_mm)])))


@pytest.mark.parametrize("height_mm", [-50.0, 0.0, 60.0, 200.0, 320.0])
def test_a_projective_board_is_where_the_cameras_would_see_it_between_and_beyond_the_real_ones(height_mm):
    for rig in RIGS:
        corners = VirtualBoards.of_rig(rig).corners(height_mm)
        for seen, camera in zip(corners, (rig.left, rig.right), strict=True):
            assert np.abs(seen - true_corners(camera, height_mm)).max() < 1e-9


@pytest.mark.parametrize("slope", [(0.0, 0.06), (0.05, 0.0), (-0.04, 0.08)])
def test_a_turned_board_is_where_the_cameras_would_see_it(slope):
    for rig in RIGS[:4]:
        heights = 120.0 + STAND_IN_MM @ np.array(slope)
        corners = VirtualBoards.of_rig(rig).corners(120.0, slope=slope)
        for seen, camera in zip(corners, (rig.left, rig.right), strict=True):
            true = camera.undistort(camera.project(np.column_stack([STAND_IN_MM, heights])))
            assert np.abs(seen - true).max() < 1e-9


def test_on_a_line_that_rises_a_turned_board_aligns_the_views_and_a_level_one_misses_by_pixels():
    rig, slope, height_mm = RIGS[0], (0.0, 0.08), 120.0
    blank = [np.zeros(camera.image_size[::-1], np.uint8) for camera in (rig.left, rig.right)]
    left, right = map(whole_picture, (rig.left, rig.right), blank)
    y_mm = np.linspace(-180, 180, 9)
    points = np.column_stack([np.full(9, 20.0), y_mm, height_mm + slope[1] * y_mm])
    seen = [
        camera.undistort(camera.project(points)) @ camera.K[:2, :2].T + camera.K[:2, 2]
        for camera in (rig.left, rig.right)
    ]

    def apart_px(slope):
        alignment = Alignment(rig, VirtualBoards.of_rig(rig), left, right, projective=True, slope=slope)
        moved = transformed(alignment.right_to_left(height_mm), seen[1])
        return np.linalg.norm(moved - seen[0], axis=1).max()

    assert apart_px(slope) < 0.01
    assert apart_px((0.0, 0.0)) > 3


def test_a_linear_board_is_right_at_the_two_real_heights_only():
    for rig in RIGS:
        boards = VirtualBoards.of_rig(rig)
        for height_mm in (rig.low_mm, rig.high_mm):
            assert (
                np.abs(boards.corners(height_mm, projective=False)[0] - true_corners(rig.left, height_mm)).max() < 1e-9
            )
        between = boards.corners(100.0, projective=False)[0]
        assert np.abs(between - true_corners(rig.left, 100.0)).max() * rig.left.K[0, 0] > 0.2


@pytest.mark.parametrize("tilt_deg", [-3.0, 2.0, 5.0])
def test_boards_of_a_line_that_rises_are_parallel_to_the_line(tilt_deg):
    for rig in RIGS[:4]:
        turned = rig.along_line(tilt_deg)
        corners = VirtualBoards.of_rig(turned).corners(120.0)
        for seen, camera in zip(corners, (turned.left, turned.right), strict=True):
            rays = np.column_stack([seen, np.ones(len(seen))]) @ camera.R
            places = camera.centre_mm + rays * ((120.0 - camera.centre_mm[2]) / rays[:, 2])[:, None]
            assert places[:, 0] == pytest.approx(STAND_IN_MM[:, 0], abs=1e-6)  # each corner right under its own place


def test_two_boards_alone_give_every_plane_of_their_pencil():
    """H(h, s) = H_low + v [s_x, s_y, h - h_low], from the homographies of the low and of the high board."""
    rig, slope, height_mm = RIGS[3], np.array([0.03, -0.06]), 150.0
    on_board = np.column_stack([STAND_IN_MM, np.ones(len(STAND_IN_MM))])

    def homography(height):
        found = cv2.findHomography(STAND_IN_MM, true_corners(rig.left, height), 0)[0]
        return found / np.linalg.norm(found[:, 0])  # the direction along x has one length on both

    low, high = homography(rig.low_mm), homography(rig.high_mm)
    rise = (high - low)[:, 2] / (rig.high_mm - rig.low_mm)
    plane = low + np.outer(rise, [*slope, height_mm - rig.low_mm])
    image = on_board @ plane.T
    expected = VirtualBoards.of_rig(rig).corners(height_mm, slope=(slope[0], slope[1]))[0]
    assert image[:, :2] / image[:, 2:] == pytest.approx(expected, abs=1e-6)
