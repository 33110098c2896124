"""How often U holds of route V on fused pictures and with every edge detector, and how large it is.

Every pair of an edge detector and a fusion is seen on its own scenes; `none` reads each view apart.
"""

from functools import lru_cache

import numpy as np
from calibrated_rigs import calibrated_rig

from appliance.simulation.bars.study_scenes import draw
from vision.edges.names import EDGE_METHODS
from vision.fusion.names import FUSIONS
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

TEXT = (
    "Route V by edge detector and fusion; rigs, boards and calibrations as in served_diameter, 800 x 600. A value that "
    "states no U has a reason and no trust, and is not counted as covered or not."
)
CONDITIONS = ("clean", "scale", "post", "haze")
SEEDS = 6
FUSED_BY = ("sobel",)  # the edges that every fusion is seen with; the other detectors are seen without fusion


def cases():
    pairs = [(edges, "none") for edges in EDGE_METHODS] + [(edges, name) for edges in FUSED_BY for name in FUSIONS[1:]]
    return [
        {"condition": condition, "seed": seed, "edges": edges, "fusion": fusion}
        for seed in range(SEEDS)
        for condition in CONDITIONS
        for edges, fusion in pairs
    ]


def run(case):
    scene = drawn(case["condition"], case["seed"])
    gauge = VirtualBoardGauge(calibrated_rig(case["seed"]), edges=case["edges"], fusion=case["fusion"])
    reading = gauge.measure(scene.left, scene.right)
    if not reading.valid:
        return {"error_mm": None, "expanded_mm": None}
    stated = np.isfinite(reading.expanded_uncertainty_mm)
    return {
        "error_mm": reading.diameter_mm - scene.truth["diameter_mm"],
        "expanded_mm": reading.expanded_uncertainty_mm if stated else None,
    }


@lru_cache(maxsize=1)
def drawn(condition, seed):
    return draw(condition, seed)


def summary(rows):
    pairs = dict.fromkeys((row["edges"], row["fusion"]) for row in rows)
    return {
        f"{edges}, {fusion}": _told([row for row in rows if (row["edges"], row["fusion"]) == (edges, fusion)])
        for edges, fusion in pairs
    }


def _told(rows):
    values = [row for row in rows if row["error_mm"] is not None]
    stated = [row for row in values if row["expanded_mm"] is not None]
    error, expanded = (np.array([row[key] for row in stated]) for key in ("error_mm", "expanded_mm"))
    return {
        "frames": len(rows),
        "values": len(values),
        "stated": len(stated),
        "covered": round(float(np.mean(np.abs(error) <= expanded)), 4),
        "rmse_mm": round(float(np.sqrt(np.mean(error**2))), 4),
        "median_expanded_mm": round(float(np.median(expanded)), 4),
    }
