"""How long route V takes, stage by stage, beside route T on the same pairs in one process; CPU time, median."""

import statistics
import time
from collections import defaultdict

from mill_scenes import perfect_rig

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.alignment.view_alignment import Alignment
from vision.sizing.tangent.gauge import TangentGauge
from vision.sizing.virtual_board.aligned_pair import AlignedPair
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

SIZES = ((800, 600), (2704, 1520))
ROUNDS = 15


def stages_ms(gauge, left, right, took):
    def stage(name, work):
        started = time.process_time()
        result = work()
        took[name].append(1000 * (time.process_time() - started))
        return result

    images = (left, right)
    outlines = stage(
        "rough outlines",
        lambda: tuple(
            grid.bars(image, gauge._decoder.shown)[0] for grid, image in zip(gauge._grids, images, strict=True)
        ),
    )
    regions = stage("turned regions", lambda: gauge._regions(images, outlines))
    edges = stage("edges", lambda: [gauge._view_edges(r, o) for r, o in zip(regions, outlines, strict=True)])
    alignment = Alignment(gauge.rig, gauge._boards, *regions, True)
    height = stage("height", lambda: gauge._height(alignment, edges[0].outline, edges[1].outline))
    pair = AlignedPair(alignment, height, edges, edges[0].outline)
    stage("windows", lambda: gauge._read(pair, type(gauge._held())(0)))


def main():
    for size in SIZES:
        true_rig = default_rig(size)
        scene, rig = Scene(true_rig, seed=1), perfect_rig(true_rig)
        pairs = [scene.pair(Bar(diameter_mm), 0) for diameter_mm in (100.0, 180.0, 260.0)] * (1 + ROUNDS // 3)
        board, tangent, took = VirtualBoardGauge(rig), TangentGauge(rig), defaultdict(list)
        for gauge in (board, tangent):
            gauge.measure(*pairs[0])
        for pair in pairs:
            stages_ms(board, *pair, took)
            for name, gauge in (("route V", board), ("route T", tangent)):
                wall, started = time.perf_counter(), time.process_time()
                gauge.measure(*pair)
                took[name].append(1000 * (time.process_time() - started))
                took[f"{name}, elapsed"].append(1000 * (time.perf_counter() - wall))
        told = ", ".join(f"{name} {statistics.median(times):.1f}" for name, times in took.items())
        print(f"{size[0]} x {size[1]}, ms of CPU a pair: {told}")


if __name__ == "__main__":
    main()
