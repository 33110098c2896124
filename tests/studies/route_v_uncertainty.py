"""Whether U of route V, shown to hold with the forest's edges (virtual_board.json), holds with every other detector.

The same frames by each detector: U is the same budget, so it holds with one as with another if their diameters differ
by little of it. Each view is measured on its own; a fused picture states no U.
"""

from functools import lru_cache

import numpy as np
from calibrated_rigs import calibrated_rig

from appliance.simulation.bars.study_scenes import draw
from vision.edges.names import EDGE_METHODS
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

TEXT = (
    "Route V by edge detector, each view on its own; rigs, boards and calibrations as in served_diameter, 800 x 600. "
    "rms_from_forest_mm, most_from_forest_of_u: of the differences from the forest's diameter of the same frame."
)
CONDITIONS = ("clean", "scale", "post", "haze")
SEEDS = 6


def cases():
    return [
        {"condition": condition, "seed": seed, "edges": edges}
        for seed in range(SEEDS)
        for condition in CONDITIONS
        for edges in EDGE_METHODS
    ]


def run(case):
    scene = drawn(case["condition"], case["seed"])
    reading = VirtualBoardGauge(calibrated_rig(case["seed"]), edges=case["edges"]).measure(scene.left, scene.right)
    if not reading.valid:
        return {"error_mm": None, "expanded_mm": None}
    return {
        "error_mm": reading.diameter_mm - scene.truth["diameter_mm"],
        "expanded_mm": reading.expanded_uncertainty_mm,
    }


@lru_cache(maxsize=1)
def drawn(condition, seed):
    return draw(condition, seed)


def summary(rows):
    forest = {(row["condition"], row["seed"]): row["error_mm"] for row in rows if row["edges"] == "forest"}
    return {edges: _told([row for row in rows if row["edges"] == edges], forest) for edges in EDGE_METHODS}


def _told(rows, forest):
    values = [row for row in rows if row["error_mm"] is not None and forest[row["condition"], row["seed"]] is not None]
    error, expanded = (np.array([row[key] for row in values]) for key in ("error_mm", "expanded_mm"))
    apart = error - np.array([forest[row["condition"], row["seed"]] for row in values])
    return {
        "frames": len(rows),
        "values": len(values),
        "covered": round(float(np.mean(np.abs(error) <= expanded)), 4),
        "rmse_mm": round(float(np.sqrt(np.mean(error**2))), 4),
        "median_expanded_mm": round(float(np.median(expanded)), 4),
        "rms_from_forest_mm": round(float(np.sqrt(np.mean(apart**2))), 4),
        "most_from_forest_of_u": round(float(np.max(np.abs(apart) / expanded)), 4),
    }
