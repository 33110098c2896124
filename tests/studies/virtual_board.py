"""Route V: the source's way as printed, each correction added in turn, and what the source says of its windows and Q_R.

Every seed draws its own rig, board, calibration and bar, the rig calibrated by the product. Parts of the study:
`corrected` is the served route under every condition; `unequal` is the same with one camera at each side, at unequal
heights; `steps` adds the corrections one by one; `windows` looks at the source's own windows, corrupted ones and good
ones; `height` moves the board off its height; `sequence` follows the closed loop from frame to frame.
"""

import json
from dataclasses import replace
from functools import lru_cache

import numpy as np

from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.boards import Board as TrueBoard
from appliance.simulation.boards.boards import board_document, observe
from appliance.simulation.true_rig import REGION_MM, TrueCamera, TrueRig, look_at
from vision.alignment.height_search import search_by_offset
from vision.alignment.view_alignment import Alignment
from vision.calibration.checkerboard import Board
from vision.calibration.stereo import calibrate
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.reading import AS_PRINTED, CORRECTED, Corrections

TEXT = (
    "Route V, rig calibrated by the product from projected corners with detector noise and boards with print errors; "
    "800 x 600, edges by the shipped forest, no fusion. Seeds are the cases' own."
)
EDGES = "forest"
MEASURABLE = ("clean", "scale", "rollers", "post", "haze", "glare", "overexposed", "bar-end")
NOTHING = ("no-bar", "one-blind", "two-bars")
SEEDS, UNEQUAL_SEEDS, STEP_SEEDS, FINDING_SEEDS, SEQUENCE_SEEDS = 300, 60, 40, 30, 15
STEPS = {
    "as printed": AS_PRINTED,
    "+ turned rows": replace(AS_PRINTED, turned_rows=True),
    "+ robust lines": Corrections(True, True, False, False, False),
    "+ tangent crossing": Corrections(True, True, False, True, False),
    "+ projective boards": Corrections(True, True, True, True, False),
    "+ half level in linear light": CORRECTED,
}
STEP_CONDITIONS = ("clean", "scale", "haze")
WINDOW_CONDITIONS = ("clean", "post", "glare", "scale")
PRINTED_WINDOWS = Corrections(turned_rows=True, robust_lines=False, half_level=False)
CORRUPT_MM = 3.0  # the source's tolerance
OFF_MM = (-60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0)
SEQUENCE_FRAMES = 12
FINE_BOARDS = 321  # one every millimetre


def cases():
    def case(part, condition, seed):
        return {"part": part, "condition": condition, "seed": seed}

    # every seed draws a clean and a scaly bar, and two of the other conditions in turn
    others = MEASURABLE[2:]
    served = [
        case("corrected", condition, seed)
        for seed in range(SEEDS)
        for condition in (
            *MEASURABLE[:2],
            *(others[(2 * seed + place) % len(others)] for place in range(2)),
            NOTHING[seed % len(NOTHING)],
        )
    ]
    unequal = [case("unequal", condition, seed) for seed in range(UNEQUAL_SEEDS) for condition in MEASURABLE[:2]]
    steps = [case("steps", condition, seed) for seed in range(STEP_SEEDS) for condition in STEP_CONDITIONS]
    findings = [
        case(part, condition, seed)
        for seed in range(FINDING_SEEDS)
        for part, condition in (*(("windows", name) for name in WINDOW_CONDITIONS), ("height", "clean"))
    ]
    return served + unequal + steps + findings + [case("sequence", "clean", seed) for seed in range(SEQUENCE_SEEDS)]


def run(case):
    return RUNS.get(case["part"], run_served)(case)


def run_served(case):
    setup, rig = world(case["seed"], case["condition"], case["part"] == "unequal")
    reading = VirtualBoardGauge(rig, edges=EDGES).measure(*setup.pair())
    truth_mm = setup.diameter_mm
    result = {"truth_mm": truth_mm, "valid": reading.valid, "reasons": reading.reasons.names}
    if reading.valid:
        result |= {
            "error_mm": reading.diameter_mm - truth_mm if truth_mm is not None else None,
            "expanded_mm": reading.expanded_uncertainty_mm,
            "sigma_mm": reading.weighted_deviation_mm,
        }
    return result


def run_steps(case):
    """Error after each correction; None without a value."""
    setup, rig = world(case["seed"], case["condition"], False)
    pair = setup.pair()
    result = {}
    for name, corrections in STEPS.items():
        reading = VirtualBoardGauge(rig, corrections=corrections, edges=EDGES).measure(*pair)
        result[name] = reading.diameter_mm - setup.diameter_mm if reading.valid else None
    return {"error_mm": result}


