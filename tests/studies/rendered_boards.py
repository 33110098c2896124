"""The same rigs calibrated twice, from rendered pictures of boards and from projected corners, and gauged with both."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from calibrated_rigs import board_of, rig_with_marks

from appliance.simulation.bars.study_scenes import set_up
from appliance.simulation.boards.board_pictures import rig_folder_pictures
from appliance.simulation.boards.boards import board_document
from appliance.sizing.stereo.calibrate_folder import calibrate_folder
from studies.served_diameter import rounded
from vision.sizing.gauge import Gauge

TEXT = (
    "The same board, poses, rig and pictures of bars; rendered: rig folder of 15 + 2 pairs, read, corners found and "
    "calibrated as `hotgauge calibrate` does; projected: true corners with 0.04 px of detector noise; 800 x 600. "
    "u_difference_mm: root sum of squares of both calibrations' parts of the uncertainty."
)
CONDITIONS = ("clean", "scale")
POSES = 15
SAMPLE = 1
SEEDS = range(2000, 2012)


def cases():
    return [{"seed": seed} for seed in SEEDS]


def run(case):
    seed = case["seed"]
    rendered, projected = calibrated_from_pictures(seed), rig_with_marks(seed)
    result = {
        "residual_rendered_px": rounded(rendered.residual_px),
        "residual_projected_px": rounded(projected.residual_px),
    }
    for condition in CONDITIONS:
        setup = set_up(condition, seed)
        readings = [Gauge(rig, 0.0).measure(*setup.pair()) for rig in (rendered, projected)]
        result |= {f"{condition}_{name}": value for name, value in compared(*readings, setup.diameter_mm).items()}
    return result


def compared(rendered, projected, truth_mm):
    return {
        "error_rendered_mm": rounded(rendered.diameter_mm - truth_mm),
        "error_projected_mm": rounded(projected.diameter_mm - truth_mm),
        "expanded_rendered_mm": rounded(rendered.expanded_uncertainty_mm),
        "expanded_projected_mm": rounded(projected.expanded_uncertainty_mm),
        "difference_mm": rounded(rendered.diameter_mm - projected.diameter_mm),
        "u_difference_mm": rounded(np.hypot(rendered.u_calibration_mm, projected.u_calibration_mm)),
    }


def calibrated_from_pictures(seed):
    setup, (rng, board) = set_up("clean", seed), board_of(seed)
    with TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("calibration", "registration"):
            (folder / part).mkdir()
        (folder / "board.json").write_text(json.dumps(board_document(board, setup.sensor.response)), encoding="utf-8")
        for path, *pair in rig_folder_pictures(setup.scene_as_calibrated(), setup.rig, rng, board, POSES):
            for side, picture in zip(("left", "right"), pair, strict=True):
                cv2.imwrite(str(folder / path.format(side=side)), picture)
        return calibrate_folder(folder, region_y_mm=setup.rig.region_y_mm).rig


def summary(rows):
    return {condition: _of_condition(rows, condition) for condition in CONDITIONS}


def _of_condition(rows, condition):
    def of(name):
        return np.array([row[f"{condition}_{name}"] for row in rows])

    return {
        "rigs": len(rows),
        **{
            f"{what}_{way}": rounded(value)
            for way in ("rendered", "projected")
            for what, value in {
                "rmse_mm": np.sqrt(np.mean(of(f"error_{way}_mm") ** 2)),
                "worst_mm": np.abs(of(f"error_{way}_mm")).max(),
                "covered": np.mean(np.abs(of(f"error_{way}_mm")) <= of(f"expanded_{way}_mm")),
                "median_expanded_mm": np.median(of(f"expanded_{way}_mm")),
            }.items()
        },
        "rms_difference_mm": rounded(np.sqrt(np.mean(of("difference_mm") ** 2))),
        "worst_difference_mm": rounded(np.abs(of("difference_mm")).max()),
        "mean_difference_mm": rounded(of("difference_mm").mean()),
        "rms_difference_over_u": rounded(np.sqrt(np.mean((of("difference_mm") / of("u_difference_mm")) ** 2))),
    }
