"""A laser beside the cameras: what its one point is worth to both views, on a short baseline, and to one view alone."""

import json
from dataclasses import replace
from functools import lru_cache

import numpy as np
from calibrated_rigs import off_response

from appliance.simulation.bars.laser import Laser
from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.boards import Board as TrueBoard
from appliance.simulation.boards.boards import board_document, high_pose, low_pose, observe
from appliance.simulation.true_rig import REGION_MM, TrueCamera, TrueRig, look_at
from appliance.sizing.range_sensor.sensor import RangeReading, steady_range_mm
from vision.calibration.checkerboard import Board
from vision.calibration.stereo import calibrate
from vision.geometry.surface_point import SurfacePoint
from vision.sizing.gauge import Gauge

TEXT = (
    "Both routes on rigs of the simulated mill (`usual`: baseline 0.5 to 2.5 m) and on rigs whose cameras stand 150 to "
    "400 mm apart (`short`), calibrated by the product from projected corners with detector noise and boards with "
    "print errors; responses off as in `served_diameter`; the ovality is told as 0. The laser's noise is 0.3 mm; "
    "its beam is calibrated from its spots on both registration boards, as the left camera sees them with 0.1 px of "
    "noise, and it is read at both exposures, as the appliance does. `cameras`: without it; `beside`: with it; "
    "`left alone`, `right alone`: with it, the other view dark; `wrong`, `left alone, wrong`: likewise with a range "
    "that is 20 mm too long."
)
RIGS = ("usual", "short")
CONDITIONS = ("clean", "scale", "haze", "bounce")
EFFECTS = ("bounce",)
WAYS = ("cameras", "beside", "left alone", "right alone", "wrong", "left alone, wrong")
SEEDS = 32
SAMPLE = 1  # each case measures five times
NOISE_MM, SPOT_NOISE_PX, READS = 0.3, 0.1, 16
U_MM = 0.5  # of the spot's place, as a user would state it: noise, and 0.4 mm for the beam
WRONG_MM = 20.0


def cases():
    return [
        {"rig": rig, "condition": condition, "seed": seed}
        for seed in range(SEEDS)
        for rig in RIGS
        for condition in (*CONDITIONS[:2], CONDITIONS[2 + seed % 2])
    ]


def run(case):
    seed, name = case["seed"], case["condition"]
    setup = set_up("clean", seed, effects=(name,)) if name in EFFECTS else set_up(name, seed)
    setup = replace(setup, rig=rigs(seed)[case["rig"]])
    rig, beam, laser = calibrated(seed, case["rig"])
    pictures = [off_response(picture, seed) for picture in setup.pair()]
    range_mm = read_mm(laser, setup, np.random.default_rng([seed, 0x7261]))
    dark = np.zeros_like(pictures[0])

    def point(off_mm=0.0):
        return None if np.isnan(range_mm) else beam(range_mm + off_mm)

    shown = {
        "cameras": (pictures, None),
        "beside": (pictures, point()),
        "left alone": ((pictures[0], dark), point()),
        "right alone": ((dark, pictures[1]), point()),
        "wrong": (pictures, point(WRONG_MM)),
        "left alone, wrong": ((pictures[0], dark), point(WRONG_MM)),
    }
    truth_mm = setup.diameter_mm
    return {
        way: told(Gauge(rig, 0.0).measure_bars(*pair, point=where)[0], truth_mm) for way, (pair, where) in shown.items()
    }


def read_mm(laser, setup, rng):
    """What the appliance makes of a reading at each camera's exposure; NaN where the bar hopped in between."""
    bar = setup.bars[0]
    moments = bar, replace(bar, lift_mm=bar.lift_mm + setup.bounce_mm)
    readings = [RangeReading(0.02 * place, laser.range_mm(one, rng)) for place, one in enumerate(moments)]
    return steady_range_mm(readings, 0.0, 0.05, U_MM)


def told(reading, truth_mm):
    result = {"valid": reading.valid, "reasons": reading.reasons.names}
    if reading.valid:
        result |= {
            "error_mm": round(reading.diameter_mm - truth_mm, 4),
            "expanded_mm": round(reading.expanded_uncertainty_mm, 4),
            "gap_mm": None if np.isnan(reading.range_gap_mm) else round(float(reading.range_gap_mm), 3),
        }
    return result


@lru_cache(maxsize=2)
def rigs(seed):
    usual = set_up("clean", seed).rig
    return {"usual": usual, "short": short_rig(seed, usual.region_y_mm)}


