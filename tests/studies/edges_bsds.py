"""Forests on the validation pictures of BSDS500, by the benchmark's rule.

Needs the pictures (HOTGAUGE_BSDS, by default ../shared/bsds500), which may not be shipped, and a forest trained from
them, which may not be either: `hotgauge train-edges --bsds DIR --output FILE`, named by HOTGAUGE_BSDS_MODEL.
"""

import os
from functools import lru_cache
from pathlib import Path

import numpy as np
from edge_evaluation import BoundaryCounts, boundary_counts, boundary_scores
from scipy import io

from appliance.training.edge_forest import bsds_example, bsds_pairs
from vision.edges.forest.inference import EdgeDetector
from vision.edges.forest.model import StructuredForest, shipped_forest
from vision.edges.operators import forest_edges
from vision.edges.thinning import ridges

TEXT = (
    "100 validation pictures, 33 thresholds, edges suppressed within 1 px as the paper's authors do, then thinned; "
    "one-to-one matching of the greatest size within 0.0075 of the diagonal with each person's boundaries. Strength is "
    "twice the share of votes, as OpenCV scales it. `trained` learnt from the training pictures of BSDS500, `shipped` "
    "never saw any."
)
REPEATABLE = False  # the pictures are not everywhere
FORESTS = ("trained", "shipped")
SUPPRESSED_PX = 1
BSDS = Path(os.environ.get("HOTGAUGE_BSDS", Path(__file__).parents[3] / "shared" / "bsds500"))


def cases():
    return [{"picture": picture.stem, "forest": name} for picture, _ in bsds_pairs(BSDS, "val") for name in FORESTS]


def run(case):
    picture, truth = (BSDS / kind / "val" / case["picture"] for kind in ("images", "groundTruth"))
    picture, truth = picture.with_suffix(".jpg"), truth.with_suffix(".mat")
    people = io.loadmat(truth)["groundTruth"][0]
    boundaries = [np.asarray(person["Boundaries"][0, 0], np.bool_) for person in people]
    found = forest_edges(_detector(case["forest"]), bsds_example(picture, truth).image)
    strength = np.minimum(2 * ridges(found.strength, found.normal_rad, SUPPRESSED_PX), 1).astype(np.float32)
    counts = boundary_counts(strength, boundaries)
    return {name: getattr(counts, name).tolist() for name in BoundaryCounts.__slots__}


@lru_cache(maxsize=2)
def _detector(name):
    forest = shipped_forest() if name == "shipped" else StructuredForest.load(os.environ["HOTGAUGE_BSDS_MODEL"])
    return EdgeDetector(forest, threads=1)


def summary(rows):
    told = {}
    for name in FORESTS:
        counts = [
            BoundaryCounts(*(np.array(row[field]) for field in BoundaryCounts.__slots__))
            for row in rows
            if row["forest"] == name
        ]
        scores = boundary_scores(counts)
        told[name] = {field: round(getattr(scores, field), 4) for field in ("ods", "ods_threshold", "ois", "ap")}
    return told
