"""The thermal line: the dissertation's four experiments, and the gauge with and without the camera's height."""

from dataclasses import replace

import numpy as np

from appliance.mill.thermal import random_thermal_line
from vision.calibration.conveyor import Barriers
from vision.calibration.conveyor_view import ConveyorReference
from vision.sizing.conveyor import ConveyorGauge
from vision.sizing.conveyor_experiments import EXPERIMENTS, experiment

TEXT = (
    "Simulated thermal recordings, each its own camera, barriers and bar; every other bar is 165 mm. Three empty "
    "frames, then four with the bar. deviation: mean over frames less the truth; rmse (eq. 3.8): of frames around "
    "their mean; sigma: mean over frames of the deviation within one."
)
SEEDS = 200
FRAMES, EMPTY = 4, 3
SOURCE_MM = 165.0


def cases():
    return [{"seed": seed} for seed in range(SEEDS)]


def run(case):
    line = random_thermal_line(case["seed"])
    if case["seed"] % 2:
        line = replace(line, bar=replace(line.bar, diameter_mm=SOURCE_MM))
    pictures = line.pictures(EMPTY, FRAMES)
    empty, shown = pictures[:EMPTY], pictures[EMPTY:]
    camera_mm = float(line.camera.centre_mm[2])
    known = {
        "with_heights": ConveyorReference(line.spacing_mm, line.height_mm, camera_mm),
        "barrier_height": ConveyorReference(line.spacing_mm, line.height_mm),
        "spacing_only": ConveyorReference(line.spacing_mm),
    }
    truth_mm = line.bar.diameter_mm
    result = {"truth_mm": round(truth_mm, 4)}
    for name, reference in known.items():
        gauge = ConveyorGauge(empty, reference)
        reading = gauge.measure(shown[0])
        result[name] = {"valid": reading.valid, "reasons": reading.reasons.names}
        if reading.valid:
            error, expanded = reading.diameter_mm - truth_mm, reading.expanded_uncertainty_mm
            result[name] |= {"error_mm": round(error, 4), "expanded_mm": round(expanded, 4)}
    if not isinstance(gauge.barriers, Barriers):
        return result
    for number in EXPERIMENTS:
        for way in ("averaged", "fitted") if number in {2, 4} else ("averaged",):
            frames = [experiment(number, picture, gauge.barriers, line.spacing_mm, way) for picture in shown]
            if min(map(len, frames)):
                result[f"experiment_{number}" + ("_fitted" if way == "fitted" else "")] = _told(frames, truth_mm)
    return result


def _told(frames, truth_mm):
    means = np.array([frame.mean() for frame in frames])
    return {
        "deviation_mm": round(float(means.mean() - truth_mm), 4),
        "rmse_mm": round(float(means.std()), 4),
        "sigma_mm": round(float(np.mean([frame.std() for frame in frames])), 4),
    }


def summary(rows):
    told = {}
    for name in ("with_heights", "barrier_height", "spacing_only"):
        valid = [row[name] | {"truth_mm": row["truth_mm"]} for row in rows if row[name]["valid"]]
        error = np.array([one["error_mm"] for one in valid])
        expanded = np.array([one["expanded_mm"] for one in valid])
        source = np.array([one["error_mm"] for one in valid if one["truth_mm"] == SOURCE_MM])
        told[name] = {
            "frames": len(rows),
            "valid": len(valid),
            "rmse_mm": round(float(np.sqrt(np.mean(error**2))), 4),
            "rmse_at_165_mm": round(float(np.sqrt(np.mean(source**2))), 4),
            "bias_mm": round(float(error.mean()), 4),
            "worst_mm": round(float(np.abs(error).max()), 4),
            "covered": round(float(np.mean(np.abs(error) <= expanded)), 4),
            "median_expanded_mm": round(float(np.median(expanded)), 4),
            "wrong_values": int(np.sum(np.abs(error) > np.maximum(2 * expanded, 1.0))),
        }
    names = sorted({name for row in rows for name in row if name.startswith("experiment")})
    for name in names:
        found = [row[name] for row in rows if name in row]
        means = {key: round(float(np.mean([one[key] for one in found])), 4) for key in found[0]}
        told[name] = {"recordings": len(found)} | means
    return told
