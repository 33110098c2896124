"""Where the time of an image pair goes, stage by stage, beside what one would write first: Canny and Hough lines.

All run in turn on the same pairs in one process. The last column is the processor's time: of two cores it may be twice
the time on the clock. `Copy of both pictures` is what the memory's bandwidth alone costs.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
from mill_scenes import perfect_rig
from timing import Times, timed

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.boards.board_pictures import board_light
from appliance.simulation.boards.boards import Board, high_pose, low_pose
from appliance.simulation.true_rig import TrueRig, default_rig
from vision.calibration.rig import Rig
from vision.calibration.still_marks import find_marks
from vision.sizing.checked_pictures import checked_pair
from vision.sizing.gauge import Gauge

SIZES = ((800, 600), (1300, 800), (2704, 1520))
BARS_MM = (100.0, 180.0, 260.0)
ROUNDS = 15
OPENCV_THREADS = (1, 2)


def canny_and_lines(left: np.ndarray, right: np.ndarray) -> None:
    for picture in (left, right):
        grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        cv2.HoughLines(cv2.Canny(grey, 50, 150), 1, np.pi / 720, 150)


class Stages:
    """Runs work by name and keeps what each took."""

    def __init__(self) -> None:
        self.times: dict[str, Times] = {}

    def __call__(self, name: str, work: Callable, *arguments):
        kept = []
        self.times[name] = timed(lambda: kept.append(work(*arguments)))
        return kept[0]


def stages(gauge: Gauge, pair: tuple[np.ndarray, np.ndarray]) -> dict[str, Times]:
    """Each stage of the gauge on one pair, in its order."""
    stage, pictures, board = Stages(), checked_pair(gauge._rig, *pair), gauge._virtual_board
    outlines = stage("find the bar", gauge._tangent.find, *pictures)
    stage("still marks", gauge._motions, *pictures)
    stage("route T", gauge._tangent.measure_bar, *pictures, outlines)
    stage("route V", board.measure_bar, *pictures, outlines)
    regions = stage("  turned regions", board._regions, pictures, outlines)
    stage("  edges", lambda: list(board._pool.map(board._view_edges, regions, outlines)))
    stage("the whole gauge", gauge.measure, *pair)
    stage("Canny and Hough lines", canny_and_lines, *pair)
    stage("copy of both pictures", lambda: [picture.copy() for picture in pair])
    return stage.times


def main() -> None:
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    for size in SIZES:
        true_rig = default_rig(size)
        scene = Scene(true_rig, seed=1)
        gauge = Gauge(rig_with_marks(scene, true_rig))
        pairs = [scene.pair(Bar(diameter_mm), 0) for diameter_mm in BARS_MM]
        stages(gauge, pairs[0])  # compiles
        medians = {threads: median_stages(gauge, pairs, threads) for threads in OPENCV_THREADS}
        print(f"{size[0]} x {size[1]}: median ms a pair, on the clock and of the processor, {OPENCV_THREADS} threads")
        for stage in medians[1]:
            both = (f"{median[stage].clock_ms:8.1f} {median[stage].processor_ms:8.1f}" for median in medians.values())
            print(f"  {stage:<24} {'   '.join(both)}", flush=True)


def median_stages(gauge: Gauge, pairs: list[tuple[np.ndarray, np.ndarray]], threads: int) -> dict[str, Times]:
    """Medians over all rounds; `threads` are OpenCV's, beside the gauge's own two."""
    cv2.setNumThreads(threads)
    rounds = [stages(gauge, pairs[number % len(pairs)]) for number in range(ROUNDS)]
    return {stage: Times.median([one[stage] for one in rounds]) for stage in rounds[0]}


def rig_with_marks(scene: Scene, true_rig: TrueRig) -> Rig:
    """The true rig as if calibrated from pictures of boards: with their corners and with still marks."""
    rig, board, marks = perfect_rig(true_rig), Board(), []
    corners = {}
    for side, view in (("left", scene.left), ("right", scene.right)):
        poses = {"low": low_pose(board), "high": high_pose(board)}
        seen = {name: view.camera.project(pose.in_world(board.corners_mm())) for name, pose in poses.items()}
        corners |= {f"{side}_{name}": points for name, points in seen.items()}
        low, high = (view.grey_picture(board_light(view, board, pose), 0) for pose in poses.values())
        marks.append(find_marks(low, high, (seen["low"], seen["high"])))
    return replace(rig, boards=corners, marks=tuple(marks))


if __name__ == "__main__":
    main()
