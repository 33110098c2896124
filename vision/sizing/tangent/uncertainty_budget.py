"""Uncertainty budget of a diameter by route T (GUM, JCGM 100:2008, 5.1.2; docs/methods/diameter.md)."""

import math
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from vision.calibration.bundle_adjustment import N_CAMERA, project_with_slopes
from vision.calibration.camera_turn import NO_TURN, CameraTurn
from vision.calibration.rig import Rig
from vision.geometry.camera import CAMERA_PARAMETERS
from vision.light import half_level_doubts_px
from vision.order_statistics import median
from vision.sizing.tangent.cylinder_fit import CylinderFit, touched_points
from vision.sizing.tangent.edge_points import EdgePoints
from vision.sizing.tangent.limb_finder import LimbPoints
from vision.sizing.tangent.section import SectionView

Array = NDArray[np.float64]

OMEGA = slice(CAMERA_PARAMETERS.index("omega_x"), CAMERA_PARAMETERS.index("omega_z") + 1)
TRANSLATION = slice(CAMERA_PARAMETERS.index("t_x"), CAMERA_PARAMETERS.index("t_z") + 1)
# Chosen, not checked: half of what ASTM A29 allows, from memory, between diameters of one hot-rolled round (1.2 %).
USUAL_OVALITY_SHARE = 0.006
U_PLACE_PX = 0.01  # chosen: standard uncertainty of the place of a whole limb whose edge looks perfect
GROSS_ERROR_SENSITIVITY = 1.7  # of the biweight, in standard deviations (Huber, ISBN 0-471-41805-6, 4.3)
MOST_FOREIGN_SHARE = 0.8  # chosen: at most 80 % of a limb's points count as foreign; e / (1 - e) has no bound
CLIPPED_SHIFT_PX = 0.5  # chosen: a fully overexposed limb is off outwards by half a pixel
GUESS_SHIFT_PX = 0.07  # of an edge in luma with a channel clipped up to 3 times over, on the simulated mill


@dataclass(frozen=True, slots=True)
class Budget:
    """Parts of the standard uncertainty (k = 1) of the diameter, mm; `motion` is a part of `model`."""

    edge_mm: float
    calibration_mm: float
    board_mm: float
    light_mm: float
    shape_mm: float
    model_mm: float
    motion_mm: float

    @property
    def expanded_mm(self) -> float:
        """U = 2 u, u the root sum of squares of the parts."""
        return 2 * float(np.sqrt(sum(part**2 for part in astuple(self)[:-1])))


@dataclass(frozen=True, slots=True)
class Circumstances:
    """What is known of a pair beside its pictures.

    Attributes
    ----------
    ovality_mm : float or None
        Greatest minus least width that a section of the product may have; None: `USUAL_OVALITY_SHARE` of the diameter.
    turns : tuple of two CameraTurn
        How the cameras have turned since their calibration, which the rig of the fit allows for.
    synchronous : bool
        Whether time stamps prove that both cameras exposed together.
    """

    ovality_mm: float | None = None
    turns: tuple[CameraTurn, CameraTurn] = (NO_TURN, NO_TURN)
    synchronous: bool = False


def uncertainty_budget(
    fit: CylinderFit,
    points: EdgePoints,
    rig: Rig,
    limbs: list[LimbPoints],
    *,
    section: SectionView,
    known: Circumstances,
) -> Budget:
    """All parts of the diameter's uncertainty.

    Parameters
    ----------
    fit : CylinderFit
    points : EdgePoints
        Points that the cylinder was fitted to.
    rig : Rig
    limbs : list of LimbPoints
        In the order of `points.limb`.
    section : SectionView
        What the limbs tell of the section.
    known : Circumstances

    Returns
    -------
    Budget
        `edge`: scatter of the points, correlation within windows counted. `calibration`: the rig's covariance,
        propagated through the fit. `board`: the board's scale. `light`: the camera's response and overexposed
        points. `shape`: what the views cannot see of a section that is not round. `model`: limbs that lie off as a
        whole, what the greater doubt in residuals inwards is worth, as a rectangular distribution, and `motion`: a bar
        that moved between both exposures.
    """
    reach_mm = np.array([_reach_mm(fit, points, limb) for limb in range(len(limbs))])
    shift_px = np.array(
        [half_level_doubts_px(rig.response, (one.dark, one.bright), one.blur_px) for one in limbs]
    )  # one column for each doubt
    compression_px = np.array([one.u_compression_px for one in limbs])
    clipped_px = np.array([max(CLIPPED_SHIFT_PX * one.clipped_share, one.is_guess * GUESS_SHIFT_PX) for one in limbs])
    off_px = np.array([_off_px(fit, points, index, limb) for index, limb in enumerate(limbs)])
    motion_mm = 0.0 if known.synchronous else _off_rollers_mm(fit, section)
    return Budget(
        edge_mm=fit.u_diameter_mm,
        calibration_mm=_calibration_mm(fit, points, rig, known.turns),
        board_mm=fit.diameter_mm * rig.square_relative_u,
        # response and overexposure move all limbs the same way, a limb's own fault only that limb
        light_mm=float(np.linalg.norm([*(reach_mm @ shift_px), reach_mm @ clipped_px, reach_mm @ compression_px])),
        shape_mm=section.unseen_share * _ovality_mm(fit, section, known) / (2 * math.sqrt(3)),
        model_mm=float(np.linalg.norm([*(reach_mm * off_px), fit.inwards_mm / math.sqrt(3), motion_mm])),
        motion_mm=motion_mm,
    )


