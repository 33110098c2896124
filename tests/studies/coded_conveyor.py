"""The gauge between barriers in the codings of cameras: errors, and whether U holds in each of them."""

from functools import lru_cache

import numpy as np
from coded_pictures import DEEPER_CODINGS, all_sent

from appliance.simulation.foreign_thermal_line import random_foreign_thermal_line
from appliance.simulation.thermal_line import random_thermal_line
from studies.served_diameter import rounded
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

TEXT = (
    "Random thermal lines, walls on a plain floor (own) and barriers over rollers that stand or hang (foreign), each "
    "its own camera, lens, blur, noise and bar: two empty pictures and one with the bar, coded by real coders as grey "
    "in luma, three frames of one stream where the coding is a video's. Given: W, the barriers' height and, for "
    "with_heights, the camera's, off as a tape is (0.05 %, 1 mm, 10 mm), and the response's exponent (0.02). worse: "
    "mean difference of the absolute error from PNG of the same line, with its standard error."
)
LINES = {"own": random_thermal_line, "foreign": random_foreign_thermal_line}
SEEDS = {"own": range(100, 124), "foreign": range(100, 114)}  # factors of the budget were chosen on others, below 40
NAMES = ("png", "png 16 bit", "jpeg 4:2:0 q90", "jpeg 4:2:0 q75", "h264 crf 18", "h264 crf 23", "h264 crf 28")
KNOWN = ("with_heights", "barrier_height")
SPACING_SHARE, BARRIER_MM, CAMERA_MM, EXPONENT = 0.0005, 1.0, 10.0, 0.02
CHUNK = len(NAMES)


def cases():
    return [
        {"line": line, "seed": seed, "coding": name}
        for line, seeds in SEEDS.items()
        for seed in seeds
        for name in NAMES
    ]


@lru_cache(maxsize=1)
def drawn(name, seed):
    line = LINES[name](seed)
    return line, line.pictures(2, 1)


def sent(pictures, coding):
    """All pictures of a camera as they arrive: a grey scene in luma where colours would be subsampled."""
    if coding.kind == "jpeg":
        pictures = [np.repeat(one[:, :, None], 3, axis=2) for one in pictures]
    return all_sent(pictures, coding)


def given(line, seed):
    """What is known of a line, and the exponent of its response, off as a tape is."""
    off = np.random.default_rng([seed, 0x6363]).standard_normal(4)
    spacing_mm = line.spacing_mm * (1 + SPACING_SHARE * off[0])
    height_mm = line.height_mm + BARRIER_MM * off[1]
    camera_mm = float(line.camera.centre_mm[2]) + CAMERA_MM * off[2]
    references = ConveyorReference(spacing_mm, height_mm, camera_mm), ConveyorReference(spacing_mm, height_mm)
    exponent = getattr(line, "exponent", 1.0)
    return dict(zip(KNOWN, references, strict=True)), exponent if exponent == 1.0 else exponent + EXPONENT * off[3]


def run(case):
    line, pictures = drawn(case["line"], case["seed"])
    *empty, shown = sent(pictures, DEEPER_CODINGS[case["coding"]])
    references, exponent = given(line, case["seed"])
    result = {}
    for name, reference in references.items():
        reading = ConveyorGauge(empty, reference, response_exponent=exponent).measure(shown)
        result[name] = {"valid": reading.valid, "reasons": reading.reasons.names}
        if reading.valid:
            error_mm = reading.diameter_mm - line.bar.diameter_mm
            result[name] |= {"error_mm": rounded(error_mm), "expanded_mm": rounded(reading.expanded_uncertainty_mm)}
    return result


def summary(rows):
    return {
        f"{line}, {known}": {name: _of(known, rows, line, name) for name in NAMES} for line in SEEDS for known in KNOWN
    }


def _of(known, rows, line, coding):
    mine, png = (
        {row["seed"]: row[known] for row in rows if row["line"] == line and row["coding"] == one}
        for one in (coding, "png")
    )
    valid = [seed for seed, one in mine.items() if one["valid"]]
    error, expanded = (np.array([mine[seed][key] for seed in valid]) for key in ("error_mm", "expanded_mm"))
    both = [seed for seed in valid if png[seed]["valid"]]
    worse = np.array([abs(mine[seed]["error_mm"]) - abs(png[seed]["error_mm"]) for seed in both])
    return {
        "lines": len(mine),
        "valid": len(valid),
        "rmse_mm": rounded(np.sqrt(np.mean(error**2))),
        "bias_mm": rounded(error.mean()),
        "worst_mm": rounded(np.abs(error).max()),
        "inside": rounded(np.mean(np.abs(error) <= expanded)),
        "median_expanded_mm": rounded(np.median(expanded)),
        "worse": rounded(worse.mean()),
        "u_worse": rounded(worse.std() / np.sqrt(len(worse))),
    }
