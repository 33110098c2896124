"""Ends of our own mill's ingots and of others', judged by every classifier: frames, ingots and false alarms."""

import os
import statistics
from dataclasses import replace
from pathlib import Path

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
    "is placed and its end is found."
)
LINES = 5
FIRST_SEED = 5000
SIMULATED = ("mixed", "foreign", "cast")
RECORDED = {"ingot_line": 4, "ingot_line_b": 8}
SAMPLE = 2
RECORDINGS = Path(os.environ.get("HOTGAUGE_RECORDINGS", Path(__file__).parents[3] / "shared" / "recordings"))


def cases():
    drawn = [{"line": name, "seed": FIRST_SEED + seed} for name in SIMULATED for seed in range(LINES)]
    return drawn + [{"line": name, "seed": seed} for name, count in RECORDED.items() for seed in range(1, count + 1)]


def run(case):
    name, seed = case["line"], case["seed"]
    scene = recorded(RECORDINGS / name, f"seq{seed:02d}") if name in RECORDED else simulated(seed, name, 1)
    references = [as_reference(picture) for picture in (scene.view.references.top, scene.view.references.bottom)]
    reader, seen = None, []
    for picture, sight in scene.frames:
        reader = reader or make_reader(IngotSettings(), scene.view, picture)
        reading = reader.read(picture)
        seen.append((sight, reading, _face(picture, reading)))
    return {name: _told(name, seen, references) for name in CLASSIFIERS}


def _face(picture, reading):
    if not reading.present:
        return None
    end = End(reading.center_x, reading.center_y, reading.radius, "region")
    return Face(end_image(picture, end), reading.ssim_top, reading.ssim_bottom)


def _told(name, seen, references):
    judge, readings = CLASSIFIERS[name](*references).judge, []
    for _, reading, face in seen:
        verdict = face and judge(face)
        changes = {"orientation": verdict.orientation, "log_odds": verdict.log_odds} if verdict else {}
        readings.append(replace(reading, **changes))
    told = counted([sight for sight, _, _ in seen], readings, IngotSettings(classifier=name))
    counts = told["verdicts"][name]
    return {
        "frames": sum(counts.values()),
        "frames_right": sum(counts.get(verdict, 0) for verdict in ("top as top", "bottom as bottom")),
        "ingots": told["ingots"],
        "strangers_called_top": sum(orientation == "top" for orientation, _ in told["strangers"]),
    }


def summary(rows):
    lines = {line: [row for row in rows if row["line"] == line] for line in dict.fromkeys(row["line"] for row in rows)}
    return {line: {name: _of([row[name] for row in of]) for name in CLASSIFIERS} for line, of in lines.items()}


def _of(rows):
    ingots = [ingot[:2] for row in rows for ingot in row["ingots"]]
    until = [ingot[2] for row in rows for ingot in row["ingots"] if ingot[2] is not None]
    frames = sum(row["frames"] for row in rows)
    return {
        "frames": frames,
        "frames_right": round(sum(row["frames_right"] for row in rows) / frames, 4),
        "ingots": len(ingots),
        "median_frames_until_decided": statistics.median(until) if until else None,
        "right": sum(label == decision for label, decision in ingots),
        "undecided": sum(decision == "undecided" for _, decision in ingots),
        "tops_called_bottom": sum(ingot == ["top", "bottom"] for ingot in ingots),
        "false_alarms": sum(ingot == ["bottom", "top"] for ingot in ingots)
        + sum(row["strangers_called_top"] for row in rows),
    }
