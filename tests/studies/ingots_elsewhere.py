"""Ends of our own mill's ingots and of others', judged by every classifier: frames, ingots and false alarms."""

import os
import statistics
from dataclasses import replace
from pathlib import Path

import numpy as np
from ingot_truth import counted, recorded, simulated

from appliance.ingot.reader_setup import make_reader
from appliance.ingot.settings import IngotSettings
from vision.ingot.classifiers.classifier import Face
from vision.ingot.classifiers.similarity import as_reference
from vision.ingot.classifiers.table import CLASSIFIERS
from vision.ingot.end_finder import End
from vision.ingot.end_image import end_image

TEXT = (
    "One ingot a line: ends as our mill's (mixed), as other mills' (foreign) and as shaded geometry (cast), drawn from "
    "seeds no classifier was trained on, and the recorded sequences of two further lines. Frames count while an ingot "
    "is placed and its end is found; after 20 placed frames of a simulated ingot every fourth is read. "
    "frames_wrong_expected: the share that the log odds of the frames allow for, beside the share that is wrong. "
    "log_odds: of each kind of end number of frames, mean and standard deviation; correlation: between those of two "
    "frames of one simulated ingot (intraclass correlation, ingots of one kind)."
)
LINES = 100
FIRST_SEED = 12000
SIMULATED = ("mixed", "foreign", "cast")
RECORDED = {"ingot_line": 4, "ingot_line_b": 8}
EARLY_FRAMES = 10
LATER_STEP = 4  # of the frames after the first 20 placed ones, when most ingots are decided
SAMPLE = 1
RECORDINGS = Path(os.environ.get("HOTGAUGE_RECORDINGS", Path(__file__).parents[3] / "shared" / "recordings"))


def cases():
    drawn = [{"line": name, "seed": FIRST_SEED + seed} for seed in range(LINES) for name in SIMULATED]
    return drawn + [{"line": name, "seed": seed} for name, count in RECORDED.items() for seed in range(1, count + 1)]


def run(case):
    name, seed = case["line"], case["seed"]
    scene = recorded(RECORDINGS / name, f"seq{seed:02d}") if name in RECORDED else simulated(seed, name, 1, LATER_STEP)
    references = [as_reference(picture) for picture in (scene.view.references.top, scene.view.references.bottom)]
    reader, seen = None, []
    for picture, sight in scene.frames:
        reader = reader or make_reader(IngotSettings(), scene.view, picture)
        reading = reader.read(picture)
        seen.append((sight, reading, _face(picture, reading)))
    placed = [reading.present for sight, reading, _ in seen if sight.present and sight.state == "placed"]
    told = {classifier: _told(classifier, seen, references) for classifier in CLASSIFIERS}
    return {"placed": len(placed), "found": sum(placed), **told}


def _face(picture, reading):
    if not reading.present:
        return None
    end = End(reading.center_x, reading.center_y, reading.radius, "region")
    return Face(end_image(picture, end), reading.ssim_top, reading.ssim_bottom)


def _told(name, seen, references):
    judge, readings, odds = CLASSIFIERS[name](*references).judge, [], {}
    for sight, reading, face in seen:
        verdict = face and judge(face)
        changes = {"orientation": verdict.orientation, "log_odds": verdict.log_odds} if verdict else {}
        readings.append(replace(reading, **changes))
        if verdict and sight.present and sight.state == "placed":
            odds.setdefault(sight.label, []).append(verdict.log_odds)
    told = counted([sight for sight, _, _ in seen], readings, IngotSettings(classifier=name))
    counts = told["verdicts"][name]
    return {
        "frames": sum(counts.values()),
        "frames_right": sum(counts.get(verdict, 0) for verdict in ("top as top", "bottom as bottom")),
        "frames_wrong_expected": round(sum(float(np.sum(1 / (1 + np.exp(np.abs(of))))) for of in odds.values()), 3),
        "log_odds": {
            label: [len(of), round(float(np.mean(of)), 3), round(float(np.std(of)), 3)] for label, of in odds.items()
        },
        "ingots": told["ingots"],
        "strangers_called_top": sum(orientation == "top" for orientation, _ in told["strangers"]),
    }


def summary(rows):
    lines = {line: [row for row in rows if row["line"] == line] for line in dict.fromkeys(row["line"] for row in rows)}
    lines["all simulated"] = [row for row in rows if row["line"] in SIMULATED]
    return {line: _of_lines(of) for line, of in lines.items()}


def _correlation(rows):
    """Of the frames of one ingot: variance of the ingots' means over the whole variance, each about its kind's mean."""
    kinds = [[row["log_odds"][label] for row in rows if label in row["log_odds"]] for label in ("top", "bottom")]
    between, within = 0.0, 0.0
    for ingots in kinds:
        counts, means, deviations = np.array(ingots).reshape(-1, 3).T
        middle = float(counts @ means / max(counts.sum(), 1))
        between += float(counts @ (means - middle) ** 2)
        within += float(counts @ deviations**2)
    return round(between / (between + within), 3) if between + within else None


def _of_lines(rows):
    placed, found = (sum(row[name] for row in rows) for name in ("placed", "found"))
    ends = {"placed_frames": placed, "ends_found": round(found / placed, 4)}
    return ends | {name: _of([row[name] for row in rows]) for name in CLASSIFIERS}


def _of(rows):
    ingots = [ingot[:2] for row in rows for ingot in row["ingots"]]
    until = [ingot[2] for row in rows for ingot in row["ingots"] if ingot[2] is not None]
    frames = sum(row["frames"] for row in rows)
    return {
        "frames": frames,
        "frames_right": round(sum(row["frames_right"] for row in rows) / frames, 4),
        "frames_wrong_expected": round(sum(row["frames_wrong_expected"] for row in rows) / frames, 4),
        "correlation": _correlation(rows),
        "ingots": len(ingots),
        "median_frames_until_decided": statistics.median(until) if until else None,
        "decided_within_10": sum(frames <= EARLY_FRAMES for frames in until),
        "right": sum(label == decision for label, decision in ingots),
        "undecided": sum(decision == "undecided" for _, decision in ingots),
        "tops_called_bottom": sum(ingot == ["top", "bottom"] for ingot in ingots),
        "false_alarms": sum(ingot == ["bottom", "top"] for ingot in ingots)
        + sum(row["strangers_called_top"] for row in rows),
    }
