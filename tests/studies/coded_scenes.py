"""Ingots, the thermal line and fused pictures in the codings of cameras, against the same pictures without loss."""

from functools import lru_cache

import numpy as np
from calibrated_rigs import calibrated_rig
from coded_pictures import CODINGS, CameraCoding, through_video
from ingot_truth import Scene, follow, simulated

from appliance.ingot.settings import IngotSettings
from appliance.simulation.bars.study_scenes import draw
from appliance.simulation.thermal_line import random_thermal_line
from appliance.simulation.video_coding import Video
from studies.served_diameter import rounded
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

TEXT = (
    "The same drawn pictures as PNG and in four codings. thermal: the conveyor gauge, heights given, one frame of each "
    "line; ingot: ends found and verdicts right of the frames placed, and ingots right, by the classifier of the "
    "settings, one ingot a line; fused: route V on db4's fused picture, Sobel's edges. worse: mean difference of the "
    "absolute error, or of the share that is wrong, from PNG on the same scenes, with its standard error."
)
SEEDS = {"thermal": 4, "ingot": 1, "fused": 4}
FUSION = "db4"
DEEP_BITS = 16
SAMPLE = 3


def cases():
    return [
        {"scene": scene, "seed": seed, "coding": name}
        for scene, n in SEEDS.items()
        for seed in range(n)
        for name in NAMES
    ]


def deep(pictures):
    """Pictures of 16 bits that show the 8-bit ones: what lies between two codes is drawn at random."""
    rng = np.random.default_rng(pictures[0].size)
    return [(257.0 * one + rng.uniform(-128, 128, one.shape)).clip(0, 65535).astype(np.uint16) for one in pictures]


def shown(pictures, name):
    """All pictures of a camera as they arrive and are shown."""
    coding = CODINGS_USED[name]
    if isinstance(coding.kind, Video):
        return [one.shown for one in through_video(pictures, coding.kind, every=True)]
    if coding.bits == DEEP_BITS:
        pictures = deep(pictures)
    return [coding.sent([one]).shown for one in pictures]


CODINGS_USED = {
    "png": CameraCoding("png"),
    "png 16 bit": CameraCoding("png", bits=DEEP_BITS),
    **{name: CODINGS[name] for name in ("jpeg 4:2:0 q90", "jpeg 4:2:0 q75", "h264 crf 23", "h264 crf 28")},
}
NAMES = tuple(CODINGS_USED)


def run(case):
    return {"thermal": thermal, "ingot": ingot, "fused": fused}[case["scene"]](case["seed"], case["coding"])


def thermal(seed, name):
    line = random_thermal_line(seed)
    *empty, frame = shown(line.pictures(2, 1), name)
    reference = ConveyorReference(line.spacing_mm, line.height_mm, float(line.camera.centre_mm[2]))
    return of_reading(ConveyorGauge(empty, reference).measure(frame), line.bar.diameter_mm)


def of_reading(reading, truth_mm):
    if not reading.valid:
        return {"error_mm": None, "inside": None}
    error_mm = reading.diameter_mm - truth_mm
    return {"error_mm": rounded(error_mm), "inside": bool(abs(error_mm) <= reading.expanded_uncertainty_mm)}


@lru_cache(maxsize=1)
def drawn_ingot(seed):
    scene = simulated(seed, "mixed", 1)
    return scene.view, list(scene.frames)


def ingot(seed, name):
    view, frames = drawn_ingot(seed)
    settings = IngotSettings()
    coded = shown([picture for picture, _ in frames], name)
    counts = follow(Scene(view, zip(coded, [sight for _, sight in frames], strict=True)), settings)
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
    pair = [shown([picture] * (3 if "h264" in name else 1), name)[-1] for picture in (scene.left, scene.right)]
    reading = gauge.measure(*pair)
    error_mm = reading.diameter_mm - scene.truth["diameter_mm"]
    return {"error_mm": rounded(error_mm) if reading.valid else None}


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
    valid = [seed for seed, row in mine.items() if row["error_mm"] is not None]
    both = [seed for seed in valid if png[seed]["error_mm"] is not None]
    error = np.array([mine[seed]["error_mm"] for seed in valid])
    worse = [abs(mine[seed]["error_mm"]) - abs(png[seed]["error_mm"]) for seed in both]
    told = {"frames": len(mine), "valid": len(valid), "rmse_mm": rounded(np.sqrt(np.mean(error**2)))}
    told["bias_mm"] = rounded(error.mean())
    if scene == "thermal":
        told["inside"] = rounded(np.mean([mine[seed]["inside"] for seed in valid]))
    return told | _mean(worse)


def _mean(values):
    return {"worse": rounded(np.mean(values)), "u_worse": rounded(np.std(values) / np.sqrt(len(values)))}
