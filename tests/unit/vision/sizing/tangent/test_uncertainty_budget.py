"""Parts of the budget against what happens to the diameter when a limb is moved and the cylinder fitted again."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tangent_rays import FOCAL_PX, START, tangent_rays

from vision.reasons import Reason
from vision.sizing.tangent import uncertainty_budget as budget
from vision.sizing.tangent.cylinder_fit import fit_cylinder
from vision.sizing.tangent.reading_reasons import reasons_of_limbs
from vision.sizing.tangent.section import SectionView

LIMBS = range(4)
RAYS = tangent_rays()
FIT = fit_cylinder(RAYS, START)


def grown_mm(moved_px):
    """Growth of the diameter when each limb is moved outwards by so many pixels."""
    direction = RAYS.direction.copy()
    for limb, px in enumerate(moved_px):
        mine = RAYS.limb == limb
        across = np.cross(direction[mine], [0.0, 1.0, 0.0])
        across *= np.sign(across[:, :1]) * RAYS.side[mine][:, None]  # outwards: away from the axis in x
        direction[mine] += px / FOCAL_PX * across / np.linalg.norm(across, axis=1, keepdims=True)
    return fit_cylinder(replace(RAYS, direction=direction), START).diameter_mm - FIT.diameter_mm


def limb(**changes):
    perfect = {
        "dark": np.array([0.02]),
        "bright": np.array([0.9]),
        "blur_px": 0.0,
        "u_shading_px": 0.0,
        "clipped_share": 0.0,
        "is_guess": False,
        "u_compression_px": 0.0,
    }
    return SimpleNamespace(**perfect | changes)


def parts(monkeypatch, limbs, *, lift_mm=0.0, height_slope=0.0, unseen_share=0.0, synchronous=False):
    monkeypatch.setattr(budget, "_calibration_covariance", lambda *_: np.zeros((5, 5)))
    rig = SimpleNamespace(response="linear", square_relative_u=0.0)
    parameters = FIT.parameters.copy()
    parameters[1] = parameters[4] + lift_mm
    fit = replace(FIT, parameters=parameters, residual_px=np.zeros(len(RAYS.limb)), weight=np.ones(len(RAYS.limb)))
    points = SimpleNamespace(limb=RAYS.limb)
    sideways = np.array([0.0, 1.0, 0.0, 0.0, height_slope / 2])
    section = SectionView(unseen_share, seen_ovality_mm=0.2, sideways=sideways)
    known = budget.Circumstances(ovality_mm=0.6, synchronous=synchronous)
    motion = np.zeros(5) if synchronous else budget.bar_motion(fit, section.sideways)
    return budget.uncertainty_budget(budget.Solution(fit, section, motion), points, rig, limbs, known)


@pytest.mark.parametrize("moved", LIMBS)
def test_the_reach_of_each_limb_is_what_the_diameter_grows_by(moved):
    reach_mm = 2 * budget._reach(FIT, SimpleNamespace(limb=RAYS.limb), 4)[4, moved]
    assert reach_mm == pytest.approx(grown_mm([0.1 if one == moved else 0.0 for one in LIMBS]) / 0.1, rel=0.02)


def test_overexposure_of_all_limbs_moves_them_together(monkeypatch):
    found = parts(monkeypatch, [limb(clipped_share=0.4)] * 4)
    assert found.light_mm == pytest.approx(abs(grown_mm([0.2] * 4)), rel=0.02)


@pytest.mark.parametrize("spoilt", LIMBS)
def test_doubts_of_one_limb_count_by_its_own_reach(monkeypatch, spoilt):
    alone = [0.1 if one == spoilt else 0.0 for one in LIMBS]
    coded = parts(monkeypatch, [limb(u_compression_px=px) for px in alone])
    assert coded.light_mm == pytest.approx(abs(grown_mm(alone)), rel=0.02)
    shaded = parts(monkeypatch, [limb(u_shading_px=px) for px in alone])
    places = [grown_mm([budget.U_PLACE_PX if one == moved else 0.0 for one in LIMBS]) for moved in LIMBS]
    assert shaded.model_mm == pytest.approx(math.hypot(grown_mm(alone), *places), rel=0.02)


def test_a_guessed_channel_is_a_doubt_of_its_own_size(monkeypatch):
    found = parts(monkeypatch, [limb(is_guess=True)] * 4)
    assert found.light_mm == pytest.approx(abs(grown_mm([budget.GUESS_SHIFT_PX] * 4)), rel=0.02)


@pytest.mark.parametrize(("synchronous", "motion_mm"), [(False, 0.04 * 5.0 / math.sqrt(2)), (True, 0.0)])
def test_a_bar_that_floats_has_moved_unless_both_pictures_are_of_one_moment(monkeypatch, synchronous, motion_mm):
    floating = {"lift_mm": 5.0, "height_slope": 0.04, "synchronous": synchronous}
    lifted, lying = (parts(monkeypatch, [limb()] * 4, **more) for more in (floating, {}))
    assert lifted.motion_mm == pytest.approx(motion_mm)
    assert lifted.model_mm == pytest.approx(math.hypot(lying.model_mm, motion_mm))


def test_of_an_ovality_the_part_counts_that_the_views_do_not_see(monkeypatch):
    assert parts(monkeypatch, [limb()] * 4, unseen_share=0.5).shape_mm == pytest.approx(0.5 * 0.6 / (2 * math.sqrt(3)))


def test_overexposed_limbs_are_a_reason_beside_others():
    weak = limb(bright=np.array([0.03]), clipped_share=0.0)
    clipped = limb(clipped_share=0.5)
    limbs, shown = [weak, clipped, limb(), limb()], list(LIMBS)
    assert reasons_of_limbs(limbs, shown, 3) == Reason.LOW_CONTRAST | Reason.SOME_EDGES_CLIPPED
    assert reasons_of_limbs([limb(), clipped, limb(), limb()], shown, 3) == Reason.SOME_EDGES_CLIPPED
    assert reasons_of_limbs([limb()] * 4, shown, 3) == Reason.NONE
