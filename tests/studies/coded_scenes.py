"""Ingots and fused pictures in the codings of cameras, against the same pictures without loss."""

import math
from functools import lru_cache

import numpy as np
from calibrated_rigs import calibrated_rig
from coded_pictures import DEEPER_CODINGS, all_sent
from ingot_truth import Scene, follow, simulated

from appliance.ingot.settings import IngotSettings
from appliance.simulation.bars.study_scenes import draw
from studies.served_diameter import rounded
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

TEXT = (
    "The same drawn pictures as PNG and in other codings. ingot: ends found and verdicts right of the frames placed, "
    "and ingots right, by the classifier of the settings, one ingot a line; fused: route V on db4's fused picture, "
    "Sobel's edges. worse: mean difference of the absolute error, or of the share that is wrong, from PNG on the same "
    "scenes, with its standard error."
)
SEEDS = {"ingot": 2, "fused": 9}
NAMES = ("png", "png 16 bit", "jpeg 4:2:0 q90", "jpeg 4:2:0 q75", "h264 crf 18", "h264 crf 23", "h264 crf 28")
FUSION = "db4"
SAMPLE = 1


def cases():
    return [
        {"scene": scene, "seed": seed, "coding": name}
        for scene, n in SEEDS.items()
        for seed in range(n)
        for name in NAMES
    ]


def run(case):
    return {"ingot": ingot, "fused": fused}[case["scene"]](case["seed"], case["coding"])


@lru_cache(maxsize=1)
def drawn_ingot(seed):
    scene = simulated(seed, "mixed", 1)
    return scene.view, list(scene.frames)


def ingot(seed, name):
    view, frames = drawn_ingot(seed)
    settings = IngotSettings()
    coded = all_sent([picture for picture, _ in frames], DEEPER_CODINGS[name])
    shown = ((one.shown, sight) for one, (_, sight) in zip(coded, frames, strict=True))
    counts = follow(Scene(view, shown), settings)
    verdicts = counts["verdicts"][settings.classifier]
    return {
        "placed": counts["placed"],
        "found": counts["found"],
        "right": sum(count for said, count in verdicts.items() if len(set(said.split(" as "))) == 1),
        "ingots": len(counts["ingots"]),
        "ingots_right": sum(label == decision for label, decision, _ in counts["ingots"]),
    }


@lru_cache(maxsize=1)
def drawn_bar(seed):
    scene = draw(("clean", "scale", "haze")[seed % 3], seed)
    return scene, VirtualBoardGauge(calibrated_rig(seed), edges="sobel", fusion=FUSION)


def fused(seed, name):
    scene, gauge = drawn_bar(seed)
    coding = DEEPER_CODINGS[name]
    pair = [all_sent([picture] * coding.frames, coding)[-1] for picture in (scene.left, scene.right)]
    gauge.resume((math.nan, math.nan))  # each coding as if no picture had come before
    reading = gauge.measure(*pair)
    return {"error_mm": rounded(reading.diameter_mm - scene.truth["diameter_mm"]) if reading.valid else None}


def summary(rows):
    return {scene: {name: _of(scene, name, rows) for name in NAMES} for scene in SEEDS}


def _of(scene, name, rows):
    mine, png = (
        {row["seed"]: row for row in rows if row["scene"] == scene and row["coding"] == one} for one in (name, "png")
    )
    if scene == "ingot":
        placed, right = (np.array([row[key] for row in mine.values()]) for key in ("placed", "right"))
        worse = [(png[seed]["right"] - row["right"]) / row["placed"] for seed, row in mine.items() if row["placed"]]
        return {
            "frames": int(placed.sum()),
            "right": rounded(right.sum() / placed.sum()),
            "ingots": sum(row["ingots"] for row in mine.values()),
            "ingots_right": sum(row["ingots_right"] for row in mine.values()),
            **_mean(worse),
        }
    values = {seed: row for seed, row in mine.items() if row["error_mm"] is not None}
    error = np.array([row["error_mm"] for row in values.values()])
    both = [seed for seed in values if png[seed]["error_mm"] is not None]
    return {
        "frames": len(mine),
        "values": len(values),
        "rmse_mm": rounded(np.sqrt(np.mean(error**2))),
        "bias_mm": rounded(error.mean()),
        **_mean([abs(mine[seed]["error_mm"]) - abs(png[seed]["error_mm"]) for seed in both]),
    }


def _mean(values):
    return {"worse": rounded(np.mean(values)), "u_worse": rounded(np.std(values) / np.sqrt(len(values)))}