def _reach_mm(fit: CylinderFit, points: EdgePoints, limb: int) -> float:
    """Growth of the diameter when a whole limb moves outwards by one pixel."""
    mine = points.limb == limb
    return float(-2 * np.sum(fit.gain[4, mine] / fit.pixel_per_mm[mine]))


def _ovality_mm(fit: CylinderFit, section: SectionView, known: Circumstances) -> float:
    """Greatest minus least width that must be allowed for: at least what the views see."""
    usual_mm = USUAL_OVALITY_SHARE * fit.diameter_mm
    return max(usual_mm if known.ovality_mm is None else known.ovality_mm, section.seen_ovality_mm)


def _off_rollers_mm(fit: CylinderFit, section: SectionView) -> float:
    """Standard uncertainty from an axis that is not R above the rollers, mm: h dD/dh / sqrt 2.

    Either the bar hops, which is no error, or one view shows it further aside than the other, which edges cannot show:
    it moved between two exposures that do not coincide, or a camera has turned. It is the one or the other: the divisor
    sqrt 2 is that of a distribution with its mass at both ends (arc sine).
    """
    return abs(section.height_slope * float(fit.parameters[1] - fit.parameters[4])) / math.sqrt(2)


def _off_px(fit: CylinderFit, points: EdgePoints, index: int, limb: LimbPoints) -> float:
    """Standard uncertainty of a limb's place as a whole, px.

    Root sum of squares of a perfect edge's uncertainty, of that of the correction for shading, of the median residual
    of the limb, and of the largest bias e / (1 - e) x 1.7 sigma that a share e of foreign points gives a biweight, as
    the half width of a rectangular distribution.
    """
    mine = points.limb == index
    agreeing = fit.weight[mine] > 0
    middle_px = median(fit.residual_px[mine][agreeing]) if agreeing.any() else 0.0
    foreign = min(1 - float(fit.weight[mine].mean()), MOST_FOREIGN_SHARE)
    bias_px = GROSS_ERROR_SENSITIVITY * fit.scale_px * foreign / (1 - foreign) / np.sqrt(3)
    return float(np.linalg.norm([U_PLACE_PX, limb.u_shading_px, middle_px, bias_px]))


def _calibration_mm(fit: CylinderFit, points: EdgePoints, rig: Rig, turns: tuple[CameraTurn, CameraTurn]) -> float:
    """The rig's covariance through one linear step of the fit; one point stands for each window of a limb.

    When a camera changes a little, a limb moves in its picture as the point does that is seen there on the bar: the
    tangent planes envelope the bar, so the touched point's own way along them does not count.
    """
    strips = points.limb * (points.window.max() + 1) + points.window
    _, first, index, count = np.unique(strips, return_index=True, return_inverse=True, return_counts=True)
    middle = points.only(first + count // 2)
    # growth of the diameter per pixel by which all points of a strip move outwards
    growth_mm = -2 * np.bincount(index, fit.gain[4] / fit.pixel_per_mm)
    touched_mm, outwards = touched_points(fit.parameters, middle.rays(rig))
    slope, moved_mm2 = np.zeros(2 * N_CAMERA), 0.0
    for view, camera in enumerate((rig.left, rig.right)):
        mine = middle.view == view
        _, by_camera, by_point = project_with_slopes(camera, touched_mm[mine])
        normal = np.einsum("nij,nj->ni", by_point, outwards[mine])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        # a camera that shows the bar further outwards makes the points that were found lie further inwards
        slope[view * N_CAMERA :][:N_CAMERA] = -np.einsum("n,ni,nij->j", growth_mm[mine], normal, by_camera)
        # what is left of a camera's turn about its own centre, in which t turns too
        mine = slope[view * N_CAMERA :][:N_CAMERA]
        turn_mm = mine[OMEGA] + np.cross(camera.t, mine[TRANSLATION])
        moved_mm2 += float(turn_mm @ turns[view].covariance @ turn_mm)
    return float(np.sqrt(max(slope @ rig.covariance @ slope, 0.0) + moved_mm2))
