"""How often U of route V holds with every edge detector that may be chosen, and how large it is.

Each view is measured on its own; a fused picture states no U, so there is nothing to hold against its errors.
"""

from functools import lru_cache

import numpy as np
from calibrated_rigs import calibrated_rig

from appliance.simulation.bars.study_scenes import draw
from vision.edges.names import EDGE_METHODS
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

TEXT = (
    "Route V by edge detector, each view on its own; rigs, boards and calibrations as in served_diameter, 800 x 600. "
    "covered_standard_error: over the rigs, all of whose values share a calibration."
)
CONDITIONS = ("clean", "scale", "post", "haze")
SEEDS = 16


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
    return {edges: _told([row for row in rows if row["edges"] == edges]) for edges in EDGE_METHODS}


def _told(rows):
    values = [row for row in rows if row["error_mm"] is not None]
    error, expanded = (np.array([row[key] for row in values]) for key in ("error_mm", "expanded_mm"))
    inside, rig = np.abs(error) <= expanded, np.array([row["seed"] for row in values])
    of_rig = np.array([inside[rig == one].mean() for one in np.unique(rig)])
    return {
        "frames": len(rows),
        "values": len(values),
        "covered": round(float(inside.mean()), 4),
        "covered_standard_error": round(float(of_rig.std(ddof=1) / np.sqrt(of_rig.size)), 4),
        "rmse_mm": round(float(np.sqrt(np.mean(error**2))), 4),
        "worst_mm": round(float(np.abs(error).max()), 4),
        "median_expanded_mm": round(float(np.median(expanded)), 4),
    }
