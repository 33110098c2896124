"""Route T on scenes that each draw their own rig, board, calibration and bar, under every condition of the mill."""

import json
from functools import lru_cache

import numpy as np

from appliance.judging import trust_percent
from appliance.mill.boards import Board as TrueBoard
from appliance.mill.boards import board_document, observe
from appliance.mill.scenes import draw, set_up
from vision.calibration.board import Board
from vision.calibration.stereo import calibrate
from vision.sizing.budget import U_EXPONENT
from vision.sizing.tangent import TangentGauge

TEXT = (
    "Route T, rig calibrated by the product from projected corners with detector noise and boards with print errors; "
    "the cameras' responses are off by an exponent drawn from the budget's own uncertainty; 800 x 600. Each seed shows "
    "a clean bar, one other condition and either an effect that the gauge does not model or nothing to be measured."
)
CONDITIONS = ("scale", "post", "glare", "overexposed", "bar-end", "rollers", "haze")
EFFECTS = ("ovality", "camber", "shimmer", "bounce", "nudged", "jpeg-420")
NOTHING = ("no-bar", "one-blind", "two-bars")
SEEDS = 285
BOOTSTRAPS = 1000


def cases():
    return [{"condition": name, "seed": seed} for seed in range(SEEDS) for name in of_seed(seed)]


def of_seed(seed):
    third = EFFECTS[seed // 2 % len(EFFECTS)] if seed % 2 else NOTHING[seed // 2 % len(NOTHING)]
    return "clean", CONDITIONS[seed % len(CONDITIONS)], third


def run(case):
    name, seed = case["condition"], case["seed"]
    scene = draw("clean", seed, effects=(name,)) if name in EFFECTS else draw(name, seed)
    reading = gauge(seed).measure(*(off_response(picture, seed) for picture in (scene.left, scene.right)))
    truth_mm = scene.truth["diameter_mm"]
    result = {"truth_mm": truth_mm, "valid": reading.valid, "reasons": reading.reasons.names}
    if reading.valid:
        result |= {
            "error_mm": round(reading.diameter_mm - truth_mm, 4) if truth_mm is not None else None,
            "expanded_mm": round(reading.expanded_uncertainty_mm, 4),
            "trust": round(trust_percent(reading), 1),
        }
    return result


def off_response(picture, seed):
    """The picture of a camera whose code values follow light with an exponent that is a little off."""
    exponent = np.random.default_rng([seed, 0x7265]).normal(1, U_EXPONENT)
    return np.rint(255 * (np.arange(256) / 255) ** exponent).astype(np.uint8)[picture]


@lru_cache(maxsize=1)
def gauge(seed):
    setup = set_up("clean", seed)
    rng = np.random.default_rng([seed, 0x626F])
    true_board = TrueBoard.with_errors(rng)
    seen = observe(setup.rig, rng, true_board)
    board = Board.from_json(json.dumps(board_document(true_board, setup.sensor.response)))
    size, region_y_mm = setup.rig.left.image_size, setup.rig.region_y_mm
    return TangentGauge(calibrate(seen.calibration, seen.low, seen.high, board, size, region_y_mm=region_y_mm).rig)


def is_wrong(row):
    """Served as valid although |error| > max(2 U, 1 mm), or although nothing was there to be measured."""
    if not row["valid"]:
        return False
    return row["error_mm"] is None or abs(row["error_mm"]) > max(2 * row["expanded_mm"], 1.0)


def summary(rows):
    conditions = dict.fromkeys(row["condition"] for row in rows)
    return {name: _of_condition([row for row in rows if row["condition"] == name]) for name in conditions}


def _of_condition(rows):
    measurable = [row for row in rows if row["truth_mm"] is not None]
    nothing = [row for row in rows if row["truth_mm"] is None]
    told = {
        "frames": len(measurable),
        "frames_without_a_measurable_bar": len(nothing),
        "wrong_values": sum(map(is_wrong, rows)),
        "values_without_a_measurable_bar": sum(row["valid"] for row in nothing),
    }
    valid = [row for row in measurable if row["valid"]]
    return told | ({"availability": round(len(valid) / len(measurable), 4)} | _errors(valid) if valid else {})


def _errors(rows):
    error = np.array([row["error_mm"] for row in rows])
    expanded = np.array([row["expanded_mm"] for row in rows])
    resampled = error[np.random.default_rng(0).integers(error.size, size=(BOOTSTRAPS, error.size))]
    low, high = np.percentile(np.sqrt(np.mean(resampled**2, axis=1)), [2.5, 97.5])
    return {
        "rmse_mm": round(float(np.sqrt(np.mean(error**2))), 4),
        "rmse_95_mm": [round(float(low), 4), round(float(high), 4)],
        "bias_mm": round(float(error.mean()), 4),
        "bias_standard_error_mm": round(float(error.std(ddof=1) / np.sqrt(error.size)), 4),
        "worst_mm": round(float(np.abs(error).max()), 4),
        "covered": round(float(np.mean(np.abs(error) <= expanded)), 4),
        "covered_by_half_of_it": round(float(np.mean(np.abs(error) <= expanded / 2)), 4),
        "median_expanded_mm": round(float(np.median(expanded)), 4),
    }
