"""Virtual boards at heights where no board lay, against the cameras' own projection."""

import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.true_rig import random_rig
from vision.alignment.virtual_boards import STAND_IN_MM, VirtualBoards

RIGS = [perfect_rig(random_rig(np.random.default_rng(seed))) for seed in range(10)]


def true_corners(camera, height_mm):
    return camera.undistort(camera.project(np.column_stack([STAND_IN_MM, np.full(len(STAND_IN_MM), height_mm)])))


@pytest.mark.parametrize("height_mm", [-50.0, 0.0, 60.0, 200.0, 320.0])
def test_a_projective_board_is_where_the_cameras_would_see_it_between_and_beyond_the_real_ones(height_mm):
    for rig in RIGS:
        corners = VirtualBoards.of_rig(rig).corners(height_mm)
        for seen, camera in zip(corners, (rig.left, rig.right), strict=True):
            assert np.abs(seen - true_corners(camera, height_mm)).max() < 1e-9


def test_a_linear_board_is_right_at_the_two_real_heights_only():
    for rig in RIGS:
        boards = VirtualBoards.of_rig(rig)
        for height_mm in (rig.low_mm, rig.high_mm):
            assert (
                np.abs(boards.corners(height_mm, projective=False)[0] - true_corners(rig.left, height_mm)).max() < 1e-9
            )
        between = boards.corners(100.0, projective=False)[0]
        assert np.abs(between - true_corners(rig.left, 100.0)).max() * rig.left.K[0, 0] > 0.2
