"""Uncertainty budget of a diameter by route T (GUM, JCGM 100:2008, 5.1.2; docs/methods/diameter.md)."""

import math
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from vision.calibration.bundle_adjustment import N_CAMERA, project_with_slopes
from vision.calibration.camera_turn import NO_TURN, CameraTurn
from vision.calibration.rig import Rig
from vision.geometry.camera import CAMERA_PARAMETERS
from vision.geometry.surface_point import SurfacePoint
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
    """Parts of the standard uncertainty (k = 1) of the diameter, mm; `motion` and `range` are parts of `model`."""

    edge_mm: float
    calibration_mm: float
    board_mm: float
    light_mm: float
    shape_mm: float
    model_mm: float
    motion_mm: float
    range_mm: float

    @property
    def expanded_mm(self) -> float:
        """U = 2 u, u the root sum of squares of the parts."""
        return 2 * float(np.sqrt(sum(part**2 for part in astuple(self)[:-2])))


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
    point : SurfacePoint or None
        Where a laser meets the bar, if one measures beside the cameras.
    """

    ovality_mm: float | None = None
    turns: tuple[CameraTurn, CameraTurn] = (NO_TURN, NO_TURN)
    synchronous: bool = False
    point: SurfacePoint | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """A bar's cylinder with what its uncertainty needs beside the edge points.

    Attributes
    ----------
    fit : CylinderFit
        Combined with a laser's point where there is one.
    section : SectionView
        What the limbs, and the laser's spot, tell of the section.
    motion : ndarray of float64, shape (5,)
        Standard uncertainty of the parameters from motion, or from a wrong range; see `bar_motion`.
    range_mm : float
        Standard uncertainty of the diameter from the laser's point; 0 without one.
    gap_mm : float
        How far the point lies outside of the cylinder that the views show; NaN without one.
    agrees : bool
        False where the point contradicts the views and was not used.
    """

    fit: CylinderFit
    section: SectionView
    motion: Array
    range_mm: float = 0.0
    gap_mm: float = math.nan
    agrees: bool = True


def uncertainty_budget(
    solution: Solution, points: EdgePoints, rig: Rig, limbs: list[LimbPoints], known: Circumstances
) -> Budget:
    """All parts of the diameter's uncertainty.

    Parameters
    ----------
    solution : Solution
    points : EdgePoints
        Points that the cylinder was fitted to.
    rig : Rig
    limbs : list of LimbPoints
        In the order of `points.limb`.
    known : Circumstances

    Returns
    -------
    Budget
        `edge`: scatter of the points, correlation within windows counted. `calibration`: the rig's covariance,
        propagated through the fit. `board`: the board's scale. `light`: the camera's response and overexposed
        points. `shape`: what the views cannot see of a section that is not round. `model`: limbs that lie off as a
        whole, what the greater doubt in residuals inwards is worth, as a rectangular distribution, `motion`: a bar
        that moved between both exposures, and `range`.
    """
    fit, section, range_mm = solution.fit, solution.section, solution.range_mm
    reach_mm = 2 * _reach(fit, points, len(limbs))[4]
    off_px = np.array([_off_px(fit, points, index, limb) for index, limb in enumerate(limbs)])
    motion_mm = 2 * abs(float(solution.motion[4]))
    off_mm = [*(reach_mm * off_px), fit.inwards_mm / math.sqrt(3), motion_mm, range_mm]
    return Budget(
        edge_mm=fit.u_diameter_mm,
        calibration_mm=2 * math.sqrt(max(_calibration_covariance(fit, points, rig, known.turns)[4, 4], 0.0)),
        board_mm=fit.diameter_mm * rig.square_relative_u,
        light_mm=float(np.linalg.norm(reach_mm @ _light_px(rig, limbs))),
        shape_mm=section.unseen_share * _ovality_mm(fit, section, known) / (2 * math.sqrt(3)),
        model_mm=float(np.linalg.norm(off_mm)),
        motion_mm=motion_mm,
        range_mm=range_mm,
    )


def parameter_covariance(
    fit: CylinderFit, points: EdgePoints, rig: Rig, limbs: list[LimbPoints], known: Circumstances
) -> Array:
    """Covariance (k = 1) of the cylinder's parameters from edges, calibration, light and limbs that lie off.

    The board's scale is left out: a laser whose ray was calibrated in the rig's frame shares it. So are shape and
    motion, which are no matter of the parameters alone.

    Parameters
    ----------
    fit : CylinderFit
    points : EdgePoints
    rig : Rig
    limbs : list of LimbPoints
    known : Circumstances

    Returns
    -------
    ndarray of float64, shape (5, 5)
    """
    reach = _reach(fit, points, len(limbs))
    off = reach * np.array([_off_px(fit, points, index, limb) for index, limb in enumerate(limbs)])
    light = reach @ _light_px(rig, limbs)
    return fit.covariance + _calibration_covariance(fit, points, rig, known.turns) + off @ off.T + light @ light.T


def _reach(fit: CylinderFit, points: EdgePoints, limbs: int) -> Array:
    """Change of the parameters when a whole limb moves outwards by one pixel, shape (5, limbs)."""
    moved = fit.gain / fit.pixel_per_mm
    return -np.stack([moved[:, points.limb == limb].sum(axis=1) for limb in range(limbs)], axis=1)


def _light_px(rig: Rig, limbs: list[LimbPoints]) -> Array:
    """Doubts in the places of the limbs, px, one column for each that moves all limbs the same way."""
    shift_px = np.array([half_level_doubts_px(rig.response, (one.dark, one.bright), one.blur_px) for one in limbs])
    clipped_px = [max(CLIPPED_SHIFT_PX * one.clipped_share, one.is_guess * GUESS_SHIFT_PX) for one in limbs]
    return np.column_stack([shift_px, clipped_px, [one.u_compression_px for one in limbs]])


def usual_ovality_mm(fit: CylinderFit, known: Circumstances) -> float:
    """Greatest minus least width that the product may have."""
    return USUAL_OVALITY_SHARE * fit.diameter_mm if known.ovality_mm is None else known.ovality_mm


def _ovality_mm(fit: CylinderFit, section: SectionView, known: Circumstances) -> float:
    """Greatest minus least width that must be allowed for: at least what the views see."""
    return max(usual_ovality_mm(fit, known), section.seen_ovality_mm)


def bar_motion(fit: CylinderFit, per_height: Array) -> Array:
    """Standard uncertainty of the parameters from an axis that is not R above the rollers: h dp/dh / sqrt 2.

    Either the bar hops, which is no error, or the height is wrong. With two views one of them shows the bar further
    aside than the other, which edges cannot show: it moved between two exposures that do not coincide, or a camera has
    turned. With one view the laser's range is wrong. It is the one or the other: the divisor sqrt 2 is that of a
    distribution with its mass at both ends (arc sine).

    Parameters
    ----------
    fit : CylinderFit
    per_height : ndarray of float64, shape (5,)
        Change of the parameters per mm of apparent height, dp/dh.

    Returns
    -------
    ndarray of float64, shape (5,)
    """
    return per_height * float(fit.parameters[1] - fit.parameters[4]) / math.sqrt(2)


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


def _calibration_covariance(
    fit: CylinderFit, points: EdgePoints, rig: Rig, turns: tuple[CameraTurn, CameraTurn]
) -> Array:
    """The rig's covariance through one linear step of the fit, (5, 5); one point stands for each window of a limb.

    When a camera changes a little, a limb moves in its picture as the point does that is seen there on the bar: the
    tangent planes envelope the bar, so the touched point's own way along them does not count.
    """
    strips = points.limb * (points.window.max() + 1) + points.window
    _, first, index, count = np.unique(strips, return_index=True, return_inverse=True, return_counts=True)
    middle = points.only(first + count // 2)
    # change of the parameters per pixel by which all points of a strip move outwards
    moved = np.stack([-np.bincount(index, row) for row in fit.gain / fit.pixel_per_mm])
    touched_mm, outwards = touched_points(fit.parameters, middle.rays(rig))
    slope, turned = np.zeros((5, 2 * N_CAMERA)), np.zeros((5, 5))
    for view, camera in enumerate((rig.left, rig.right)):
        mine = middle.view == view
        if not mine.any():
            continue
        _, by_camera, by_point = project_with_slopes(camera, touched_mm[mine])
        normal = np.einsum("nij,nj->ni", by_point, outwards[mine])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        # a camera that shows the bar further outwards makes the points that were found lie further inwards
        own = -np.einsum("pn,ni,nij->pj", moved[:, mine], normal, by_camera)
        slope[:, view * N_CAMERA : (view + 1) * N_CAMERA] = own
        # what is left of a camera's turn about its own centre, in which t turns too
        turn = own[:, OMEGA] + np.cross(camera.t, own[:, TRANSLATION])
        turned += turn @ turns[view].covariance @ turn.T
    return slope @ rig.covariance @ slope.T + turned
