"""The forest beside Sobel, Prewitt, Roberts and Canny on bars turned upright: are limbs found, and what else is?"""

import os
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import upright
from edge_evaluation import limb_rows

from appliance.simulation.bars.study_scenes import set_up
from vision.edges.operators import EDGE_METHODS, EdgeMap, canny, detect_edges, grey_of
from vision.edges.thinning import ridges

TEXT = (
    "Both pictures of scenes that no forest was trained on, each with its own rig, and of the recording line_a, whose "
    "truth is used for turning and judging only: the measuring region, bar upright, in colour, which the classical "
    "operators take as grey, and its brightest channel that is not clipped (`grey`); edges suppressed along their own "
    "normals. `dim` is `clean` at a quarter of the exposure. "
    "Counted at each of THRESHOLDS: limb rows with an edge within 1 px and within 3 px of the limb, and rows with an "
    "edge inside the bar further than 3 px from both limbs. A method's one threshold for all scenes is the highest at "
    "which 99 % of all limb rows have an edge within 3 px. Canny's threshold is the higher one of its pair, the lower "
    "one 0.4 of it. Glare, posts and ends are left out: there parts of the limb cannot be seen."
)
CONDITIONS = ("clean", "scale", "rollers", "haze", "overexposed", "dim")
DIM = 0.25
PICTURES = ("colour", "grey")
SEEDS = 10
RECORDED = tuple(f"s{n}_{kind}" for n, kind in enumerate(("clean", "scale") * 4, start=1))
RECORDINGS = Path(os.environ.get("HOTGAUGE_RECORDINGS", Path(__file__).parents[3] / "shared" / "recordings"))
THRESHOLDS = np.geomspace(0.004, 0.99, 48)
WANTED_FOUND = 0.99


def cases():
    rendered = [(name, seed, side) for seed in range(SEEDS) for name in CONDITIONS for side in ("left", "right")]
    recorded = [(name, frame, side) for name in RECORDED for frame in range(2) for side in ("left", "right")]
    return [
        {"scene": scene, "number": number, "side": side, "picture": picture}
        for scene, number, side in rendered + recorded
        for picture in PICTURES
    ]


def run(case):
    return judged(case, EDGE_METHODS, edges)


def judged(case, methods, found):
    """Counts of one picture; `found` gives the edges of a picture by a method."""
    if case["scene"] in RECORDED:
        bar = upright.recorded(RECORDINGS / "line_a", case["scene"], case["number"], case["side"])
    else:
        bar = upright.rendered(*_drawn(case["scene"], case["number"]), case["side"])
    image = getattr(bar, case["picture"])
    return {"rows_in_all": bar.limbs_px.shape[1]} | {method: _counts(bar, found(image, method)) for method in methods}


@lru_cache(maxsize=1)
def _drawn(condition, seed):
    setup = set_up("clean" if condition == "dim" else condition, seed)
    if condition == "dim":
        setup = replace(setup, gain=DIM)
    return setup, setup.pair()


def edges(image, method):
    """Edges of any strength: Canny's are as strong as the highest threshold that they pass."""
    if method != "canny":
        return detect_edges(image, method)
    grey = grey_of(image)
    steps = [canny(grey, 0.4 * high, high) for high in THRESHOLDS]
    passed = np.max([high * step.strength for high, step in zip(THRESHOLDS, steps, strict=True)], axis=0)
    return EdgeMap(passed.astype(np.float32), steps[0].normal_rad)


def _counts(bar, found_edges):
    strength, thinned = found_edges.strength, ridges(found_edges.strength, found_edges.normal_rad)
    rows = limb_rows(strength[upright.JUDGED], thinned[upright.JUDGED], bar.limbs_px)
    steps = (THRESHOLDS * (1 - 1e-6))[:, None]
    left, right = rows.offset_px
    return {
        "found": (rows.found.ravel() >= steps).sum(axis=1).tolist(),
        "near": (rows.near.ravel() >= steps).sum(axis=1).tolist(),
        "false": (rows.false >= steps).sum(axis=1).tolist(),
        "offset_px": [round(float(np.nanmean(side)), 4) for side in (left, right)],
        "spread_px": round(float(np.nanstd(rows.offset_px - np.nanmean(rows.offset_px, axis=1, keepdims=True))), 4),
    }


def summary(rows):
    return {
        picture: of_picture([row for row in rows if row["picture"] == picture], EDGE_METHODS) for picture in PICTURES
    }


def of_picture(rows, methods):
    told = {}
    for method in methods:
        near = np.sum([row[method]["near"] for row in rows], axis=0) / (2 * sum(row["rows_in_all"] for row in rows))
        enough = np.flatnonzero(near >= WANTED_FOUND)
        step = int(enough[-1]) if enough.size else 0
        told[method] = {
            "threshold": round(float(THRESHOLDS[step]), 4),
            "limbs_within_3_px": round(float(near[step]), 4),
        }
        for group in dict.fromkeys(_group(row) for row in rows):
            told[method][group] = _of_group([row for row in rows if _group(row) == group], method, step)
    return told


def _group(row):
    return f"line_a {row['scene'].split('_')[1]}" if row["scene"] in RECORDED else row["scene"]


def _of_group(rows, method, step):
    all_rows = sum(row["rows_in_all"] for row in rows)
    of_method = [row[method] for row in rows]
    offsets = np.array([one["offset_px"] for one in of_method])
    return {
        "limbs_within_1_px": round(sum(one["found"][step] for one in of_method) / (2 * all_rows), 4),
        "rows_with_a_false_edge": round(sum(one["false"][step] for one in of_method) / all_rows, 4),
        "bias_px": [round(float(side), 3) for side in offsets.mean(axis=0)],
        "width_bias_px": round(float(np.diff(offsets).mean()), 3),
        "spread_px": round(float(np.mean([one["spread_px"] for one in of_method])), 3),
    }
