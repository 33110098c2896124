"""The thermal line: the dissertation's four experiments, and the gauge with what is known of the line."""

import math
from dataclasses import replace

import numpy as np

from appliance.simulation.thermal_line import random_thermal_line, thermal_camera
from vision.sizing.conveyor.barriers import Barriers
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge
from vision.sizing.conveyor.published_experiments import EXPERIMENTS, experiment

TEXT = (
    "Simulated thermal recordings, each its own camera, barriers and bar; every other bar is 165 mm. Three empty "
    "frames, then four with the bar. What is given is off as a tape is: the barriers' distance by 0.05 %, their height "
    "by 1 mm, the camera's by 10 mm (standard deviations); the experiments get the true distance. deviation: mean over "
    "frames less the truth; rmse (eq. 3.8): of frames around their mean; sigma: mean over frames of the deviation "
    "within one. aside: the same lines, whose camera looks up to 5 degrees across the line. assumed: cameras and "
    "barriers as the method assumes them where it knows nothing."
)
SEEDS = {"line": 75, "aside": 38, "assumed": 38}
EXPERIMENT_SEEDS = 20  # of the first kind of line: those that the dissertation's experiments size too
FRAMES, EMPTY = 4, 3
SOURCE_MM = 165.0
TAPE_SPACING, TAPE_BARRIER_MM, TAPE_CAMERA_MM = 0.0005, 1.0, 10.0


def cases():
    return [{"line": name, "seed": seed} for name, seeds in SEEDS.items() for seed in range(seeds)]


def line_of(name, seed):
    line = random_thermal_line(seed)
    if seed % 2:
        line = replace(line, bar=replace(line.bar, diameter_mm=SOURCE_MM))
    if name == "line":
        return line
    rng = np.random.default_rng([seed, 0x6173])
    _, y, z = line.camera.centre_mm
    roll_deg, aside_deg = rng.uniform(-1, 1), rng.uniform(-5, 5)
    if name == "aside":
        camera = thermal_camera(z, -y, roll_deg, aside_deg)
        return replace(line, camera=replace(camera, K=line.camera.K))
    # the laws of docs/methods/conveyor.md: focal length over width 0.95 +- 0.31, edges -11 to 111 mm high where
    # they are seen, which is at about half of the barriers' height and never below the conveyor
    columns = line.camera.image_size[0]
    focal_px = columns * rng.uniform(0.64, 1.26)
    away_mm = focal_px * rng.uniform(4.4, 5.2)
    camera = thermal_camera(away_mm * z / math.hypot(y, z), away_mm * -y / math.hypot(y, z), roll_deg, aside_deg)
    K = camera.K.copy()
    K[0, 0] = K[1, 1] = focal_px
    return replace(line, camera=replace(camera, K=K), height_mm=rng.uniform(10, 220))


def run(case):
    line = line_of(case["line"], case["seed"])
    pictures = line.pictures(EMPTY, FRAMES if case["line"] == "line" else 1)
    empty, shown = pictures[:EMPTY], pictures[EMPTY:]
    off = np.random.default_rng([case["seed"], 0x7470]).standard_normal(3)
    spacing_mm = line.spacing_mm * (1 + TAPE_SPACING * off[0])
    height_mm = line.height_mm + TAPE_BARRIER_MM * off[1]
    camera_mm = float(line.camera.centre_mm[2]) + TAPE_CAMERA_MM * off[2]
    known = {
        "with_heights": ConveyorReference(spacing_mm, height_mm, camera_mm),
        "barrier_height": ConveyorReference(spacing_mm, height_mm),
        "spacing_only": ConveyorReference(spacing_mm),
    }
    truth_mm = line.bar.diameter_mm
    result = {"truth_mm": round(truth_mm, 4)}
    for name, reference in known.items():
        gauge = ConveyorGauge(empty, reference, response_exponent=1.0)
        reading = gauge.measure(shown[0])
        result[name] = {"valid": reading.valid, "reasons": reading.reasons.names}
        if reading.valid:
            error, expanded = reading.diameter_mm - truth_mm, reading.expanded_uncertainty_mm
            result[name] |= {"error_mm": round(error, 4), "expanded_mm": round(expanded, 4)}
    if not isinstance(gauge.barriers, Barriers) or case["line"] != "line" or case["seed"] >= EXPERIMENT_SEEDS:
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


KNOWN = ("with_heights", "barrier_height", "spacing_only")


def summary(rows):
    told = {name: _known([row for row in rows if row["line"] == name]) for name in SEEDS}
    names = sorted({name for row in rows for name in row if name.startswith("experiment")})
    for name in names:
        found = [row[name] for row in rows if name in row]
        means = {key: round(float(np.mean([one[key] for one in found])), 4) for key in found[0]}
        told[name] = {"recordings": len(found)} | means
    return told


def _known(rows):
    return {name: errors([row[name] | {"truth_mm": row["truth_mm"]} for row in rows]) for name in KNOWN}


def errors(readings):
    """How many lines were measured, how well, and whether U held."""
    valid = [reading for reading in readings if reading["valid"]]
    error, expanded, truth = (
        np.array([one[name] for one in valid]) for name in ("error_mm", "expanded_mm", "truth_mm")
    )
    source = error[truth == SOURCE_MM]
    return {
        "lines": len(readings),
        "valid": len(valid),
        "rmse_mm": _rms(error),
        **({"rmse_at_165_mm": _rms(source)} if source.size else {}),
        "bias_mm": round(float(error.mean()), 4),
        "bias_standard_error_mm": round(float(error.std(ddof=1) / np.sqrt(len(valid))), 4),
        "worst_mm": round(float(np.abs(error).max()), 4),
        "inside": round(float(np.mean(np.abs(error) <= expanded)), 4),
        "median_expanded_mm": round(float(np.median(expanded)), 4),
        "errors_over_twice_expanded": int(np.sum(np.abs(error) > 2 * expanded)),
    }


def _rms(error):
    return round(float(np.sqrt(np.mean(error**2))), 4)
