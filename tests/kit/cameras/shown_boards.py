"""Folders of board pictures for cameras that show folders: poses, low board, high board, each left and right."""

import signal
import subprocess

import cv2
import numpy as np
from running import HOTGAUGE

from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.boards.board_pictures import rig_folder_pictures
from appliance.simulation.boards.boards import Board
from appliance.simulation.sensor import Sensor
from appliance.simulation.true_rig import default_rig

BOARD = Board()
BOARD_WORDS = ["--squares", "8x5", "--mm", "50", "--u-mm", "0.01"]
HEIGHT_WORDS = ["--low-mm", str(BOARD.low_mm), "--high-mm", str(BOARD.high_mm), "--height-u-mm", "0.1"]


def write_boards(folder, poses, seed=3):
    """Folders `00`, `01`, ..., `low` and `high` below a folder, with `left` and `right` in each; the true rig."""
    rig = default_rig()
    scene = Scene(rig, seed, Sensor())
    for place, left, right in rig_folder_pictures(scene, rig, np.random.default_rng(seed), BOARD, poses):
        name = place.partition("{side}_")[2]
        kind = name.removesuffix(".png")
        for side, picture in (("left", left), ("right", right)):
            (folder / kind / side).mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(folder / kind / side / name), picture)
    return rig


def capture_poses(rig_folder, config, number, show):
    """Run `hotgauge capture boards`, show each next pose once one is stored, and end it by Ctrl-C; what it said."""
    words = ["capture", "boards", "--output", rig_folder, *BOARD_WORDS, "--within", "120", "--config", config]
    with subprocess.Popen([HOTGAUGE, *map(str, words)], stdout=subprocess.PIPE, text=True) as process:
        said, stored = "", 0
        for line in process.stdout:
            said += line
            if not line.startswith("pose "):
                continue
            stored += 1
            if stored == number:
                process.send_signal(signal.SIGINT)
            else:
                show(f"{stored:02d}")
        assert process.wait(20) == 0, said
    return said
