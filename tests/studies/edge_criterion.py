"""What a forest is worth that was grown by entropy (eq. 2.8 to 2.11) beside one grown by Gini's impurity.

Both of a seed see the same patches, so that they differ by the criterion alone.
"""

import numpy as np
import upright

from appliance.training.edge_forest import train
from appliance.training.edge_scenes import DATA_VERSION, edge_examples
from studies.edges import THRESHOLDS, WANTED_FOUND, _drawn, _judged
from vision.edges.operators import EdgeOptions, detect_edges

TEXT = (
    "Forests of 6,000 patches out of 60 pictures a tree (the shipped one: 60,000 out of 400), judged as in edges.json "
    "on colour pictures of other scenes: at the highest threshold at which 99 % of limb rows have an edge within 3 px. "
    "nodes and seconds: of the training."
)
REPEATABLE = False  # a case trains a forest, minutes of a core
CHUNK = 1
SEEDS, PATCHES, PICTURES = 3, 6_000, 60
CONDITIONS, SCENES = ("clean", "haze", "scale"), 4
FIRST_SCENE = 100  # seeds that no other study of edges draws


class FewScenes:
    """Few examples for each tree, so that a forest is grown in a minute."""

    version, uneven_part = DATA_VERSION, 0.5

    def examples(self, rng):
        return PICTURES, edge_examples(int(rng.integers(1 << 31)), PICTURES)


def cases():
    return [{"seed": seed, "criterion": criterion} for seed in range(1, SEEDS + 1) for criterion in ("gini", "entropy")]


def run(case):
    forest, record = train(FewScenes(), case["seed"], PATCHES, "", lambda *_: None, criterion=case["criterion"])
    options = EdgeOptions(forest=forest)
    scenes = [(name, FIRST_SCENE + scene) for scene in range(SCENES) for name in CONDITIONS]
    judged, rows = {name: [] for name in CONDITIONS}, dict.fromkeys(CONDITIONS, 0)
    for name, scene in scenes:
        setup, pair = _drawn(name, scene)
        for side in ("left", "right"):
            bar = upright.rendered(setup, pair, side)
            judged[name].append(_judged(bar, detect_edges(bar.colour, options)))
            rows[name] += bar.limbs_px.shape[1]
    whole = [one for some in judged.values() for one in some]
    near = np.sum([one["near"] for one in whole], axis=0) / (2 * sum(rows.values()))
    step = int(np.flatnonzero(near >= WANTED_FOUND)[-1])
    return {
        "nodes": record.nodes,
        "seconds": record.cpu_seconds,
        "threshold": round(float(THRESHOLDS[step]), 4),
        "spread_px": round(float(np.mean([one["spread_px"] for one in whole])), 4),
        "rows_with_a_false_edge": {
            name: round(sum(one["false"][step] for one in some) / rows[name], 4) for name, some in judged.items()
        },
    }


def summary(rows):
    """Each criterion's means, and the paired difference entropy less Gini with its standard error over the seeds."""
    told = {}
    for name, of in FIGURES.items():
        gini, entropy = (
            np.array([of(row) for row in rows if row["criterion"] == one], dtype=float) for one in ("gini", "entropy")
        )
        apart = entropy - gini
        told[name] = {
            "gini": round(float(gini.mean()), 4),
            "entropy": round(float(entropy.mean()), 4),
            "difference": round(float(apart.mean()), 4),
            "standard_error": round(float(apart.std(ddof=1) / np.sqrt(apart.size)), 4),
        }
    return told


FIGURES = {
    "nodes": lambda row: row["nodes"],
    "seconds": lambda row: row["seconds"],
    "spread_px": lambda row: row["spread_px"],
    **{f"false, {name}": lambda row, name=name: row["rows_with_a_false_edge"][name] for name in CONDITIONS},
}
