"""Route T: the diameter of the bar from the tangent planes of both views.

Each view shows the bar's two limbs (edges of the bar) as straight lines. Every edge ray grazes the bar, so one cylinder
fits them all; the scatter of the points gives its covariance (docs/methods/diameter.md).
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from vision.calibration.camera_turn import NO_TURN, CameraTurn
from vision.calibration.rig import Rig
from vision.geometry.camera import Camera
from vision.light_planes import Decoder
from vision.order_statistics import median, median_without_nan
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sent_picture import Codes, SentPicture
from vision.sizing.checked_pictures import checked_pair
from vision.sizing.limits import (
    CLIPPED_FEW_SHARE,
    CLIPPED_MOST_SHARE,
    COVERED_SHARE,
    DIAMETER_MM,
    LEAST_POINTS,
    LIMB_SIDES,
    OFF_ROLLERS_MM,
    OFF_ROLLERS_SHARE,
    WEAK_CONTRAST,
)
from vision.sizing.region_grid import Outline, RegionGrid
from vision.sizing.tangent.bent_cylinder import BentCylinder, fit_bent_cylinder
from vision.sizing.tangent.cylinder_fit import CylinderFit, nearest_cylinder
from vision.sizing.tangent.edge_points import EdgePoints
from vision.sizing.tangent.limb_finder import LimbFinder, LimbPoints, RoughLimb
from vision.sizing.tangent.section import section_view
from vision.sizing.tangent.tangent_planes import TangentPlane, rough_cylinder
from vision.sizing.tangent.uncertainty_budget import Budget, Circumstances, uncertainty_budget

Array = NDArray[np.float64]
Result = TypeVar("Result")

WINDOW_MM = 20.0  # chosen: length of a window, a strip along the bar; points within one may be correlated
WINDOW_AGREEMENT_PX = 0.5  # chosen: a window is kept if the median residual of every limb in it is at most half a pixel
HIDDEN_SHARE = 0.4  # chosen: a limb with less than 40 % of the best limb's share of edge points counts as hidden
LEAST_LIMBS = 3  # three tangent planes fix the cylinder
END_MARGIN_MM = 10.0  # chosen: a bar that ends further inside the region shows its head or its tail
# Chosen: a bin of 5 mm along the bar belongs to the bar if two limbs have a point in it within half a pixel of the fit.
END_BIN_MM, END_AGREEMENT_PX, LEAST_LIMBS_AT_END = 5.0, 0.5, 2
WORST_LIMB_PX = 1.5  # chosen: a limb whose median window lies further off the cylinder means `views_disagree`
MOST_WANDER_PX = 0.2  # chosen: beyond it hot air decides the uncertainty, and the reading is `shimmer`
CAMBER_LENGTH_MM = 1000.0  # over which the sagitta of the axis is stated
NO_TURNS = (NO_TURN, NO_TURN)


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """Camera, grid and limb finder of one view, prepared once."""

    camera: Camera
    grid: RegionGrid
    finder: LimbFinder

    def rough_limbs(self, picture: SentPicture, outline: Outline) -> list[RoughLimb]:
        """Both limbs of a bar, at smaller and at larger x."""
        lines = outline.left, outline.right
        return [self.finder.roughly(picture, line, side) for line, side in zip(lines, LIMB_SIDES, strict=True)]


class TangentGauge:
    """Measures one bar with a calibrated rig by route T.

    Parameters
    ----------
    rig : Rig
    ovality_mm : float or None
        Greatest minus least width of a section that the product may have; None: what is usual of hot-rolled rounds.

    Raises
    ------
    ValueError
        The rig has no world frame, or a camera does not see the measuring region.
    """

    def __init__(self, rig: Rig, ovality_mm: float | None = None) -> None:
        if not rig.has_world:
            raise ValueError("the rig has no world frame: calibrate with the registration pictures of the low board")
        self.rig = rig
        self._ovality_mm = ovality_mm
        self._decoder = Decoder(rig.response)
        self._views = [
            _View(
                camera,
                RegionGrid(camera, rig.region_y_mm),
                LimbFinder(index, camera, self._decoder, rig.region_y_mm),
            )
            for index, camera in enumerate((rig.left, rig.right))
        ]
        self._beside = ThreadPoolExecutor(1)  # one view there, the other one here

    def measure(self, left: SentPicture | Codes, right: SentPicture | Codes) -> SizeReading:
        """Diameter of the bar in one pair of pictures.

        Parameters
        ----------
        left, right : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
            As they were sent; code values alone are grey or blue-green-red, all their bits used.

        Returns
        -------
        SizeReading
            Without a value: `no_bar`, `one_camera`, `several_bars`, `bar_too_short`, `edge_not_found`,
            `edges_clipped`, `no_windows` (edge points in one window alone), `fit_failed`, `views_disagree`,
            `implausible`. With a value: `some_edges_clipped`,
            `low_contrast`, `few_windows`, `limb_hidden`, `bar_head`, `bar_tail`, `shimmer`.

        Raises
        ------
        ValueError
            A picture is not of 8 or 16 bit, not grey or three-channel, or not of the size that the rig was calibrated
            for.
        """
        pictures = checked_pair(self.rig, left, right)
        found = self.find(*pictures)
        return SizeReading(reasons=found) if isinstance(found, Reason) else self.measure_bar(*pictures, found)

    def find(self, left: SentPicture, right: SentPicture) -> tuple[Outline, Outline] | Reason:
        """Where the one bar is in each view, roughly, or why there is none to be measured.

        Parameters
        ----------
        left, right : SentPicture
            Of the rig's size.

        Returns
        -------
        tuple of two Outline, or Reason
            `no_bar`, `one_camera`, `several_bars`.
        """
        return one_bar(self.outlines(left, right))

    def outlines(self, left: SentPicture, right: SentPicture) -> tuple[list[Outline], list[Outline]]:
        """Every bar that each view shows, roughly, from smaller x; the pictures have the rig's size."""
        shown = left.shown, right.shown
        return self._both(lambda index: self._views[index].grid.bars(shown[index], self._decoder.shown))

    def measure_bar(
        self,
        left: SentPicture,
        right: SentPicture,
        outlines: tuple[Outline, Outline],
        turns: tuple[CameraTurn, CameraTurn] = NO_TURNS,
        *,
        synchronous: bool = False,
    ) -> SizeReading:
        """Diameter of a bar that `find` found; reasons and errors as in `measure`.

        Parameters
        ----------
        left, right : SentPicture
            Of the rig's size.
        outlines : tuple of two Outline
        turns : tuple of two CameraTurn
            How each camera has turned since its calibration.
        synchronous : bool
            Whether time stamps prove that both cameras exposed together.

        Returns
        -------
        SizeReading
        """
        pictures = left, right
        rough = self._both(lambda index: self._views[index].rough_limbs(pictures[index], outlines[index]))
        planes = self._planes([*rough[0], *rough[1]])
        cylinder = rough_cylinder([plane for plane in planes if plane is not None])
        if cylinder is None:
            return SizeReading(reasons=Reason.EDGE_NOT_FOUND)
        limbs = self._limbs(pictures, planes, cylinder)
        shown = _shown(limbs)
        reasons = _reasons_of_limbs(limbs, shown)
        if reasons.forbids_value:
            return _with_light(SizeReading(reasons=reasons), limbs)
        known = Circumstances(self._ovality_mm, turns, synchronous)
        return _with_light(self._read([limbs[index] for index in shown], cylinder, reasons, known), limbs)

    def _both(self, work: Callable[[int], Result]) -> tuple[Result, Result]:
        """Work for both views at the same time."""
        left = self._beside.submit(work, 0)
        right = work(1)
        return left.result(), right

    def _planes(self, rough: list[RoughLimb]) -> list[TangentPlane | None]:
        """Tangent planes of the four limbs; None for those that are hidden."""
        least = HIDDEN_SHARE * max(limb.seen for limb in rough)
        return [
            TangentPlane.through(self._views[index // 2].camera.centre_mm, limb.line, LIMB_SIDES[index % 2])
            if limb.seen > least
            else None
            for index, limb in enumerate(rough)
        ]

    def _limbs(
        self, pictures: tuple[SentPicture, SentPicture], planes: list[TangentPlane | None], cylinder: Array
    ) -> list[LimbPoints]:
        """Edge points of the four limbs; a hidden limb is searched where the other three predict it."""
        region = np.array(self.rig.region_y_mm)

        def of_view(index: int) -> list[LimbPoints]:
            view, limbs = self._views[index], []
            for place, side in enumerate(LIMB_SIDES):
                plane = planes[2 * index + place]
                plane = plane or TangentPlane.touching(view.camera.centre_mm, cylinder, side)
                first_mm, last_mm = np.sort(plane.places_mm(cylinder, region)).tolist()
                limbs.append(view.finder.finely(pictures[index], plane.line, side, (first_mm, last_mm)))
            return limbs

        left, right = self._both(of_view)
        return left + right

    def _stations(self, limb: LimbPoints, cylinder: Array) -> Array:
        plane = TangentPlane.touching(self._views[limb.view].camera.centre_mm, cylinder, limb.side)
        return plane.stations_mm(cylinder, limb.place_mm)

    def _read(self, limbs: list[LimbPoints], cylinder: Array, reasons: Reason, known: Circumstances) -> SizeReading:
        region = self.rig.region_y_mm
        total = max(1, round((region[1] - region[0]) / WINDOW_MM))
        stations = [self._stations(limb, cylinder) for limb in limbs]
        points = EdgePoints.from_limbs(limbs, stations, region[0], WINDOW_MM)
        rig = _turned(self.rig, known.turns)
        rays = points.rays(rig)
        start = cylinder if rig is self.rig else nearest_cylinder(rays, cylinder)
        bent = fit_bent_cylinder(points, rays, start, (region[1] - region[0]) / 2)
        if bent is None:
            return SizeReading(reasons=reasons | Reason.FIT_FAILED)
        fit = bent.fit
        if not np.isfinite(fit.u_diameter_mm):
            return SizeReading(reasons=reasons | Reason.NO_WINDOWS, windows_total=total)
        window_px = points.window_medians(fit.residual_px, total)
        kept = int(np.count_nonzero(np.all(np.abs(window_px) <= WINDOW_AGREEMENT_PX, axis=0)))
        wander_px = _wander_px(window_px)
        reasons |= _reasons_of_fit(fit, window_px, region) | _reasons_of_ends(fit, points, region)
        reasons |= Reason.FEW_WINDOWS if 2 * kept < total else Reason.NONE
        reasons |= Reason.SHIMMER if wander_px > MOST_WANDER_PX else Reason.NONE
        if reasons.forbids_value:
            return SizeReading(reasons=reasons, windows_kept=kept, windows_total=total)
        section = section_view(fit, points, bent.rays)
        budget = uncertainty_budget(fit, points, rig, limbs, section=section, known=known)
        return replace(
            _reading(bent, budget, reasons, kept, total),
            wander_px=wander_px,
            width_left_mm=_width_mm(fit, points, 0),
            width_right_mm=_width_mm(fit, points, 1),
        )


def one_bar(outlines: tuple[list[Outline], list[Outline]]) -> tuple[Outline, Outline] | Reason:
    """The one bar that both views show, or why there is none: `no_bar`, `one_camera`, `several_bars`."""
    count = [len(view) for view in outlines]
    if max(count) == 0:
        return Reason.NO_BAR
    if min(count) == 0:
        return Reason.ONE_CAMERA
    return Reason.SEVERAL_BARS if max(count) > 1 else (outlines[0][0], outlines[1][0])


def _turned(rig: Rig, turns: tuple[CameraTurn, CameraTurn]) -> Rig:
    """The rig with its cameras as they stand now."""
    if all(turn is NO_TURN for turn in turns):
        return rig
    return replace(rig, left=rig.left.turned(turns[0].omega), right=rig.right.turned(turns[1].omega))


def _wander_px(window_px: Array) -> float:
    """Root of the covariance of neighbouring windows, over all limbs: what displaces them together.

    How far a limb lies off as a whole, as those of a section that is not round do, is no part of it.
    """
    away_px = window_px - np.nanmean(window_px, axis=1, keepdims=True)
    products = away_px[:, 1:] * away_px[:, :-1]
    return float(np.sqrt(max(np.nanmean(products), 0.0))) if np.isfinite(products).any() else 0.0


def _width_mm(fit: CylinderFit, points: EdgePoints, view: int) -> float:
    """Width across a view's line of sight: the diameter and how far its two limbs lie outside; NaN with one limb."""
    agreeing = (points.view == view) & (fit.weight > 0)
    sides = [agreeing & (points.side == side) for side in LIMB_SIDES]
    if not all(side.any() for side in sides):
        return float("nan")
    return fit.diameter_mm + sum(median(fit.residual_px[one] / fit.pixel_per_mm[one]) for one in sides)


def _with_light(reading: SizeReading, limbs: list[LimbPoints]) -> SizeReading:
    """Add the limbs' exposure to a reading, with a value or without."""
    bright = [median(limb.bright) for limb in limbs if len(limb.bright)]
    return replace(
        reading,
        clipped_share=max(limb.clipped_share for limb in limbs),
        limb_light=min(bright, default=float("nan")),
    )


def _shown(limbs: list[LimbPoints]) -> list[int]:
    """Numbers of the limbs that show enough of the bar."""
    share = np.array([len(limb.place_mm) / limb.tried for limb in limbs])
    enough = (share >= HIDDEN_SHARE * share.max()) & np.array([len(limb.place_mm) >= LEAST_POINTS for limb in limbs])
    return np.flatnonzero(enough).tolist()


def _reasons_of_limbs(limbs: list[LimbPoints], shown: list[int]) -> Reason:
    reasons = Reason.NONE
    if len(shown) < LEAST_LIMBS:
        lost = [limb for index, limb in enumerate(limbs) if index not in shown]
        clipped = any(limb.clipped_share > CLIPPED_MOST_SHARE for limb in lost)
        return Reason.EDGES_CLIPPED if clipped else Reason.EDGE_NOT_FOUND
    if len(shown) < len(limbs):
        reasons |= Reason.LIMB_HIDDEN
    for index in shown:
        if median(limbs[index].bright) < WEAK_CONTRAST * median(limbs[index].dark):
            reasons |= Reason.LOW_CONTRAST
    if any(limb.is_guess or limb.clipped_share > CLIPPED_FEW_SHARE for limb in limbs):
        reasons |= Reason.SOME_EDGES_CLIPPED
    return reasons


def _reasons_of_ends(fit: CylinderFit, points: EdgePoints, region_y_mm: tuple[float, float]) -> Reason:
    """Reasons for a bar that ends in the region, or covers too little of it."""
    edges = np.arange(region_y_mm[0], region_y_mm[1] + END_BIN_MM / 2, END_BIN_MM)
    good = np.abs(fit.residual_px) < END_AGREEMENT_PX
    limbs = [points.station_mm[good & (points.limb == limb)] for limb in range(points.limb.max() + 1)]
    showing = np.sum([np.histogram(stations, edges)[0] > 0 for stations in limbs], axis=0)
    shown, sure = np.flatnonzero(showing), np.flatnonzero(showing >= LEAST_LIMBS_AT_END)
    if not sure.size:
        return Reason.EDGE_NOT_FOUND
    first_mm, last_mm = edges[shown[0]], edges[shown[-1] + 1]
    reasons = Reason.NONE
    if last_mm < region_y_mm[1] - END_MARGIN_MM:
        reasons |= Reason.BAR_HEAD
    if first_mm > region_y_mm[0] + END_MARGIN_MM:
        reasons |= Reason.BAR_TAIL
    if edges[sure[-1]] - edges[sure[0]] < COVERED_SHARE * (region_y_mm[1] - region_y_mm[0]):
        reasons |= Reason.BAR_TOO_SHORT
    return reasons


def _reasons_of_fit(fit: CylinderFit, window_px: Array, region_y_mm: tuple[float, float]) -> Reason:
    _, z0, _, slope_z, radius_mm = fit.parameters
    reasons = Reason.NONE
    if max(abs(median_without_nan(limb_px)) for limb_px in window_px) > WORST_LIMB_PX:
        reasons |= Reason.VIEWS_DISAGREE
    end_mm = np.abs(np.array(region_y_mm) * slope_z + z0 - radius_mm).max()
    on_rollers = end_mm <= OFF_ROLLERS_SHARE * 2 * radius_mm + OFF_ROLLERS_MM
    if not (DIAMETER_MM[0] <= 2 * radius_mm <= DIAMETER_MM[1] and on_rollers):
        reasons |= Reason.IMPLAUSIBLE
    return reasons


def _reading(bent: BentCylinder, budget: Budget, reasons: Reason, kept: int, total: int) -> SizeReading:
    fit = bent.fit
    x0, z0, _, _, _ = fit.parameters
    sagitta_mm2 = CAMBER_LENGTH_MM**2 / 8  # of the sagitta over the bow's second derivative
    return SizeReading(
        diameter_mm=fit.diameter_mm,
        expanded_uncertainty_mm=budget.expanded_mm,
        reasons=reasons,
        windows_kept=kept,
        windows_total=total,
        axis_height_mm=float(z0),
        offset_mm=float(x0),
        u_edge_mm=budget.edge_mm,
        u_calibration_mm=budget.calibration_mm,
        u_board_mm=budget.board_mm,
        u_light_mm=budget.light_mm,
        u_shape_mm=budget.shape_mm,
        u_model_mm=budget.model_mm,
        u_motion_mm=budget.motion_mm,
        camber_mm=sagitta_mm2 * bent.bow.per_mm,
        u_camber_mm=sagitta_mm2 * bent.bow.u_per_mm,
    )
