"""What single steps and checks of the gauge are worth: each left out in turn, on the same pictures."""

import math
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from unittest.mock import patch

import cv2
import numpy as np
from calibrated_rigs import off_response, rig_with_marks

from appliance.simulation.bars.study_scenes import draw, set_up
from studies import no_measurable_bar
from studies.served_diameter import error_mm, rounded
from vision.calibration.still_marks import NO_MARKS
from vision.geometry.robust_constants import BIWEIGHT_TUNING
from vision.sizing.gauge import Gauge
from vision.sizing.tangent.cylinder_fit import fit_cylinder
from vision.sizing.tangent.tangent_planes import TangentPlane, rough_cylinder

TEXT = (
    "The gauge as served, and with one step or check left out; rigs and calibrations as in served_diameter, cameras "
    "that code their light (sRGB or gamma 2.2), 800 x 600. Of each: error and U in mm, null without a value. Frozen "
    "pictures are judged by the gauge alone."
)
BARS = ("clean", "scale", "post", "glare")
EFFECTS = ("bounce", "nudged")
SMOOTHED, SMOOTHED_PX = "smoothed by the camera", 0.7  # code values, as a camera's own noise reduction does
SHOWN = (*BARS, *EFFECTS, SMOOTHED, *no_measurable_bar.CASES)
SEEDS = [seed for seed in range(3000, 3018) if set_up("clean", seed).sensor.response != "linear"]
PLANE_ROUNDS = 10


@dataclass(frozen=True)
class Variant:
    """What is left out: constants and functions with what takes their place, parts of the rig, the raw pictures."""

    changed: dict = field(default_factory=dict)
    rig: dict = field(default_factory=dict)
    resampled: bool = False


def four_planes(rays, start):
    """The cylinder that touches four planes, one through each limb's rays, in place of one fitted to all rays."""
    fit = fit_cylinder(rays, start)
    planes = [plane_through(rays, rays.limb == limb) for limb in range(rays.limb.max() + 1)]
    touched = rough_cylinder(planes)
    return None if fit is None or touched is None else replace(fit, parameters=touched)


def plane_through(rays, mine):
    """Plane through the rays of a limb, outliers weighted down as in the cylinder's fit."""
    direction, weight = rays.direction[mine], np.ones(np.count_nonzero(mine))
    for _ in range(PLANE_ROUNDS):
        normal = np.linalg.svd(direction * weight[:, None], full_matrices=False)[2][2]
        off = direction @ normal
        ratio = off / (BIWEIGHT_TUNING * max(1.4826 * np.median(np.abs(off)), 1e-9))
        weight = np.where(np.abs(ratio) < 1, 1 - ratio**2, 0.0)
    return TangentPlane(rays.origin_mm[mine][0], -np.sign(normal[0]) * normal, int(rays.side[mine][0]))


CHECKS = {
    "axis height": Variant({"sizing.tangent.reading_reasons.OFF_ROLLERS_MM": math.inf}),
    "limb profile": Variant(
        {
            "edges.subpixel.MISFIT_SHARE": math.inf,
            "edges.subpixel.LEAST_UNEVENNESS": math.inf,
            "edges.subpixel.MOST_UNEVENNESS": math.inf,
        }
    ),
    "contrast": Variant({"sizing.region_grid.LEAST_CONTRAST": 0.0, "sizing.region_grid.FLOOR_LIGHT": 0.0}),
    "still marks": Variant(rig={"marks": (NO_MARKS, NO_MARKS)}),
    "agreement of the limbs": Variant({"sizing.tangent.reading_reasons.WORST_LIMB_PX": math.inf}),
}
VARIANTS = {
    "as served": Variant(),
    "light not decoded": Variant(rig={"response": "linear"}),
    "four planes": Variant({"sizing.tangent.bent_cylinder.fit_cylinder": four_planes}),
    "resampled pictures": Variant(resampled=True, rig={"marks": (NO_MARKS, NO_MARKS)}),
    **{f"without {name}": variant for name, variant in CHECKS.items()},
    "without any of these checks": Variant(
        {name: value for variant in CHECKS.values() for name, value in variant.changed.items()},
        CHECKS["still marks"].rig,
    ),
}


def cases():
    return [{"shown": name, "seed": seed} for seed in SEEDS for name in SHOWN]


def run(case):
    left, right, truth_mm, rig_seed = pictures(case["shown"], case["seed"])
    rig = rig_with_marks(rig_seed)
    values = {name: reading_of(variant, rig, (left, right), truth_mm) for name, variant in VARIANTS.items()}
    return {"measurable": truth_mm is not None, **values}


def pictures(name, seed):
    if name in no_measurable_bar.CASES:
        return no_measurable_bar.shown(name, seed)
    scene = draw(name, seed) if name in BARS else draw("clean", seed, effects=(name,) if name in EFFECTS else ())
    left, right = (off_response(picture, seed) for picture in (scene.left, scene.right))
    if name == SMOOTHED:
        left, right = (cv2.GaussianBlur(picture, (0, 0), SMOOTHED_PX) for picture in (left, right))
    return left, right, scene.truth["diameter_mm"], seed


def reading_of(variant, rig, pair, truth_mm):
    rig = replace(rig, **variant.rig)
    if variant.resampled:
        cameras = (rig.left, rig.right)
        pair = [cv2.undistort(picture, one.K, one.dist) for picture, one in zip(pair, cameras, strict=True)]
        left, right = (replace(one, dist=np.zeros(5)) for one in cameras)
        rig = replace(rig, left=left, right=right, boards={})
    with ExitStack() as changes:
        for name, value in variant.changed.items():
            changes.enter_context(patch(f"vision.{name}", value))
        reading = Gauge(rig, 0.0).measure(*pair)
    if not reading.valid:
        return None
    return [error_mm(reading.diameter_mm, truth_mm), rounded(reading.expanded_uncertainty_mm)]


def summary(rows):
    return {
        variant: {name: _of_scenes([row for row in rows if row["shown"] == name], variant) for name in SHOWN}
        for variant in VARIANTS
    }


def _of_scenes(rows, variant):
    values = [row[variant] for row in rows if row[variant] is not None]
    error = np.array([value[0] for value in values if value[0] is not None])
    return {
        "frames": len(rows),
        "values": len(values),
        "wrong_values": sum(is_wrong(*value) for value in values),
        "rmse_mm": rounded(np.sqrt(np.mean(error**2))) if error.size else None,
        "worst_mm": rounded(np.abs(error).max()) if error.size else None,
    }


def is_wrong(error, expanded_mm):
    return error is None or abs(error) > max(2 * expanded_mm, 1.0)
