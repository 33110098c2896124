"""A camera that has turned by 0.02 or 0.05 degrees since its calibration: told by its still marks, and corrected."""

import math
from dataclasses import replace

import numpy as np
from calibrated_rigs import off_line, rig_with_marks
from of_rigs import inside_and_standard_error

from appliance.simulation.bars.real_line import draw_line
from studies.served_diameter import rounded
from vision.calibration.acceptance import CalibrationError
from vision.reasons import Reason
from vision.sizing.gauge import Gauge
from vision.sizing.tangent.gauge import TangentGauge

TEXT = (
    "One camera turned about an axis of random direction through its own centre since the calibration; a clean bar, "
    "the other camera still, one frame; rigs and calibrations as in served_diameter, but cameras round their code "
    "values once; 800 x 600. Uncorrected: the same pictures by a rig without still marks. Told: calibration_due."
)
DEGREES = (0.02, 0.05)
SEEDS = range(5000, 5060)
SAMPLE = 1


def cases():
    return [{"degrees": degrees, "seed": seed} for seed in SEEDS for degrees in DEGREES]


def run(case):
    line = off_line(draw_line(case["seed"], ("nudge",)), case["seed"])
    side, turn = next(iter(line.nudges.items()))
    turn = tuple((case["degrees"] * np.array(turn) / np.linalg.norm(turn)).tolist())
    line = replace(line, nudges={side: turn})
    try:
        rig = rig_with_marks(case["seed"])
    except CalibrationError:
        return {"refused": True}
    pair, truth_mm = next(line.pairs(1)), line.setup.bars[0].diameter_mm
    reading = Gauge(rig, 0.0).measure(*pair)
    blind = TangentGauge(rig, 0.0)  # still marks are not its own
    return {
        "refused": False,
        "marks": min(len(one.patch) for one in rig.marks),
        "told": bool(reading.reasons & (Reason.CALIBRATION_DUE | Reason.CAMERA_MOVED)),
        "error_mm": [_or_none(reading.diameter_mm - truth_mm)],
        "expanded_mm": [_or_none(reading.expanded_uncertainty_mm)],
        "uncorrected_error_mm": _or_none(blind.measure(*pair).diameter_mm - truth_mm),
        "reasons": sorted(reading.reasons.names),
    }


def _or_none(value):
    return rounded(value) if math.isfinite(value) else None


def summary(rows):
    return {str(degrees): _of_turn([row for row in rows if row["degrees"] == degrees]) for degrees in DEGREES}


def _of_turn(rows):
    rows = [row for row in rows if not row["refused"]]
    pairs = [pair for row in rows for pair in zip(row["error_mm"], row["expanded_mm"], strict=True)]
    error, expanded = np.array([pair for pair in pairs if pair[0] is not None]).T
    before = np.array([row["uncorrected_error_mm"] for row in rows if row["uncorrected_error_mm"] is not None])
    return {
        "cameras": len(rows),
        "told": sum(row["told"] for row in rows),
        "served": rounded(len(error) / len(rows)),
        "rmse_mm": rounded(np.sqrt(np.mean(error**2))),
        "worst_mm": rounded(np.abs(error).max()),
        **inside_and_standard_error(rows),
        "median_expanded_mm": rounded(np.median(expanded)),
        "uncorrected_rmse_mm": rounded(np.sqrt(np.mean(before**2))),
        "uncorrected_worst_mm": rounded(np.abs(before).max()),
    }
