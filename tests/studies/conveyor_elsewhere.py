"""Thermal lines as other makers build them: how many are measured, how well, and whether U holds."""

import numpy as np

from appliance.simulation.foreign_thermal_line import random_foreign_thermal_line
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

TEXT = (
    "Lines over rollers, each its own camera, lens, rollers, bar and barriers, standing or hanging. "
    "Two empty pictures, or none where the name says so. What is given is off as a tape is: the barriers' distance "
    "by 0.05 %, their height by 1 mm, the camera's by 10 mm, and the response's exponent by 0.02 (deviations); "
    "it is not given where the name says so. Whether barriers hang is not given."
)
LINES = 24
SPACING_SHARE, BARRIER_MM, CAMERA_MM, EXPONENT = 0.0005, 1.0, 10.0, 0.02
SAMPLE = 1


def cases():
    return [{"seed": seed} for seed in range(LINES)]


def run(case):
    line = random_foreign_thermal_line(case["seed"])
    *empty, shown = line.pictures(2, 1)
    off = np.random.default_rng([case["seed"], 0x6674]).standard_normal(4)
    spacing_mm = line.spacing_mm * (1 + SPACING_SHARE * off[0])
    height_mm = line.height_mm + BARRIER_MM * off[1]
    camera_mm = float(line.camera.centre_mm[2]) + CAMERA_MM * off[2]
    exponent = line.exponent + EXPONENT * off[3]
    both = ConveyorReference(spacing_mm, height_mm)
    ways = {
        "with_heights": (empty, ConveyorReference(spacing_mm, height_mm, camera_mm), exponent),
        "barrier_height": (empty, both, exponent),
        "barrier_height_without_an_empty_picture": ([shown], both, exponent),
        "spacing_only": (empty, ConveyorReference(spacing_mm), exponent),
        "barrier_height_response_not_given": (empty, both, 1.0),
    }
    result = {"truth_mm": round(line.bar.diameter_mm, 4)}
    for name, (pictures, reference, told) in ways.items():
        reading = ConveyorGauge(pictures, reference, response_exponent=told).measure(shown)
        result[name] = {"valid": reading.valid, "reasons": reading.reasons.names}
        if reading.valid:
            error_mm, expanded_mm = reading.diameter_mm - line.bar.diameter_mm, reading.expanded_uncertainty_mm
            result[name] |= {"error_mm": round(error_mm, 4), "expanded_mm": round(expanded_mm, 4)}
    return result


def summary(rows):
    return {name: _of([row[name] for row in rows]) for name in rows[0] if name not in {"seed", "truth_mm"}}


def _of(readings):
    valid = [reading for reading in readings if reading["valid"]]
    error, expanded = (np.array([reading[name] for reading in valid]) for name in ("error_mm", "expanded_mm"))
    return {
        "lines": len(readings),
        "valid": len(valid),
        "rmse_mm": round(float(np.sqrt(np.mean(error**2))), 3),
        "bias_mm": round(float(np.mean(error)), 3),
        "worst_mm": round(float(np.max(np.abs(error))), 3),
        "within_expanded": round(float(np.mean(np.abs(error) <= expanded)), 4),
        "median_expanded_mm": round(float(np.median(expanded)), 3),
        "errors_over_twice_expanded": int(np.sum(np.abs(error) > 2 * expanded)),
    }
