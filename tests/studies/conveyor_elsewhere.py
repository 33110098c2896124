"""Thermal lines as other makers build them: how many are measured, how well, and whether U holds."""

from dataclasses import replace

import numpy as np

from appliance.simulation.foreign_thermal_line import random_foreign_thermal_line
from appliance.simulation.thermal_line import thermal_camera
from studies.conveyor import TAPE_BARRIER_MM, TAPE_CAMERA_MM, TAPE_SPACING, errors
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

TEXT = (
    "Lines of other makers, each its own camera, lens, bar and barriers. rollers: over rollers whose ends show, "
    "barriers standing or hanging. plain: barriers that hang over a floor on which no rollers show. faces: as rollers, "
    "every other over a plain floor, but faces of any light between the floor's and the top's, and cameras that look "
    "up to 5 degrees across the line. Two empty pictures, or none where the name says so. What is given is off as "
    "a tape is: the barriers' distance by 0.05 %, their heights by 1 mm, the camera's by 10 mm, and the response's "
    "exponent by 0.02 (deviations); it is not given where the name says so. Whether barriers hang is given in "
    "lower_edge_given alone."
)
SEEDS = {  # the method was made on others, below 100
    "rollers": range(200, 320),
    "plain": range(400, 430),
    "faces": range(500, 590),
}
ASIDE_DEG = 5.0
LOWER_SHARE = (0.3, 0.7)  # of the barriers' height, of those that hang over a plain floor
EXPONENT = 0.02
SAMPLE = 1


def cases():
    return [{"line": name, "seed": seed} for name, seeds in SEEDS.items() for seed in seeds]


def line_of(name, seed):
    line = random_foreign_thermal_line(seed)
    if name == "rollers":
        return line
    if name == "faces":
        return of_any_face(line, seed)
    lower = np.random.default_rng([seed, 0x706C]).uniform(*LOWER_SHARE)
    return replace(line, roller_light=line.floor_light, lower_mm=lower * line.height_mm)


def of_any_face(line, seed):
    rng = np.random.default_rng([seed, 0x6661])
    _, y, z = line.camera.centre_mm
    turned = thermal_camera(z, -y, rng.uniform(-1.5, 1.5), rng.uniform(-ASIDE_DEG, ASIDE_DEG))
    return replace(
        line,
        camera=replace(line.camera, R=turned.R, t=turned.t),
        face_light=rng.uniform(line.floor_light, line.top_light),
        roller_light=line.floor_light if seed % 2 else line.roller_light,
    )


def run(case):
    line = line_of(case["line"], case["seed"])
    *empty, shown = line.pictures(2, 1)
    off = np.random.default_rng([case["seed"], 0x6674]).standard_normal(5)
    spacing_mm = line.spacing_mm * (1 + TAPE_SPACING * off[0])
    height_mm = line.height_mm + TAPE_BARRIER_MM * off[1]
    camera_mm = float(line.camera.centre_mm[2]) + TAPE_CAMERA_MM * off[2]
    exponent = line.exponent + EXPONENT * off[3]
    lower_mm = max(line.lower_mm + TAPE_BARRIER_MM * off[4], 0.0) if line.lower_mm else 0.0
    both = ConveyorReference(spacing_mm, height_mm)
    ways = {
        "lower_edge_given": (empty, ConveyorReference(spacing_mm, height_mm, camera_mm, lower_mm), exponent),
        "with_heights": (empty, ConveyorReference(spacing_mm, height_mm, camera_mm), exponent),
        "barrier_height": (empty, both, exponent),
        "barrier_height_without_an_empty_picture": ([shown], both, exponent),
        "spacing_only": (empty, ConveyorReference(spacing_mm), exponent),
        "barrier_height_response_not_given": (empty, both, None),
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
    ways = [name for name in rows[0] if name not in {"line", "seed", "truth_mm"}]
    return {
        line: {
            name: errors([row[name] | {"truth_mm": row["truth_mm"]} for row in rows if row["line"] == line])
            for name in ways
        }
        for line in SEEDS
    }
