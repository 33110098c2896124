"""The served diameter on scenes that each draw their own rig, board, calibration and bar, under every condition."""

import math

import numpy as np
from calibrated_rigs import off_response, rig_with_marks
from coded_pictures import CODINGS

from appliance.simulation.bars.study_scenes import draw
from appliance.sizing.trust import trust_percent
from vision.calibration.acceptance import CalibrationError
from vision.sizing.gauge import Gauge

TEXT = (
    "The gauge as served, both routes and still marks; rig calibrated by the product from projected corners with "
    "detector noise and boards with print errors; the cameras' responses are off by an exponent drawn from the "
    "budget's own uncertainty; the ovality is told as 0; 800 x 600. Each seed shows a clean bar, one other condition "
    "and one effect; jpeg 4:2:0 q90 is sent and read as a camera's. A rig whose calibration is refused gives no value."
)
CONDITIONS = ("scale", "post", "glare", "overexposed", "bar-end", "rollers", "haze")
SENT = "jpeg 4:2:0 q90"
EFFECTS = ("ovality", "camber", "shimmer", "bounce", "nudged", SENT)
BARS = ("clean", *CONDITIONS)
SEEDS = 120
BOOTSTRAPS = 1000


def cases():
    return [{"condition": name, "seed": seed} for seed in range(SEEDS) for name in of_seed(seed)]


def of_seed(seed):
    return "clean", CONDITIONS[seed % len(CONDITIONS)], EFFECTS[seed % len(EFFECTS)]


def run(case):
    name, seed = case["condition"], case["seed"]
    scene = draw(name, seed) if name in BARS else draw("clean", seed, effects=() if name == SENT else (name,))
    pictures = [off_response(picture, seed) for picture in (scene.left, scene.right)]
    if name == SENT:
        pictures = [CODINGS[SENT].sent([picture]) for picture in pictures]
    try:
        gauge = Gauge(rig_with_marks(seed), 0.0)
    except CalibrationError:  # a board that is off by more than it says is refused, as it should be
        return {"truth_mm": scene.truth["diameter_mm"], "valid": False, "reasons": ["calibration_refused"]}
    return told(gauge.measure(*pictures), scene.truth["diameter_mm"])


def told(reading, truth_mm):
    """What a study keeps of a reading; its error is None where nothing was to be measured."""
    result = {"truth_mm": truth_mm, "valid": reading.valid, "reasons": reading.reasons.names}
    if reading.valid:
        result |= {
            "error_mm": error_mm(reading.diameter_mm, truth_mm),
            "expanded_mm": round(reading.expanded_uncertainty_mm, 4),
            "trust": round(trust_percent(reading), 1),
            "virtual_board_error_mm": error_mm(reading.diameter_virtual_board_mm, truth_mm),
        }
    return result


def error_mm(value_mm, truth_mm):
    return round(value_mm - truth_mm, 4) if truth_mm is not None and math.isfinite(value_mm) else None


def is_wrong(row):
    """Served as valid although |error| > max(2 U, 1 mm), or although nothing was there to be measured."""
    if not row["valid"]:
        return False
    return row["error_mm"] is None or abs(row["error_mm"]) > max(2 * row["expanded_mm"], 1.0)


def summary(rows):
    groups = {"bars": BARS, "effects": EFFECTS}
    groups |= {name: (name,) for name in (*BARS, *EFFECTS)}
    return {group: _of_group([row for row in rows if row["condition"] in names]) for group, names in groups.items()}


def _of_group(rows):
    measurable = [row for row in rows if row["truth_mm"] is not None]
    nothing = [row for row in rows if row["truth_mm"] is None]
    valid = [row for row in measurable if row["valid"]]
    return {
        "frames": len(measurable),
        "availability": round(len(valid) / len(measurable), 4),
        "wrong_values": sum(map(is_wrong, rows)),
        "frames_without_a_measurable_bar": len(nothing),
        "values_without_a_measurable_bar": sum(row["valid"] for row in nothing),
        "routes_disagree": round(float(np.mean(["routes_disagree" in row["reasons"] for row in valid])), 4),
        "calibration_due": round(float(np.mean(["calibration_due" in row["reasons"] for row in valid])), 4),
        **errors(valid),
    }


def errors(rows):
    """Statistics of rows with values; intervals by bootstrap over the rigs, standard errors over them."""
    error = np.array([row["error_mm"] for row in rows])
    expanded = np.array([row["expanded_mm"] for row in rows])
    virtual = np.array([row["virtual_board_error_mm"] for row in rows if row["virtual_board_error_mm"] is not None])
    rig = np.unique([row["seed"] for row in rows], return_inverse=True)[1]
    count, total, square, inside = (
        np.bincount(rig, values) for values in (np.ones(len(error)), error, error**2, np.abs(error) <= expanded)
    )
    drawn = np.random.default_rng(0).integers(len(count), size=(BOOTSTRAPS, len(count)))
    low, high = np.percentile(np.sqrt(square[drawn].sum(axis=1) / count[drawn].sum(axis=1)), [2.5, 97.5])
    return {
        "rmse_mm": rounded(np.sqrt(np.mean(error**2))),
        "rmse_95_mm": [rounded(low), rounded(high)],
        "bias_mm": rounded(error.mean()),
        "bias_standard_error_mm": rounded((total[drawn].sum(axis=1) / count[drawn].sum(axis=1)).std()),
        "worst_mm": rounded(np.abs(error).max()),
        "covered": rounded(np.mean(np.abs(error) <= expanded)),
        "covered_standard_error": rounded((inside[drawn].sum(axis=1) / count[drawn].sum(axis=1)).std()),
        "covered_by_half_of_it": rounded(np.mean(np.abs(error) <= expanded / 2)),
        "median_expanded_mm": rounded(np.median(expanded)),
        "virtual_board_values": len(virtual),
        "virtual_board_rmse_mm": rounded(np.sqrt(np.mean(virtual**2))) if len(virtual) else None,
        "virtual_board_worst_mm": rounded(np.abs(virtual).max()) if len(virtual) else None,
    }


def rounded(value):
    return round(float(value), 4)
