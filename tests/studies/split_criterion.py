"""Forests grown by information gain beside forests grown by Gini's impurity, on the terms of the study `edges`."""

from appliance.training.edge_forest import SceneSource, train
from studies import edges, edges_learned
from vision.edges.forest.inference import EdgeDetector
from vision.edges.operators import forest_edges

TEXT = (
    "Whole forests, grown as the shipped one was (60,000 patches a tree from rendered scenes), of three seeds by each "
    "criterion. Pictures and judgement are those of the study `edges_learned`: a forest's one threshold for all scenes "
    "is the highest at which 99 % of all limb rows have an edge within 3 px."
)
REPEATABLE = False  # a forest takes five minutes
CHUNK = 1
CRITERIA = ("gini", "entropy")
SEEDS = 3
PATCHES = 60_000  # of each tree, as the shipped forest had
FIGURES = ("limbs_within_1_px", "rows_with_a_false_edge", "width_bias_px", "spread_px")


def cases():
    return [{"criterion": name, "seed": seed} for seed in range(1, SEEDS + 1) for name in CRITERIA]


def run(case):
    return grown_and_judged(case, PATCHES, edges_learned.cases())


def grown_and_judged(case, patches, pictures):
    forest, record = train(
        SceneSource(), case["seed"], patches, "the study split_criterion", lambda *_: None, criterion=case["criterion"]
    )
    detector = EdgeDetector(forest, threads=1)

    def found(image, _):
        return forest_edges(detector, image)

    rows = [picture | edges.judged(picture, ("forest",), found) for picture in pictures]
    judged = edges.of_picture(rows, ("forest",))["forest"]
    return {"nodes": record.nodes, "processor_s": round(record.cpu_seconds)} | judged


def summary(rows):
    return {name: _of_criterion([row for row in rows if row["criterion"] == name]) for name in CRITERIA}


def _of_criterion(rows):
    """Each figure once for each seed."""
    scenes = [name for name, one in rows[0].items() if isinstance(one, dict)]
    of_forests = {name: [row[name] for row in rows] for name in ("nodes", "processor_s", "threshold")}
    return of_forests | {scene: {name: [row[scene][name] for row in rows] for name in FIGURES} for scene in scenes}
