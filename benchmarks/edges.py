"""Edges by our forest beside OpenCV's `createStructuredEdgeDetection` with the same model on the same pictures.

Both are timed in turn within one run, round by round: wall time and CPU time of the call alone, the smallest of all
rounds. Ratios are what to quote, times depend on the machine and its load.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
from opencv_format import write_opencv
from timing import Child, Times, timed

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.edges.forest.inference import EdgeDetector
from vision.edges.forest.model import StructuredForest, shipped_forest

SIZES = ((640, 480), (800, 600), (1352, 760), (2704, 1520))
STRIPS = {(800, 600): (np.s_[100:212, :], np.s_[400:512, :])}


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
        (kind, part, threads): lambda image=image, part=part, threads=threads: timed(
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
            times[threads].append(opencv.ask(f"{threads} {path}"))
    best = {key: least(values) for key, values in times.items()}
    for kind, part, threads in rows:
        ours, theirs = best[kind, part, threads], best[threads]
        print(
            f"{size[0]:5} x {size[1]:4} {kind:6} {part:10} {threads} threads: wall {ours.clock_ms:6.1f} ms (OpenCV "
            f"{theirs.clock_ms:7.1f}, {theirs.clock_ms / ours.clock_ms:4.1f} times), CPU {ours.processor_ms:6.1f} ms "
            f"({theirs.processor_ms:7.1f}, {theirs.processor_ms / ours.processor_ms:4.1f} times)",
            flush=True,
        )


def least(all_times: list[Times]) -> Times:
    return Times(min(one.clock_ms for one in all_times), min(one.processor_ms for one in all_times))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", type=Path, help="an .npz forest instead of the shipped one")
    parser.add_argument("--rounds", type=int, default=9)
    arguments = parser.parse_args()
    forest = StructuredForest.load(arguments.model) if arguments.model else shipped_forest()
    print(f"edges by a forest of {forest.trees} trees with {len(forest.left_children)} nodes")
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "forest.yml"
        write_opencv(forest, model)
        with Child("opencv_forest.py", model) as opencv:
            for size in SIZES:
                compare(size, forest, opencv, Path(folder), arguments.rounds)


if __name__ == "__main__":
    main()
