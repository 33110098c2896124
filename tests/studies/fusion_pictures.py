"""The source's table 5.1 on the path-traced recording `line_a`: seven metrics of each method's fused pictures."""

import os
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from appliance.cameras.recording.pairs import Recording
from appliance.sizing.stereo.calibrate_folder import calibrate_folder
from vision.alignment.view_alignment import Alignment
from vision.alignment.virtual_boards import VirtualBoards
from vision.fusion.common_view import common_rectangle
from vision.fusion.methods import METHODS, fuse
from vision.fusion.metrics import METRICS
from vision.geometry.turned_region import picture_region
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

TEXT = (
    "Recording line_a, all 16 pairs, rig calibrated from its own boards; grey pictures, the rows that show the "
    "measuring region, right view aligned on the plane where the bar's outlines agree; metrics of the largest "
    "rectangle that both cameras see. left and right: the views."
)
FOLDER = Path(os.environ.get("HOTGAUGE_RECORDINGS", Path(__file__).parents[3] / "shared" / "recordings"), "line_a")
VIEWS = ("left", "right")


def cases():
    scenes = sorted(path.name for path in (FOLDER / "scenes").iterdir())
    return [
        {"scene": scene, "frame": frame, "method": method}
        for scene in scenes
        for frame in (0, 1)
        for method in (*VIEWS, *METHODS)
    ]


def run(case):
    (left, right), common = aligned_pair(case["scene"], case["frame"])
    if case["method"] in VIEWS:
        view = left if case["method"] == "left" else right
        return {row.symbol: row.of_one(view[common]) if row.of_one else None for row in METRICS}
    fused = fuse(left, right, case["method"])
    return {row.symbol: row.measure(fused[common], left[common], right[common]) for row in METRICS}


@lru_cache(maxsize=1)
def rig():
    return calibrate_folder(FOLDER).rig


@lru_cache(maxsize=1)
def aligned_pair(scene, frame):
    pair = Recording(FOLDER / "scenes" / scene).read(frame)[1:]
    height_mm = VirtualBoardGauge(rig(), edges="sobel").measure(*pair).plane_height_mm
    regions = [
        picture_region(camera, picture, rig().region_y_mm)
        for camera, picture in zip((rig().left, rig().right), pair, strict=True)
    ]
    alignment = Alignment(rig(), VirtualBoards.of_rig(rig()), *regions, projective=True)
    pictures = alignment.left.picture, alignment.right_on_left(height_mm)
    common = common_rectangle(alignment.seen_by_both(height_mm))
    return [cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) for picture in pictures], common


def summary(rows):
    return {method: _means([row for row in rows if row["method"] == method]) for method in (*VIEWS, *METHODS)}


def _means(rows):
    there = [row.symbol for row in METRICS if rows[0][row.symbol] is not None]
    return {symbol: round(float(np.mean([row[symbol] for row in rows])), 4) for symbol in there}
