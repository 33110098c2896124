"""The diameter on pictures as cameras send them, with a response that is measured from boards and told by nobody."""

from dataclasses import replace

import numpy as np
from camera_rigs import CameraLine
from coded_pictures import CODINGS
from scipy import special

from appliance.simulation.response import encode
from appliance.sizing.trust import trust_percent
from studies.served_diameter import errors, rounded
from vision.calibration.acceptance import CalibrationError
from vision.calibration.response import USUAL_BLUR_PX, USUAL_LIGHT, chosen_response, edge_shift_px
from vision.light import NAMED_RESPONSES, light_of
from vision.sent_picture import SentPicture
from vision.sizing.gauge import Gauge

TEXT = (
    "The gauge as served, both routes, on pictures in the codings that cameras use: each seed has its own rig, board, "
    "calibration and bar (clean, with scale, or with lit rollers), and a camera response of random shape that is "
    "measured from the boards in the same coding; 800 x 600. A seed is sent as PNG and in one group of codings, which "
    "are so compared on the same scenes. Beside it the gauge as it was before: decoded colours of 8 bits, and the best "
    "of the three responses that a user could name. The response: how far half level of a bar's edge is off under it, "
    "its own standard uncertainty, and what is said of one of the three names when board.json tells it. from_png: the "
    "error less that of PNG on the same scenes."
)
SEEDS = 300
SAMPLE = 1  # a seed has four to six codings
CONDITIONS = ("clean", "scale", "rollers")
GROUPS = (
    ("png 12 bit", "mosaic 8 bit", "mosaic 12 bit"),
    ("jpeg 4:4:4 q90", "jpeg 4:2:0 q90", "jpeg 4:2:0 q75"),
    ("png smoothed", "png sharpened", "jpeg 4:2:0 q90 smoothed", "jpeg 4:2:0 q90 sharpened"),
    ("h264 crf 18", "h264 crf 23", "h264 crf 23 10 bit", "h264 crf 23 full range", "h264 crf 28"),
)
LIGHT = np.linspace(0.0, 1.0, 8001)
WRONG_PX = 0.1  # of a bar's edge: a told response that is off by more is to be named


def cases():
    return [{"condition": CONDITIONS[seed % len(CONDITIONS)], "seed": seed} for seed in range(SEEDS)]


def of_seed(seed):
    return "png", *GROUPS[seed % len(GROUPS)]


def run(case):
    line = CameraLine(case["seed"], case["condition"])
    try:
        rig = line.rig
    except CalibrationError:
        return {"truth_mm": rounded(line.diameter_mm), "codings": {}}
    former = Gauge(replace(rig, response=nearest_name(line.response)), 0.0)
    codings = {name: of_coding(line, former, CODINGS[name]) for name in of_seed(case["seed"])}
    return {"truth_mm": rounded(line.diameter_mm), "codings": codings}


def of_coding(line, former, coding):
    pictures, measured = line.sent(coding), line.measured_response(coding)
    reading = Gauge(replace(line.rig, response=measured.curve), 0.0).measure(*pictures)
    before = former.measure(*(SentPicture.of(picture.shown) for picture in pictures))
    return {
        **of_reading(reading, line.diameter_mm),
        "response": of_response(line, measured),
        "before": of_reading(before, line.diameter_mm),
    }


def nearest_name(shape):
    """The response that a user would name at best."""
    return min(NAMED_RESPONSES, key=lambda name: abs(outwards_px(name, shape)))


def outwards_px(decoder, shape):
    """How far a bar's edge moves outwards when light that a camera coded is decoded by a response."""
    decoded = light_of(encode(LIGHT, shape), decoder)
    half = np.interp(np.mean(np.interp(USUAL_LIGHT, LIGHT, decoded)), decoded, LIGHT)
    share = (half - USUAL_LIGHT[0]) / (USUAL_LIGHT[1] - USUAL_LIGHT[0])
    return -USUAL_BLUR_PX * float(special.ndtri(share))


