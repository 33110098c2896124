"""One to four bars side by side, each measured; a bar that another one hides has no value."""

import numpy as np
from calibrated_rigs import off_line, off_response, rig_with_marks
from of_rigs import inside_and_standard_error

from appliance.simulation.bars.real_line import several_bars
from studies.served_diameter import rounded
from vision.calibration.acceptance import CalibrationError
from vision.sizing.gauge import Gauge

TEXT = (
    "One to four clean bars side by side, 25 to 50 mm apart, one pair of pictures of each; rigs and calibrations as in "
    "served_diameter, 800 x 600; every rig shows each number of bars. Cameras round their code values once; three bars "
    "are also shown as in served_diameter, where a second table of 8 bits shifts codes by whole numbers. A value "
    "belongs to the bar whose axis is nearest; one that is further than 20 mm from any, or a second one of a bar, is "
    "false. Standard errors count the values of a rig as one draw, since its calibration and response are in all of "
    "them."
)
SEEDS = range(4000, 4064)
TWICE = "3, rounded twice"
SHOWN = ("1", "2", "3", "4", TWICE)
SAMPLE = 1
NEAR_MM = 20.0


def cases():
    return [{"shown": shown, "seed": seed} for seed in SEEDS for shown in SHOWN]


def run(case):
    line = several_bars(case["seed"], _count(case["shown"]))
    try:
        gauge = Gauge(rig_with_marks(case["seed"]), 0.0)
    except CalibrationError:
        return {"refused": True}
    readings = gauge.measure_bars(*_pictures(line, case))
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


def _count(shown):
    return int(shown[0])


def _pictures(line, case):
    if case["shown"] == TWICE:
        return [off_response(picture, case["seed"]) for picture in next(line.pairs(1))]
    return next(off_line(line, case["seed"]).pairs(1))


def summary(rows):
    return {shown: _of_bars([row for row in rows if row["shown"] == shown], _count(shown)) for shown in SHOWN}


def _of_bars(rows, count):
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
