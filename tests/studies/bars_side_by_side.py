"""One to four bars side by side, each measured; a bar that another one hides has no value."""

import numpy as np
from calibrated_rigs import off_line, rig_with_marks
from of_rigs import inside_and_standard_error

from appliance.simulation.bars.real_line import several_bars
from studies.served_diameter import rounded
from vision.calibration.acceptance import CalibrationError
from vision.sizing.gauge import Gauge

TEXT = (
    "One to four clean bars side by side, 25 to 50 mm apart, one pair of pictures of each; rigs and calibrations as in "
    "served_diameter, but cameras round their code values once; 800 x 600; every rig shows each number of bars. A "
    "value belongs to the bar whose axis is nearest; one that is further than 20 mm from any, or a second one of a "
    "bar, is false. Standard errors count the values of a rig as one draw, since its calibration and response are in "
    "all of them."
)
SEEDS = range(4000, 4080)
COUNTS = (1, 2, 3, 4)
SAMPLE = 2
NEAR_MM = 20.0


def cases():
    return [{"count": count, "seed": seed} for seed in SEEDS for count in COUNTS]


def run(case):
    line = off_line(several_bars(case["seed"], case["count"]), case["seed"])
    try:
        gauge = Gauge(rig_with_marks(case["seed"]), 0.0)
    except CalibrationError:
        return {"refused": True}
    readings = gauge.measure_bars(*next(line.pairs(1)))
    valid = [reading for reading in readings if reading.valid]
    truth = line.setup.bars
    found = [min(truth, key=lambda bar: abs(bar.offset_mm - one.offset_mm)) for one in valid]
    near = [abs(bar.offset_mm - one.offset_mm) <= NEAR_MM for bar, one in zip(found, valid, strict=True)]
    return {
        "refused": False,
        "readings": len(readings),
        "false_values": near.count(False) + len(found) - len({id(bar) for bar in found}),
        "ordered": bool(np.all(np.diff([one.offset_mm for one in valid]) > 0)),
        "error_mm": [rounded(one.diameter_mm - bar.diameter_mm) for bar, one in zip(found, valid, strict=True)],
        "expanded_mm": [rounded(one.expanded_uncertainty_mm) for one in valid],
        "reasons": sorted({name for one in readings for name in one.reasons.names}),
    }


def summary(rows):
    return {str(count): _of_count([row for row in rows if row["count"] == count], count) for count in COUNTS}


def _of_count(rows, count):
    rows = [row for row in rows if not row["refused"]]
    error = np.array([value for row in rows for value in row["error_mm"]])
    expanded = np.array([value for row in rows for value in row["expanded_mm"]])
    return {
        "pairs": len(rows),
        "bars": count * len(rows),
        "values": len(error),
        "false_values": sum(row["false_values"] for row in rows),
        "in_order": sum(row["ordered"] for row in rows),
        "rmse_mm": rounded(np.sqrt(np.mean(error**2))),
        "worst_mm": rounded(np.abs(error).max()),
        **inside_and_standard_error(rows),
        "median_expanded_mm": rounded(np.median(expanded)),
    }
