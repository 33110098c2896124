"""Which end of an ingot faces the line under each condition of the simulated line, and on recordings."""

import math
import os
import statistics
from pathlib import Path

from ingot_truth import CLASSIFIERS, follow, recorded, simulated

from appliance.comparison.confusion import Confusion

TEXT = (
    "Simulated ingot lines at 960 x 540, one ingot each (two where two are in view), judged by the classifier that is "
    "served, and the recorded sequences of two lines. Frames count while an ingot is placed and its whole end lies in "
    "the crop region."
)
LINES = 4
RECORDED = {"ingot_line": 4, "ingot_line_b": 8}
CONDITIONS = (
    "clean", "glare", "overexposed", "drift", "camera-moved", "exposure-changed", "two", "hanging-only", "empty",
    "glare-alone",
)  # fmt: skip
RECORDINGS = Path(os.environ.get("HOTGAUGE_RECORDINGS", Path(__file__).parents[3] / "shared" / "recordings"))


def cases():
    simulated_lines = [{"scene": name, "seed": 1000 + seed} for seed in range(LINES) for name in CONDITIONS]
    return simulated_lines + [
        {"scene": name, "seed": number} for name, count in RECORDED.items() for number in range(1, count + 1)
    ]


def run(case):
    if case["scene"] in RECORDED:
        return follow(recorded(RECORDINGS / case["scene"], f"seq{case['seed']:02d}"))
    return follow(simulated(case["seed"], case["scene"], 2 if case["scene"] == "two" else 1))


def summary(rows):
    scenes = dict.fromkeys(row["scene"] for row in rows)
    return {name: _of_scene([row for row in rows if row["scene"] == name]) for name in scenes}


def _of_scene(rows):
    placed, found = (sum(row[name] for row in rows) for name in ("placed", "found"))
    told = {
        "sequences": len(rows),
        "placed_frames": placed,
        "ends_found": round(found / placed, 4) if placed else None,
        "found_while_not_on_the_line": sum(row["found_elsewhere"] for row in rows),
    }
    return told | {name: _classifier(rows, name) for name in CLASSIFIERS if found} | _ingots(rows)


def _classifier(rows, name):
    counts = {}
    for row in rows:
        for verdict, count in row["verdicts"][name].items():
            counts[verdict.replace(" ", "_")] = counts.get(verdict.replace(" ", "_"), 0) + count
    confusion = Confusion(**counts)
    rates = {"accuracy": confusion.accuracy, "precision": confusion.precision("top"), "recall": confusion.recall("top")}
    return counts | {key: None if math.isnan(value) else round(value, 4) for key, value in rates.items()}


def _ingots(rows):
    ingots = [ingot for row in rows for ingot in row["ingots"]]
    strangers = [stranger for row in rows for stranger in row["strangers"]]
    until = [frames for _, _, frames in ingots if frames is not None]
    return {
        "ingots": len(ingots),
        "right": sum(label == decision for label, decision, _ in ingots),
        "undecided": sum(decision == "undecided" for _, decision, _ in ingots),
        "wrong": sum(decision not in {label, "undecided"} for label, decision, _ in ingots),
        "false_alarms": sum((label, decision) == ("bottom", "top") for label, decision, _ in ingots)
        + sum(orientation == "top" for orientation, _ in strangers),
        "decisions_without_an_ingot": sum(orientation != "undecided" for orientation, _ in strangers),
        "median_frames_until_decided": statistics.median(until) if until else None,
        "decided_within_10": round(sum(frames <= 10 for frames in until) / len(ingots), 4) if ingots else None,
    }
