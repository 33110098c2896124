"""The diameter on pictures as cameras send them, with a response that is measured from boards and told by nobody."""

from dataclasses import replace

import numpy as np
from calibrated_rigs import rig_with_marks
from camera_rigs import drawn_setup, measured_response, response_of
from coded_pictures import CODINGS
from scipy import special

from appliance.simulation.response import encode
from appliance.sizing.trust import trust_percent
from studies.served_diameter import errors, rounded
from vision.calibration.acceptance import CalibrationError
from vision.light import NAMED_RESPONSES, ResponseCurve, light_of
from vision.sent_picture import SentPicture
from vision.sizing.gauge import Gauge

TEXT = (
    "The gauge as served, both routes, on pictures in the codings that cameras use: each seed has its own rig, board, "
    "calibration and bar (clean, with scale, or with lit rollers), and a camera response of random shape that is "
    "measured from the boards in the same coding; 800 x 600. Beside it the gauge as it was before: decoded colours of "
    "8 bits, and the best of the three responses that a user could name."
)
SEEDS = 12
CONDITIONS = ("clean", "scale", "rollers")
CODINGS_PER_SEED = 3
NAMES = tuple(CODINGS)


def cases():
    return [
        {"condition": CONDITIONS[seed % len(CONDITIONS)], "seed": seed, "coding": name}
        for seed in range(SEEDS)
        for name in of_seed(seed)
    ]


def of_seed(seed):
    """Every coding as often as any other, in changing company."""
    order = np.random.default_rng([seed // 4, 0x636F]).permutation(len(NAMES))
    return [NAMES[k] for k in order[CODINGS_PER_SEED * (seed % 4) :][:CODINGS_PER_SEED]]


def run(case):
    seed, coding = case["seed"], CODINGS[case["coding"]]
    setup = drawn_setup(seed, case["condition"], coding.bits)
    try:
        rig = rig_with_marks(seed)
    except CalibrationError:
        return {"truth_mm": setup.diameter_mm, "valid": False, "reasons": ["calibration_refused"]}
    pairs = [setup.pair(frame) for frame in range(coding.frames)]
    pictures = [coding.sent([pair[side] for pair in pairs]) for side in (0, 1)]
    measured = measured_response(seed, setup, coding)
    served = told(Gauge(replace(rig, response=measured.curve), 0.0).measure(*pictures), setup.diameter_mm)
    shown = [SentPicture.of(picture.shown) for picture in pictures]
    before = told(
        Gauge(replace(rig, response=nearest_name(setup.sensor.response)), 0.0).measure(*shown), setup.diameter_mm
    )
    return {**served, "before": before, "response": [round(float(one), 4) for one in measured.curve.parameters]}


def nearest_name(shape):
    """The response that a user would name at best: where half the light of a bar has the nearest code value."""
    light = np.array([0.02, 0.46, 0.9])

    def half(response):
        low, middle, high = encode(light, response)
        return (middle - low) / (high - low)

    return min(NAMED_RESPONSES, key=lambda name: abs(half(name) - half(shape)))


def told(reading, truth_mm):
    result = {"truth_mm": round(truth_mm, 4), "valid": reading.valid, "reasons": reading.reasons.names}
    if reading.valid:
        result |= {
            "error_mm": round(reading.diameter_mm - truth_mm, 4),
            "expanded_mm": round(reading.expanded_uncertainty_mm, 4),
            "light_mm": round(reading.u_light_mm, 4),
            "trust": round(trust_percent(reading), 1),
            "virtual_board_error_mm": _or_none(reading.diameter_virtual_board_mm - truth_mm),
        }
    return result


def _or_none(value):
    return round(value, 4) if np.isfinite(value) else None


def summary(rows):
    groups = {"all": NAMES, **{name: (name,) for name in NAMES}}
    return {group: _of_group([row for row in rows if row["coding"] in names]) for group, names in groups.items()}


def _of_group(rows):
    served = [row for row in rows if row["valid"]]
    before = [{"seed": row["seed"], **row["before"]} for row in rows if row.get("before", {}).get("valid")]
    virtual = [row["virtual_board_error_mm"] for row in served if row["virtual_board_error_mm"] is not None]
    return {
        "frames": len(rows),
        "availability": rounded(len(served) / max(1, len(rows))),
        **(errors(served) if served else {}),
        "virtual_board_bias_mm": rounded(np.mean(virtual)) if virtual else None,
        "half_level_rmse_px": rounded(np.sqrt(np.mean([half_level_px(row) ** 2 for row in served])))
        if served
        else None,
        "before": errors(before) if before else {},
    }


def half_level_px(row):
    """How far a bar's edge of 0.8 px blur is off under the response that was measured from the boards."""
    light, bar = np.linspace(0.0, 1.0, 8001), np.array([0.02, 0.9])
    decoded = light_of(encode(light, response_of(row["seed"])), ResponseCurve(*row["response"]))
    half = np.interp(np.mean(np.interp(bar, light, decoded)), decoded, light)
    return 0.8 * special.ndtri((half - bar[0]) / (bar[1] - bar[0]))
