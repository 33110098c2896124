"""A passing bar with what a real line adds, alone and together: single frames and the bar's value."""

import math

import numpy as np
from calibrated_rigs import off_response, rig_with_marks

from appliance.simulation.bars.real_line import FRAME_PERIOD_MS, draw_line
from studies.served_diameter import rounded
from vision.calibration.acceptance import CalibrationError
from vision.sizing.gauge import Gauge
from vision.sizing.passing_bar import PassingBar

TEXT = (
    "Each seed is a line of its own: rig, board, calibration, bar, and effects of random size, one, several or none; "
    "5 frames at 25 a second, 800 x 600. Truth is the mean diameter. Every other line's ovality is set (0.8 % of the "
    "diameter where sections are out of round, else 0); the others leave it unset. The bar's value is that of the last "
    "frame. Sizes of the effects: appliance/simulation/bars/real_line.py."
)
SEEDS = range(3000, 3500)
FRAMES = 5
SAMPLE = 1
PRODUCT_OVALITY_SHARE = 0.008


def cases():
    return [{"seed": seed} for seed in SEEDS]


def run(case):
    seed = case["seed"]
    return measured(draw_line(seed), seed, FRAMES)


def product_ovality_mm(line, seed):
    """What the mill says of its product; None if it says nothing."""
    if seed % 2:
        return None
    return PRODUCT_OVALITY_SHARE * line.setup.bars[0].diameter_mm if "oval" in line.effects else 0.0


def measured(line, seed, frames):
    """What single frames and the bar's value of a line are worth."""
    truth_mm = line.setup.bars[0].diameter_mm
    row = {"effects": list(line.effects), "truth_mm": rounded(truth_mm), "frames": frames}
    told_mm = product_ovality_mm(line, seed)
    try:
        gauge = Gauge(rig_with_marks(seed), told_mm)
    except CalibrationError:
        return row | {"refused": True, "ovality_told": told_mm is not None}
    bar, readings = PassingBar(), []
    for frame, pair in enumerate(line.pairs(frames)):
        reading = gauge.measure(*(off_response(picture, seed) for picture in pair))
        readings.append(bar.add(reading, frame * FRAME_PERIOD_MS / 1000))
    return row | {"refused": False, "ovality_told": told_mm is not None} | told(readings, truth_mm)


def told(readings, truth_mm):
    def list_of(name, truth=0.0):
        return [none(getattr(reading, name) - truth) for reading in readings]

    return {
        "reasons": sorted({name for reading in readings for name in reading.reasons.names}),
        "error_mm": list_of("diameter_mm", truth_mm),
        "expanded_mm": list_of("expanded_uncertainty_mm"),
        "bar_error_mm": list_of("bar_diameter_mm", truth_mm)[-1],
        "bar_expanded_mm": list_of("bar_expanded_uncertainty_mm")[-1],
        "virtual_board_error_mm": list_of("diameter_virtual_board_mm", truth_mm),
        "u_mm": {
            part: none(np.nanmean([getattr(reading, f"u_{part}_mm") for reading in readings]))
            for part in ("edge", "calibration", "board", "light", "shape", "model", "motion")
        }
        if any(reading.valid for reading in readings)
        else None,
        "wander_px": none(np.nanmean([reading.wander_px for reading in readings])) if readings[0].valid else None,
    }


def none(value):
    return rounded(value) if math.isfinite(value) else None


def summary(rows):
    names = sorted({name for row in rows for name in row["effects"]})
    groups = {
        "all": rows,
        "ovality told": [row for row in rows if row["ovality_told"]],
        "ovality not told": [row for row in rows if not row["ovality_told"]],
        "none": [row for row in rows if not row["effects"]],
        "several": [row for row in rows if len(row["effects"]) > 1],
    }
    groups |= {f"{name} alone": [row for row in rows if row["effects"] == [name]] for name in names}
    groups |= {f"with {name}": [row for row in rows if name in row["effects"]] for name in names}
    return {name: _of_group(group) for name, group in groups.items() if group}


def _of_group(rows):
    measured_rows = [row for row in rows if not row["refused"]]
    error, expanded = (
        np.array([value for row in measured_rows for value in row[name] if value is not None])
        for name in ("error_mm", "expanded_mm")
    )
    bars = [row for row in measured_rows if row["bar_error_mm"] is not None]
    bar_error, bar_expanded = (np.array([row[name] for row in bars]) for name in ("bar_error_mm", "bar_expanded_mm"))
    virtual = np.array([value for row in measured_rows for value in row["virtual_board_error_mm"] if value is not None])
    frames = sum(row["frames"] for row in measured_rows)
    if not len(error) or not len(bar_error):
        return {"lines": len(rows), "served": 0.0}
    return {
        "lines": len(rows),
        "frames": frames,
        "served": rounded(len(error) / frames),
        "wrong_values": int(np.sum(np.abs(error) > np.maximum(2 * expanded, 1.0))),
        **_statistics(error, expanded, ""),
        **_statistics(bar_error, bar_expanded, "bar_"),
        "virtual_board_rmse_mm": rounded(np.sqrt(np.mean(virtual**2))) if len(virtual) else None,
        "virtual_board_worst_mm": rounded(np.abs(virtual).max()) if len(virtual) else None,
    }


def _statistics(error, expanded, prefix):
    return {
        f"{prefix}rmse_mm": rounded(np.sqrt(np.mean(error**2))),
        f"{prefix}worst_mm": rounded(np.abs(error).max()),
        f"{prefix}inside": rounded(np.mean(np.abs(error) <= expanded)),
        f"{prefix}inside_half": rounded(np.mean(np.abs(error) <= expanded / 2)),
        f"{prefix}median_expanded_mm": rounded(np.median(expanded)),
    }