def short_rig(seed, region_y_mm):
    """Two cameras on one arm, 150 to 400 mm apart."""
    rng = np.random.default_rng([seed, 0x7368])
    distance_mm, elevation = rng.uniform(1500, 3500), np.deg2rad(rng.uniform(45, 80))
    baseline_mm = rng.uniform(150, 400)
    middle = np.array([0.0, -distance_mm * np.cos(elevation), 120 + distance_mm * np.sin(elevation)])
    cameras = []
    for side in (-0.5, 0.5):
        centre = middle + np.array([side * baseline_mm, 0.0, 0.0]) + rng.normal(0, 10, 3)
        pose = look_at(centre, np.array([0.0, 0.0, 120.0]) + rng.normal(0, 15, 3), np.deg2rad(rng.uniform(-8, 8)))
        in_camera = REGION_MM @ pose[0].T + pose[1]
        focal_px = 0.9 * np.min(np.array([400, 300]) / np.abs(in_camera[:, :2] / in_camera[:, 2:]))
        K = np.array([[focal_px, 0, 399.5], [0, focal_px, 299.5], [0, 0, 1.0]])
        dist = np.array([rng.uniform(-0.1, 0.02), rng.uniform(-0.03, 0.05), 0.0, 0.0, 0.0])
        cameras.append(TrueCamera(K, dist, *pose, (800, 600)))
    return TrueRig(*cameras, region_y_mm=region_y_mm)


@lru_cache(maxsize=4)
def calibrated(seed, kind):
    """The rig as calibrated, the beam in its frame, and the laser in the true one."""
    setup, true_rig = set_up("clean", seed), rigs(seed)[kind]
    rng = np.random.default_rng([seed, 0x626F])
    true_board = TrueBoard.with_errors(rng)
    seen = observe(true_rig, rng, true_board)
    board = Board.from_json(json.dumps(board_document(true_board, setup.sensor.response)))
    size, region_y_mm = true_rig.left.image_size, true_rig.region_y_mm
    rig = calibrate(seen.calibration, seen.low, seen.high, board, size, region_y_mm=region_y_mm).rig
    direction = np.array([rng.normal(0, 0.03), rng.normal(0, 0.03), -1.0])
    laser = Laser(
        np.array([rng.uniform(-20, 20), rng.uniform(-60, 60), 2200.0]), direction / np.linalg.norm(direction), NOISE_MM
    )
    return rig, calibrated_beam(rig, true_rig, true_board, laser, rng), laser


def calibrated_beam(rig, true_rig, true_board, laser, rng):
    """Where the spot lies at a range, from its places and ranges on both registration boards."""
    places, ranges = [], []
    for pose, height_mm in ((low_pose(true_board), rig.low_mm), (high_pose(true_board), rig.high_mm)):
        true_mm = (pose.centre_mm[2] - laser.origin_mm[2]) / laser.direction[2]
        seen_px = true_rig.left.project(laser.origin_mm + true_mm * laser.direction) + rng.normal(0, SPOT_NOISE_PX, 2)
        ray = rig.left.rays(seen_px[None])[0]
        places.append(rig.left.centre_mm + ray * (height_mm - rig.left.centre_mm[2]) / ray[2])
        ranges.append(true_mm + rng.normal(0, NOISE_MM, READS).mean())
    # the range is 0 at the spot on the low board: the sensor's offset is minus its reading there
    direction = (places[1] - places[0]) * np.sign(ranges[1] - ranges[0])
    return lambda range_mm: SurfacePoint.at(places[0], direction, range_mm - ranges[0], U_MM)


def summary(rows):
    groups = {rig: [row for row in rows if row["rig"] == rig] for rig in RIGS}
    groups |= {
        f"{rig} {condition}": [row for row in rows if (row["rig"], row["condition"]) == (rig, condition)]
        for rig in RIGS
        for condition in CONDITIONS
    }
    return {name: {way: of_values([row[way] for row in group]) for way in WAYS} for name, group in groups.items()}


def of_values(results):
    valid = [one for one in results if one["valid"]]
    if not valid:
        return {"frames": len(results), "values": 0}
    error = np.array([one["error_mm"] for one in valid])
    expanded = np.array([one["expanded_mm"] for one in valid])
    figures = {
        "rmse_mm": np.sqrt(np.mean(error**2)),
        "bias_mm": error.mean(),
        "bias_standard_error_mm": error.std() / np.sqrt(len(error)),
        "worst_mm": np.abs(error).max(),
        "covered": np.mean(np.abs(error) <= expanded),
        "median_expanded_mm": np.median(expanded),
        "routes_disagree": np.mean(["routes_disagree" in one["reasons"] for one in valid]),
    }
    return {"frames": len(results), "values": len(valid)} | {name: round(float(v), 4) for name, v in figures.items()}
