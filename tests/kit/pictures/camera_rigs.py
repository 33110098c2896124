"""Cameras whose response is of random shape and told to nobody: it is measured from the boards as they are sent."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from calibrated_rigs import board_of, calibrated_rig

from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.board_pictures import board_light
from appliance.simulation.boards.boards import high_pose, low_pose, random_poses
from appliance.simulation.response import ResponseShape
from appliance.simulation.sensor import NoiseStock
from vision.calibration.board_edges import board_edges
from vision.calibration.checkerboard import Board
from vision.calibration.response import measure_response

POSES = 15
SHOWN_POSES = 8  # of them, and both registration boards: what the response is measured from
NOISE_PX = 0.04


def drawn_setup(seed, condition, bits=8):
    """A scene whose camera has a response of random shape."""
    setup = set_up(condition, seed)
    return replace(setup, sensor=replace(setup.sensor, response=response_of(seed), bits=bits))


def response_of(seed):
    return ResponseShape.drawn(np.random.default_rng([seed, 0x5253]))


@lru_cache(maxsize=1)
def board_scenes(seed):
    """Light of the boards in each view, with their true corners: (side, light, corners), and the user's board."""
    setup = set_up("clean", seed)
    rng, true_board = board_of(seed)
    poses = random_poses(setup.rig, rng, true_board, POSES)[:SHOWN_POSES]
    scene = setup.scene_as_calibrated()
    shown = []
    for pose in [*poses, low_pose(true_board), high_pose(true_board)]:
        for side, view in enumerate((scene.left, scene.right)):
            corners = view.camera.project(pose.in_world(true_board.corners_mm()))
            shown.append((side, board_light(view, true_board, pose), corners))
    known = Board(true_board.squares, true_board.square_mm, true_board.low_mm, true_board.high_mm, 0.01, 0.1)
    return shown, known


def measured_response(seed, setup, coding):
    """What the product makes of the boards as the camera sends them."""
    shown, board = board_scenes(seed)
    scene = Scene(setup.rig, seed, setup.sensor, setup.blur, setup.glow)
    rig, rng = calibrated_rig(seed), np.random.default_rng([seed, 0x6264])
    edges = []
    for side, light, corners in shown:
        view = (scene.left, scene.right)[side]
        starts = rng.integers(NoiseStock.EXTRA, size=coding.frames)
        picture = coding.sent([view.grey_picture(light.copy(), int(start)) for start in starts])
        found = corners + rng.normal(0, NOISE_PX, corners.shape)
        edges.append((board_edges(picture, (rig.left, rig.right)[side], found, board), picture.coding))
    return measure_response(edges)