def run_windows(case):
    """Windows as the source makes them, on the right plane: which are corrupted, and which does Sigma tell."""
    setup, rig = world(case["seed"], case["condition"], False)
    reading = VirtualBoardGauge(rig, corrections=PRINTED_WINDOWS, edges=EDGES).measure(*setup.pair())
    l_mm, kept = reading.window_diameters_mm, reading.window_kept
    there = np.isfinite(l_mm)
    if not there.any():
        return {"windows": 0}
    off_mm = l_mm - np.median(l_mm[there])
    corrupt = there & (np.abs(off_mm) > CORRUPT_MM)
    error_mm = l_mm - setup.diameter_mm
    sigma = reading.window_sigmas_mm
    return {
        "windows": int(there.sum()),
        "corrupt": int(corrupt.sum()),
        "corrupt_discarded": int((corrupt & ~kept).sum()),
        "good_discarded": int((there & ~corrupt & ~kept).sum()),
        "rmse_all_mm": rms(error_mm[there]),
        "rmse_kept_mm": rms(error_mm[kept]) if kept.any() else None,
        "sigma_good_mm": float(np.median(sigma[there & ~corrupt])) if (there & ~corrupt).any() else None,
        "sigma_corrupt_mm": float(np.median(sigma[corrupt])) if corrupt.any() else None,
    }


def run_height(case):
    """Q_R and the width on the plane when the board is moved off its height."""
    setup, rig = world(case["seed"], case["condition"], False)
    alignment, outlines = aligned(VirtualBoardGauge(rig, edges=EDGES), *setup.pair())
    right_mm = search_by_offset(lambda height: alignment.quality(*outlines, height), FINE_BOARDS).height_mm
    quality = [alignment.quality(*outlines, right_mm + off).percent for off in OFF_MM]
    return {"height_mm": right_mm, "quality_percent": quality}


