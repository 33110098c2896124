"""Edges by our forest beside OpenCV's `createStructuredEdgeDetection` with the same model on the same pictures.

Both are timed in turn within one run, round by round: wall time and CPU time of the call alone, the smallest of all
rounds. Ratios are what to quote, times depend on the machine and its load.
"""

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from opencv_format import write_opencv

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.edges.forest.inference import EdgeDetector
from vision.edges.forest.model import StructuredForest, shipped_forest

SIZES = ((640, 480), (800, 600), (1352, 760), (2704, 1520))
STRIPS = {(800, 600): (np.s_[100:212, :], np.s_[400:512, :])}
CONTRIB = Path(__file__).parents[1] / ".venv-contrib" / "bin" / "python"


class OpenCV:
    """The other implementation, in its own environment."""

    def __init__(self, python, model):
        script = Path(__file__).with_name("opencv_forest.py")
        self.process = subprocess.Popen(
            [python, script, model], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        self.process.stdout.readline()

    def timed_ms(self, path, threads):
        self.process.stdin.write(f"{threads} {path}\n")
        return np.array([float(word) for word in self.process.stdout.readline().split()])

    def close(self):
        self.process.stdin.close()
        self.process.wait(10)


def timed_ms(work, *arguments):
    wall, cpu = time.perf_counter(), time.process_time()
    work(*arguments)
    return 1000 * np.array([time.perf_counter() - wall, time.process_time() - cpu])


def picture(size):
    left, _ = Scene(default_rig(size), seed=1).pair(Bar(180.0), 0)
    return np.ascontiguousarray(left[:, :, ::-1]).astype(np.float32) / np.float32(255)


def compare(size, forest, opencv, folder, rounds):
    colour = picture(size)
    path = folder / f"{size[0]}.npy"
    np.save(path, colour)
    pictures = {"colour": colour, "grey": np.ascontiguousarray(colour[:, :, 0])}
    detectors = {threads: EdgeDetector(forest, threads) for threads in (1, 2)}
    regions = {"whole": [np.s_[:, :]]} | ({"two strips": list(STRIPS[size])} if size in STRIPS else {})
    rows = {
        (kind, part, threads): lambda image=image, part=part, threads=threads: timed_ms(
            detectors[threads].strength_in, image, regions[part]
        )
        for kind, image in pictures.items()
        for part in regions
        for threads in detectors
    }
    for row in rows.values():
        row()
    times = {key: [] for key in [*rows, 1, 2]}
    for _ in range(rounds):
        for key, row in rows.items():
            times[key].append(row())
        for threads in (1, 2):
            times[threads].append(opencv.timed_ms(path, threads))
    best = {key: np.min(values, axis=0) for key, values in times.items()}
    for kind, part, threads in rows:
        ours, theirs = best[kind, part, threads], best[threads]
        print(
            f"{size[0]:5} x {size[1]:4} {kind:6} {part:10} {threads} threads: wall {ours[0]:6.1f} ms (OpenCV "
            f"{theirs[0]:7.1f}, {theirs[0] / ours[0]:4.1f} times), CPU {ours[1]:6.1f} ms ({theirs[1]:7.1f}, "
            f"{theirs[1] / ours[1]:4.1f} times)",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", type=Path, help="an .npz forest instead of the shipped one")
    parser.add_argument("--opencv-python", type=Path, default=CONTRIB)
    parser.add_argument("--rounds", type=int, default=9)
    arguments = parser.parse_args()
    forest = StructuredForest.load(arguments.model) if arguments.model else shipped_forest()
    print(f"edges by a forest of {forest.trees} trees with {len(forest.left_children)} nodes")
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "forest.yml"
        write_opencv(forest, model)
        opencv = OpenCV(arguments.opencv_python, model)
        for size in SIZES:
            compare(size, forest, opencv, Path(folder), arguments.rounds)
        opencv.close()


if __name__ == "__main__":
    main()
