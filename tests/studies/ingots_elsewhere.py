"""Ends of our own mill's ingots and of others', judged by every classifier: frames, ingots and false alarms."""

import os
from pathlib import Path

from ingot_truth import follow, recorded, simulated

from appliance.ingot.settings import IngotSettings

TEXT = (
    "One ingot a line: ends as our mill's (mixed) and as other mills' (foreign), drawn from seeds no classifier was "
    "trained on, and the recorded sequences of two further lines. Frames count while an ingot is placed and its end "
    "is found."
)
LINES = 8
FIRST_SEED = 5000
RECORDED = {"ingot_line": 4, "ingot_line_b": 8}
CLASSIFIERS = ("relief", "wrinkles", "dual", "single")
SAMPLE = 1
RECORDINGS = Path(os.environ.get("HOTGAUGE_RECORDINGS", Path(__file__).parents[3] / "shared" / "recordings"))


def cases():
    drawn = [{"line": name, "seed": FIRST_SEED + seed} for name in ("mixed", "foreign") for seed in range(LINES)]
    return drawn + [{"line": name, "seed": seed} for name, count in RECORDED.items() for seed in range(1, count + 1)]


def run(case):
    name, seed = case["line"], case["seed"]
    scene = recorded(RECORDINGS / name, f"seq{seed:02d}") if name in RECORDED else simulated(seed, name, 1)
    scene = scene._replace(frames=list(scene.frames))
    result = {}
    for classifier in CLASSIFIERS:
        told = follow(scene, IngotSettings(classifier=classifier))
        counts = told["verdicts"][classifier]
        right = sum(count for verdict, count in counts.items() if verdict in {"top as top", "bottom as bottom"})
        result[classifier] = {
            "frames": sum(counts.values()),
            "frames_right": right,
            "ingots": [ingot[:2] for ingot in told["ingots"]],
            "strangers_called_top": sum(orientation == "top" for orientation, _ in told["strangers"]),
        }
    return result


def summary(rows):
    lines = {line: [row for row in rows if row["line"] == line] for line in dict.fromkeys(row["line"] for row in rows)}
    return {line: {name: _of([row[name] for row in of]) for name in CLASSIFIERS} for line, of in lines.items()}


def _of(rows):
    ingots = [ingot for row in rows for ingot in row["ingots"]]
    frames = sum(row["frames"] for row in rows)
    return {
        "frames": frames,
        "frames_right": round(sum(row["frames_right"] for row in rows) / frames, 4),
        "ingots": len(ingots),
        "right": sum(label == decision for label, decision in ingots),
        "undecided": sum(decision == "undecided" for _, decision in ingots),
        "tops_called_bottom": sum(ingot == ["top", "bottom"] for ingot in ingots),
        "false_alarms": sum(ingot == ["bottom", "top"] for ingot in ingots)
        + sum(row["strangers_called_top"] for row in rows),
    }