def of_reading(reading, truth_mm):
    result = {"valid": reading.valid, "reasons": reading.reasons.names}
    if reading.valid:
        result |= {
            "error_mm": rounded(reading.diameter_mm - truth_mm),
            "expanded_mm": rounded(reading.expanded_uncertainty_mm),
            "light_mm": rounded(reading.u_light_mm),
            "trust": round(trust_percent(reading), 1),
            "virtual_board_error_mm": _or_none(reading.diameter_virtual_board_mm - truth_mm),
        }
    return result


def of_response(line, measured):
    """Error of half level under the measured response, and what is said of a name that `board.json` might tell."""
    name = NAMED_RESPONSES[line.seed // 9 % len(NAMED_RESPONSES)]
    return {
        "parameters": [rounded(one) for one in measured.curve.parameters],
        "outwards_px": rounded(outwards_px(measured.curve, line.response)),
        "u_px": rounded(edge_shift_px(measured.curve, measured.curve)[1]),
        "told_outwards_px": rounded(outwards_px(name, line.response)),
        "said_outwards_px": rounded(edge_shift_px(name, measured.curve)[0]),
        "contradicted": bool(chosen_response(name, measured).warning),
        "filter": next((kind for kind in ("smooths", "sharpens") if kind in measured.filter), None),
    }


def _or_none(value):
    return rounded(value) if np.isfinite(value) else None


def summary(rows):
    flat = [
        {
            "seed": row["seed"],
            "condition": row["condition"],
            "coding": name,
            "png_error_mm": row["codings"]["png"].get("error_mm"),
            **one,
        }
        for row in rows
        for name, one in row["codings"].items()
    ]
    groups = {"all": flat, **{name: [one for one in flat if one["coding"] == name] for name in CODINGS}}
    groups |= {name: [one for one in flat if one["condition"] == name] for name in CONDITIONS}
    return {
        "rigs": len(rows),
        "calibration_refused": sum(not row["codings"] for row in rows),
        **{name: _of_group(found) for name, found in groups.items()},
    }


def _of_group(rows):
    served = [row for row in rows if row["valid"]]
    before = [{"seed": row["seed"], **row["before"]} for row in rows if row["before"]["valid"]]
    moved = [row["error_mm"] - row["png_error_mm"] for row in served if row["png_error_mm"] is not None]
    virtual = [row["virtual_board_error_mm"] for row in served if row["virtual_board_error_mm"] is not None]
    return {
        "frames": len(rows),
        "availability": rounded(len(served) / len(rows)),
        **errors(served),
        "virtual_board_bias_mm": rounded(np.mean(virtual)),
        "from_png_mean_mm": rounded(np.mean(moved)),
        "from_png_rms_mm": rounded(np.sqrt(np.mean(np.square(moved)))),
        # what a filter does to edges is made up for by a response that is not the camera's own
        "response": _of_responses([row["response"] for row in rows if not CODINGS[row["coding"]].filter]),
        "before": errors(before),
    }


def _of_responses(responses):
    if not responses:
        return {}
    off, u, told, said = (
        np.array([one[key] for one in responses])
        for key in ("outwards_px", "u_px", "told_outwards_px", "said_outwards_px")
    )
    named = np.array([one["contradicted"] for one in responses])
    wrong = np.abs(told) > WRONG_PX
    return {
        "half_level_rmse_px": rounded(np.sqrt(np.mean(off**2))),
        "half_level_bias_px": rounded(np.mean(off)),
        "median_u_px": rounded(np.median(u)),
        "covered": rounded(np.mean(np.abs(off) <= 2 * u)),
        "wrong_responses": int(np.sum(wrong)),
        "wrong_responses_named": int(np.sum(wrong & named)),
        "error_of_the_named_amount_rmse_px": rounded(np.sqrt(np.mean((said - told)[wrong & named] ** 2)))
        if np.any(wrong & named)
        else None,
        "right_responses": int(np.sum(~wrong)),
        "right_responses_named": int(np.sum(~wrong & named)),
    }