def run_sequence(case):
    """A bar, then another of another size; each frame the bar lies a little elsewhere and bounces."""
    setup, rig = world(case["seed"], case["condition"], False)
    rng = np.random.default_rng([case["seed"], 0x7376])
    scene = Scene(setup.rig, setup.seed, setup.sensor, setup.blur, setup.glow)
    gauge = VirtualBoardGauge(rig, edges=EDGES)
    diameters = np.repeat(rng.uniform(80, 300, 2), SEQUENCE_FRAMES // 2)
    away_mm, evaluations = [], []
    for frame, diameter_mm in enumerate(diameters):
        bar = replace(
            setup.bars[0],
            diameter_mm=float(diameter_mm),
            offset_mm=setup.bars[0].offset_mm + rng.normal(0, 3),
            lift_mm=abs(rng.normal(0, 2)),
        )
        pair = scene.pair(bar, frame)
        reading = gauge.measure(*pair)
        alignment, outlines = aligned(VirtualBoardGauge(rig, edges=EDGES), *pair)
        found = search_by_offset(lambda height, a=alignment, o=outlines: a.quality(*o, height), FINE_BOARDS)
        away_mm.append(reading.plane_height_mm - found.height_mm)
        evaluations.append(reading.evaluations)
    return {"away_mm": away_mm, "evaluations": evaluations}


def aligned(gauge, left, right):
    outlines = tuple(
        grid.bars(image, gauge._decoder.shown)[0] for grid, image in zip(gauge._grids, (left, right), strict=True)
    )
    regions = gauge._regions((left, right), outlines)
    edges = [gauge._view_edges(region, outline) for region, outline in zip(regions, outlines, strict=True)]
    return Alignment(gauge.rig, gauge.boards, *regions, True), [view.outline for view in edges]


def world(seed, condition, unequal):
    """The scene's set-up and the calibrated rig."""
    setup = set_up(condition, seed)
    if unequal:
        setup = replace(setup, rig=unequal_rig(seed))
    return setup, calibrated(seed, unequal)


@lru_cache(maxsize=1)
def calibrated(seed, unequal):
    setup = set_up("clean", seed)
    true_rig = unequal_rig(seed) if unequal else setup.rig
    rng = np.random.default_rng([seed, 0x626F])
    true_board = TrueBoard.with_errors(rng)
    seen = observe(true_rig, rng, true_board)
    board = Board.from_json(json.dumps(board_document(true_board, setup.sensor.response)))
    size, region_y_mm = true_rig.left.image_size, true_rig.region_y_mm
    return calibrate(seen.calibration, seen.low, seen.high, board, size, region_y_mm=region_y_mm).rig


@lru_cache(maxsize=1)
def unequal_rig(seed):
    """One camera at each side of the line, one of them up to twice as high as the other."""
    rng = np.random.default_rng([seed, 0x756E])
    cameras = []
    low_mm = rng.uniform(1300, 1800)
    for side, height_mm in zip((-1, 1), rng.permutation([low_mm, low_mm * rng.uniform(1.3, 2.0)]), strict=True):
        centre = np.array([side * rng.uniform(900, 1700), -rng.uniform(200, 1200), height_mm])
        pose = look_at(centre, np.array([0.0, 0.0, 120.0]) + rng.normal(0, 15, 3), np.deg2rad(rng.uniform(-8, 8)))
        in_camera = REGION_MM @ pose[0].T + pose[1]
        focal_px = 0.9 * np.min(np.array([400, 300]) / np.abs(in_camera[:, :2] / in_camera[:, 2:]))
        K = np.array([[focal_px, 0, 399.5], [0, focal_px, 299.5], [0, 0, 1.0]])
        dist = np.array([rng.uniform(-0.1, 0.02), rng.uniform(-0.03, 0.05), 0.0, 0.0, 0.0])
        cameras.append(TrueCamera(K, dist, *pose, (800, 600)))
    return TrueRig(*cameras, region_y_mm=(-200.0, 200.0))


RUNS = {"steps": run_steps, "windows": run_windows, "height": run_height, "sequence": run_sequence}


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def summary(rows):
    def of(part):
        return [row for row in rows if row["part"] == part]

    told = {}
    for part in ("corrected", "unequal"):
        conditions = dict.fromkeys(row["condition"] for row in of(part))
        told[part] = {name: errors([row for row in of(part) if row["condition"] == name]) for name in conditions}
    told["steps"] = {
        variant: {
            name: of_step([row["error_mm"][variant] for row in of("steps") if row["condition"] == name])
            for name in STEP_CONDITIONS
        }
        for variant in STEPS
    }
    told["windows"] = {
        name: of_windows([row for row in of("windows") if row["condition"] == name and row["windows"]])
        for name in dict.fromkeys(row["condition"] for row in of("windows"))
    }
    told["height"] = of_heights(of("height"))
    told["sequence"] = of_sequences(of("sequence"))
    return told


def errors(rows):
    measurable = [row for row in rows if row["truth_mm"] is not None]
    told = {
        "frames": len(measurable),
        "values_without_a_measurable_bar": sum(row["valid"] for row in rows if row["truth_mm"] is None),
    }
    valid = [row for row in measurable if row["valid"]]
    if not valid:
        return told
    error = np.array([row["error_mm"] for row in valid])
    told |= {
        "availability": round(len(valid) / len(measurable), 4),
        "rmse_mm": round(rms(error), 4),
        "bias_mm": round(float(error.mean()), 4),
        "bias_standard_error_mm": round(float(error.std(ddof=1) / np.sqrt(error.size)), 4),
        "worst_mm": round(float(np.abs(error).max()), 4),
    }
    if "expanded_mm" in valid[0]:
        expanded = np.array([row["expanded_mm"] for row in valid])
        told |= {
            "covered": round(float(np.mean(np.abs(error) <= expanded)), 4),
            "median_expanded_mm": round(float(np.median(expanded)), 4),
        }
    return told


def of_step(errors_mm):
    error = np.array([one for one in errors_mm if one is not None])
    return {
        "frames": len(errors_mm),
        "availability": round(len(error) / len(errors_mm), 4),
        "rmse_mm": round(rms(error), 3),
        "median_mm": round(float(np.median(np.abs(error))), 3),
        "bias_mm": round(float(error.mean()), 3),
        "worst_mm": round(float(np.abs(error).max()), 3),
    }


def of_windows(rows):
    total = {name: sum(row[name] for row in rows) for name in ("windows", "corrupt", "corrupt_discarded")}
    good = total["windows"] - total["corrupt"]
    told = total | {"good_discarded_share": round(sum(row["good_discarded"] for row in rows) / max(1, good), 4)}
    worse = [row for row in rows if 0 < 2 * row["corrupt"] < row["windows"] and row["rmse_kept_mm"] is not None]
    if worse:
        told |= {
            "frames_with_some_corrupt_windows": len(worse),
            "median_rmse_all_mm": round(float(np.median([row["rmse_all_mm"] for row in worse])), 3),
            "median_rmse_kept_mm": round(float(np.median([row["rmse_kept_mm"] for row in worse])), 3),
            "median_sigma_ratio": round(
                float(np.median([r["sigma_corrupt_mm"] / r["sigma_good_mm"] for r in worse])), 2
            ),
        }
    return told


def of_heights(rows):
    quality = np.array([row["quality_percent"] for row in rows])
    off = np.array(OFF_MM)
    return {
        "frames": len(rows),
        "median_quality_by_offset": {
            f"{o:+.0f} mm": round(float(np.median(q)), 2) for o, q in zip(off, quality.T, strict=True)
        },
        "right_sign_share": round(float(np.mean(np.sign(quality[:, off != 0]) == np.sign(off[off != 0]))), 4),
        "best_at_the_right_height_share": round(
            float(np.mean(np.abs(quality).max(axis=1) <= np.abs(quality[:, 3]) + 0.5)), 4
        ),
    }


def of_sequences(rows):
    away = np.abs(np.concatenate([row["away_mm"] for row in rows]))
    tried = np.concatenate([row["evaluations"] for row in rows])
    return {
        "frames": len(away),
        "within_2_mm_in_4_boards_share": round(float(np.mean((away <= 2.0) & (tried <= 4))), 4),
        "followed_share": round(float(np.mean(tried <= 4)), 4),
        "median_boards": float(np.median(tried)),
        "worst_away_mm": round(float(away.max()), 3),
    }
