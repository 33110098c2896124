"""How long one image pair takes, by route and by stage, beside what one would write first: Canny and Hough lines.

All run in turn on the same pairs in one process; the ratio is what to quote, times depend on the machine. The last
column is the processor's time: of two cores it may be twice the time on the clock.
"""

import statistics
import time
from dataclasses import replace

import cv2
import numpy as np
from mill_scenes import perfect_rig

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.boards.board_pictures import board_light
from appliance.simulation.boards.boards import Board, high_pose, low_pose
from appliance.simulation.true_rig import default_rig
from vision.calibration.still_marks import find_marks
from vision.sizing.gauge import Gauge

SIZES = ((800, 600), (2704, 1520))
ROUNDS = 15


def canny_and_lines(left, right):
    return [
        cv2.HoughLines(cv2.Canny(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), 50, 150), 1, np.pi / 720, 150)
        for picture in (left, right)
    ]


def timed_ms(work, *arguments):
    """Time on the clock and of the processor."""
    clock, processor = time.perf_counter(), time.process_time()
    result = work(*arguments)
    return result, (1000 * (time.perf_counter() - clock), 1000 * (time.process_time() - processor))


def stages(gauge, pair):
    """Each stage of the gauge on one pair, in its order."""
    outlines, find = timed_ms(gauge._tangent.find, *pair)
    moved_px, marks = timed_ms(gauge._moved_px, *pair)
    _, tangent = timed_ms(gauge._tangent.measure_bar, *pair, outlines, moved_px)
    _, virtual_board = timed_ms(gauge._virtual_board.measure_bar, *pair, outlines)
    return {
        "find the bar": find,
        "still marks": marks,
        "route T": tangent,
        "route V": virtual_board,
        "the whole gauge": timed_ms(gauge.measure, *pair)[1],
        "Canny and Hough lines": timed_ms(canny_and_lines, *pair)[1],
    }


def main():
    for size in SIZES:
        true_rig = default_rig(size)
        scene = Scene(true_rig, seed=1)
        gauge = Gauge(rig_with_marks(scene, true_rig))
        pairs = [scene.pair(Bar(diameter_mm), 0) for diameter_mm in (100.0, 180.0, 260.0)]
        stages(gauge, pairs[0])  # compiles
        rounds = [stages(gauge, pairs[number % len(pairs)]) for number in range(ROUNDS)]
        print(f"{size[0]} x {size[1]}: median ms a pair, on the clock and of the processor")
        for stage in rounds[0]:
            clock_ms, processor_ms = (statistics.median(one[stage][part] for one in rounds) for part in (0, 1))
            print(f"  {stage:<24} {clock_ms:8.1f} {processor_ms:8.1f}")


def rig_with_marks(scene, true_rig):
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
