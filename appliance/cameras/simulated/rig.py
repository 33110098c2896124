"""The rig of the simulated mill, calibrated as a user would."""

import json

from appliance.cameras.simulated.pairs import MillSource
from appliance.simulation.boards.boards import board_document
from vision.calibration.checkerboard import Board
from vision.calibration.rig import Rig
from vision.calibration.stereo import calibrate


def mill_rig(mill: MillSource) -> Rig:
    """Calibrate the simulated mill's cameras from what a corner detector finds on its boards, as a user would."""
    board = Board.from_json(json.dumps(board_document(mill.board, mill.response)))
    seen = mill.observe_boards()
    return calibrate(seen.calibration, seen.low, seen.high, board, mill.image_size).rig
