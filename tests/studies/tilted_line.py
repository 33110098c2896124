"""Virtual boards turned: both routes on lines that rise against the registration boards, as parallel and as turned."""

import json
import math
from dataclasses import replace

import numpy as np
from calibrated_rigs import off_response

from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.boards import Board as TrueBoard
from appliance.simulation.boards.boards import board_document, observe
from studies.served_diameter import rounded
from vision.calibration.checkerboard import Board
from vision.calibration.stereo import calibrate
from vision.sizing.gauge import Gauge
from vision.sizing.virtual_board.bar_tilt import bar_tilt_deg
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

TEXT = (
    "Bars of the simulated mill on lines that rise by 0, 1, 2 and 5 degrees along y against the registration boards; "
    "each seed its own rig, calibrated by the product from projected corners with detector noise and boards with print "
    "errors; responses off as in `served_diameter`; 800 x 600. `parallel`: route V on boards parallel to those seen; "
    "`turned`: on boards turned by the tilt; `fitted`: by the tilt that the bar itself shows, in two rounds; `served`: "
    "both routes along the line by the tilt that is told, route T's value."
)
TILTS_DEG = (0.0, 1.0, 2.0, 5.0)
CONDITIONS = ("clean", "scale", "haze")
WAYS = ("parallel", "turned", "fitted", "served")
SEEDS = 15
ROUNDS = 2
SAMPLE = 1  # each case measures six times


def cases():
    return [
        {"tilt_deg": tilt, "condition": CONDITIONS[seed % len(CONDITIONS)], "seed": seed}
        for seed in range(SEEDS)
        for tilt in TILTS_DEG
    ]


def run(case):
    seed = case["seed"]
    setup = set_up(case["condition"], seed)
    rig = calibrated(seed, case["tilt_deg"])
    pair = [off_response(picture, seed) for picture in setup.pair()]
    fitted_deg = fitted_tilt_deg(rig, pair)
    readings = {
        "parallel": VirtualBoardGauge(rig).measure(*pair),
        "turned": VirtualBoardGauge(rig.along_line(case["tilt_deg"])).measure(*pair),
        "fitted": VirtualBoardGauge(rig.along_line(np.nan_to_num(fitted_deg))).measure(*pair),
        "served": Gauge(rig.along_line(case["tilt_deg"]), 0.0).measure(*pair),
    }
    told = {way: of_reading(reading, setup.diameter_mm) for way, reading in readings.items()}
    return told | {"fitted_deg": None if np.isnan(fitted_deg) else round(fitted_deg, 4)}


def calibrated(seed, tilt_deg):
    """The rig that is calibrated on boards against which the line rises: the mill's cameras in the boards' frame."""
    setup = set_up("clean", seed)
    sine, cosine = np.sin(np.deg2rad(tilt_deg)), np.cos(np.deg2rad(tilt_deg))
    line_axes = np.array([[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]])
    cameras = [replace(camera, R=camera.R @ line_axes) for camera in setup.rig.cameras]
    true_rig = replace(setup.rig, left=cameras[0], right=cameras[1])
    rng = np.random.default_rng([seed, 0x626F])
    true_board = TrueBoard.with_errors(rng)
    seen = observe(true_rig, rng, true_board)
    board = Board.from_json(json.dumps(board_document(true_board, setup.sensor.response)))
    size, region_y_mm = true_rig.left.image_size, true_rig.region_y_mm
    return calibrate(seen.calibration, seen.low, seen.high, board, size, region_y_mm=region_y_mm).rig


def fitted_tilt_deg(rig, pair):
    for _ in range(ROUNDS):
        gauge = VirtualBoardGauge(rig, edges="sobel")
        gauge.measure(*pair)
        if gauge.last_pair is None:
            return np.nan
        rig = rig.along_line(rig.tilt_deg + np.nan_to_num(bar_tilt_deg(gauge.last_pair)))
    return rig.tilt_deg


def of_reading(reading, truth_mm):
    told = {"valid": reading.valid, "reasons": reading.reasons.names}
    if reading.valid:
        told |= {
            "error_mm": round(reading.diameter_mm - truth_mm, 4),
            "expanded_mm": None
            if math.isnan(reading.expanded_uncertainty_mm)
            else round(reading.expanded_uncertainty_mm, 4),
        }
    return told


def summary(rows):
    return {f"{tilt:g} degrees": of_tilt([row for row in rows if row["tilt_deg"] == tilt]) for tilt in TILTS_DEG}


def of_tilt(rows):
    off_deg = np.array([row["fitted_deg"] - row["tilt_deg"] for row in rows if row["fitted_deg"] is not None])
    fit = {
        "fits": len(off_deg),
        "bias_deg": round(float(off_deg.mean()), 4),
        "rms_deg": round(float(np.sqrt(np.mean(off_deg**2))), 4),
        "worst_deg": round(float(np.abs(off_deg).max()), 4),
    }
    return {way: of_way([row[way] for row in rows]) for way in WAYS} | {"tilt": fit}


def of_way(results):
    """Errors of all values; how often U held, of those that have one."""
    valid = [one for one in results if one["valid"]]
    known = [one for one in valid if one["expanded_mm"] is not None]
    error = np.array([one["error_mm"] for one in valid])
    inside = [abs(one["error_mm"]) <= one["expanded_mm"] for one in known]
    return {
        "frames": len(results),
        "values": len(valid),
        "uncertainty_unknown": len(valid) - len(known),
        "rmse_mm": rounded(np.sqrt(np.mean(error**2))),
        "bias_mm": rounded(error.mean()),
        "bias_standard_error_mm": rounded(error.std() / np.sqrt(len(error))),
        "worst_mm": rounded(np.abs(error).max()),
        "covered": rounded(np.mean(inside)) if known else None,
        "median_expanded_mm": rounded(np.median([one["expanded_mm"] for one in known])) if known else None,
    }
