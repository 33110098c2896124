"""Cameras whose response is of random shape and told to nobody: it is measured from the boards as they are sent."""

from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np
from calibrated_rigs import board_of, calibrated_rig

from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.board_pictures import board_light
from appliance.simulation.boards.boards import high_pose, low_pose, random_poses
from appliance.simulation.response import ResponseShape
from vision.calibration.board_edges import board_edges
from vision.calibration.checkerboard import Board
from vision.calibration.response import measure_response

POSES = 15
SHOWN_POSES = 6  # of them, and both registration boards: what the response is measured from
NOISE_PX = 0.04
BLOCK_PX, MARGIN_PX = 16, 12  # only the part of a picture around the board is coded, in whole blocks of all codecs


class CameraLine:
    """One seed's rig and bar before cameras whose response is of random shape; what all codings share is drawn once."""

    def __init__(self, seed, condition):
        self.seed = seed
        self.setup = set_up(condition, seed)
        self.response = response_of(seed)
        self.sensor = replace(self.setup.sensor, response=self.response)
        self._pair = lru_cache(self._drawn_pair)

    @property
    def diameter_mm(self):
        return self.setup.diameter_mm

    @cached_property
    def rig(self):
        """As the product calibrates it; raises CalibrationError where it refuses to."""
        return calibrated_rig(self.seed)

    def sent(self, coding):
        """The bar's pictures, left and right, as they arrive."""
        pairs = [self._pair(coding.bits, frame) for frame in range(coding.frames)]
        return [coding.sent([pair[side] for pair in pairs]) for side in (0, 1)]

    @cached_property
    def _board_scenes(self):
        return board_scenes(replace(set_up("clean", self.seed), sensor=self.sensor))

    def _drawn_pair(self, bits, frame):
        return replace(self.setup, sensor=replace(self.sensor, bits=bits)).pair(frame)

    def measured_response(self, coding):
        """What the product makes of the boards as the camera sends them."""
        return measure_response(self.board_edges(coding))

    def board_edges(self, coding):
        """Edges of all boards, each with its coding."""
        shown, board = self._board_scenes
        sensor, rng = replace(self.sensor, bits=coding.bits), np.random.default_rng([self.seed, 0x6264])
        table, edges = sensor.table(), []
        for side, first, light, corners in shown:
            picture = coding.sent([digitised(light, sensor, table, rng) for _ in range(coding.frames)])
            camera = (self.rig.left, self.rig.right)[side]
            found = corners + rng.normal(0, NOISE_PX, corners.shape)
            edges.append((board_edges(picture, cut(camera, first), found - first, board), picture.coding))
        return edges


def digitised(light, sensor, table, rng):
    """Grey picture of linear light with new noise."""
    noisy = light + sensor.noise(light) * rng.standard_normal(light.shape, dtype=np.float32)
    return table[(np.clip(noisy, 0, 1) * sensor.levels).astype(np.uint16)]


def cut(camera, first):
    """The camera for a part of its picture that begins at a pixel (x, y)."""
    moved = np.zeros((3, 3))
    moved[:2, 2] = first
    return replace(camera, K=camera.K - moved)


def response_of(seed):
    return ResponseShape.drawn(np.random.default_rng([seed, 0x5253]))


def board_scenes(setup):
    """Light around the boards in each view: (side, first pixel, light, true corners), and the user's board."""
    rng, true_board = board_of(setup.seed)
    poses = random_poses(setup.rig, rng, true_board, POSES)[:SHOWN_POSES]
    scene = setup.scene_as_calibrated()
    shown = []
    for pose in [*poses, low_pose(true_board), high_pose(true_board)]:
        for side, view in enumerate((scene.left, scene.right)):
            corners = view.camera.project(pose.in_world(true_board.corners_mm()))
            first, last = around(view.camera.project(pose.in_world(true_board.sheet_mm())), view.camera.image_size)
            light = board_light(view, true_board, pose)[first[1] : last[1], first[0] : last[0]].copy()
            shown.append((side, first, light, corners))
    known = Board(true_board.squares, true_board.square_mm, true_board.low_mm, true_board.high_mm, 0.01, 0.1)
    return shown, known


def around(corners, image_size):
    """First and last pixel (x, y) of whole blocks around a sheet."""
    first = np.floor((corners.min(axis=0) - MARGIN_PX) / BLOCK_PX).astype(int) * BLOCK_PX
    last = np.ceil((corners.max(axis=0) + MARGIN_PX) / BLOCK_PX).astype(int) * BLOCK_PX
    return np.maximum(first, 0), np.minimum(last, np.array(image_size) // 2 * 2)
