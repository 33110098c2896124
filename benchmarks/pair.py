"""How long one image pair takes, beside what one would write first: Canny and Hough lines on both pictures.

Both run in turn on the same pairs in one process; the ratio is what to quote, times depend on the machine.
"""

import statistics
import time

import cv2
import numpy as np
from mill_scenes import perfect_rig

from appliance.mill.bars import Bar
from appliance.mill.rig import default_rig
from appliance.mill.scene import Scene
from vision.sizing.tangent import TangentGauge

SIZES = ((800, 600), (2704, 1520))
ROUNDS = 15


def canny_and_lines(left, right):
    return [
        cv2.HoughLines(cv2.Canny(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), 50, 150), 1, np.pi / 720, 150)
        for picture in (left, right)
    ]


def timed_ms(work, *arguments):
    started = time.perf_counter()
    work(*arguments)
    return 1000 * (time.perf_counter() - started)


def main():
    for size in SIZES:
        true_rig = default_rig(size)
        scene, gauge = Scene(true_rig, seed=1), TangentGauge(perfect_rig(true_rig))
        pairs = [scene.pair(Bar(diameter_mm), 0) for diameter_mm in (100.0, 180.0, 260.0)]
        pairs = pairs * (1 + ROUNDS // len(pairs))
        ours = [timed_ms(gauge.measure, *pair) for pair in pairs]
        plain = [timed_ms(canny_and_lines, *pair) for pair in pairs]
        ours_ms, plain_ms = statistics.median(ours), statistics.median(plain)
        print(
            f"{size[0]} x {size[1]}: route T {ours_ms:.1f} ms a pair, Canny and Hough lines {plain_ms:.1f} ms, "
            f"ratio {ours_ms / plain_ms:.2f}"
        )


if __name__ == "__main__":
    main()
