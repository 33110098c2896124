"""Route T: the diameter of the bar from the tangent planes of both views.

Each view shows the bar's two limbs (edges of the bar) as straight lines. Every edge ray grazes the bar, so one cylinder
fits them all; the scatter of the points gives its covariance (docs/methods/diameter.md).
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from vision.calibration.camera_turn import NO_TURN, CameraTurn
from vision.calibration.rig import Rig
from vision.geometry.camera import Camera
from vision.geometry.surface_point import SurfacePoint
from vision.light_planes import Decoder
from vision.order_statistics import median
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sent_picture import Codes, SentPicture
from vision.sizing.checked_pictures import checked_pair
from vision.sizing.limits import LEAST_POINTS, LIMB_SIDES
from vision.sizing.region_grid import Outline, RegionGrid
from vision.sizing.tangent.bent_cylinder import UNSEEN_BOW, BentCylinder, fit_bent_cylinder
from vision.sizing.tangent.cylinder_fit import CylinderFit, nearest_cylinder
from vision.sizing.tangent.edge_points import EdgePoints
from vision.sizing.tangent.limb_finder import LimbFinder, LimbPoints, RoughLimb
from vision.sizing.tangent.range_fusion import cylinder_of_one_view, fit_with_point, of_one_view, of_two_views
from vision.sizing.tangent.reading_reasons import reasons_of_ends, reasons_of_fit, reasons_of_limbs
from vision.sizing.tangent.tangent_planes import TangentPlane, rough_cylinder
from vision.sizing.tangent.uncertainty_budget import Budget, Circumstances, Solution, uncertainty_budget

Array = NDArray[np.float64]
Result = TypeVar("Result")

WINDOW_MM = 20.0  # chosen: length of a window, a strip along the bar; points within one may be correlated
WINDOW_AGREEMENT_PX = 0.5  # chosen: a window is kept if the median residual of every limb in it is at most half a pixel
HIDDEN_SHARE = 0.4  # chosen: a limb with less than 40 % of the best limb's share of edge points counts as hidden
LEAST_LIMBS = 3  # three tangent planes fix the cylinder
LIMBS_OF_ONE_VIEW = 2  # which fix it with a point of the surface
MOST_WANDER_PX = 0.2  # chosen: beyond it hot air decides the uncertainty, and the reading is `shimmer`
SAGITTA_MM2 = 1000.0**2 / 8  # of the sagitta over 1 m, by which camber is stated, over the bow's second derivative
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
        point: SurfacePoint | None = None,
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
        point : SurfacePoint or None
            Where a laser meets the bar. One that contradicts the views is not used: `routes_disagree`.

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
        reasons = reasons_of_limbs(limbs, shown, LEAST_LIMBS)
        if reasons.forbids_value:
            return _with_light(SizeReading(reasons=reasons), limbs)
        known = Circumstances(self._ovality_mm, turns, synchronous, point)
        return _with_light(self._read([limbs[index] for index in shown], cylinder, reasons, known), limbs)

    def measure_one_view(
        self,
        view: int,
        picture: SentPicture,
        outline: Outline,
        point: SurfacePoint,
        turns: tuple[CameraTurn, CameraTurn] = NO_TURNS,
    ) -> SizeReading:
        """Diameter of a bar that only one camera shows, by its two limbs and a laser's point.

        Parameters
        ----------
        view : int
            0 left, 1 right.
        picture : SentPicture
        outline : Outline
            Of the bar, roughly.
        point : SurfacePoint
            Where the laser meets the bar.
        turns : tuple of two CameraTurn
            How each camera has turned since its calibration.

        Returns
        -------
        SizeReading
            With a value always `limb_hidden`, and `method` is "range"; without one reasons as in `measure`, and
            `one_camera` where the beam does not meet the bar.
        """
        own = self._views[view]
        rough = own.rough_limbs(picture, outline)
        planes = [
            TangentPlane.through(own.camera.centre_mm, limb.line, side)
            for limb, side in zip(rough, LIMB_SIDES, strict=True)
        ]
        cylinder = cylinder_of_one_view(planes, point)
        if cylinder is None:
            return SizeReading(reasons=Reason.ONE_CAMERA)
        limbs = self._limbs_of_view(view, picture, planes, cylinder)
        shown = _shown(limbs)
        reasons = reasons_of_limbs(limbs, shown, LIMBS_OF_ONE_VIEW) | Reason.LIMB_HIDDEN
        if reasons.forbids_value:
            return _with_light(SizeReading(reasons=reasons), limbs)
        known = Circumstances(self._ovality_mm, turns, point=point)
        return replace(_with_light(self._read(limbs, cylinder, reasons, known), limbs), method="range")

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
        left, right = self._both(
            lambda view: self._limbs_of_view(view, pictures[view], planes[2 * view :][:2], cylinder)
        )
        return left + right

    def _limbs_of_view(
        self, index: int, picture: SentPicture, planes: Sequence[TangentPlane | None], cylinder: Array
    ) -> list[LimbPoints]:
        region = np.array(self.rig.region_y_mm)
        view, limbs = self._views[index], []
        for seen, side in zip(planes, LIMB_SIDES, strict=True):
            plane = seen or TangentPlane.touching(view.camera.centre_mm, cylinder, side)
            first_mm, last_mm = np.sort(plane.places_mm(cylinder, region)).tolist()
            limbs.append(view.finder.finely(picture, plane.line, side, (first_mm, last_mm)))
        return limbs

    def _stations(self, limb: LimbPoints, cylinder: Array) -> Array:
        plane = TangentPlane.touching(self._views[limb.view].camera.centre_mm, cylinder, limb.side)
        return plane.stations_mm(cylinder, limb.place_mm)

    def _read(self, limbs: list[LimbPoints], cylinder: Array, reasons: Reason, known: Circumstances) -> SizeReading:
        region = self.rig.region_y_mm
        total = max(1, round((region[1] - region[0]) / WINDOW_MM))
        stations = [self._stations(limb, cylinder) for limb in limbs]
        points = EdgePoints.from_limbs(limbs, stations, region[0], WINDOW_MM)
        rig = _turned(self.rig, known.turns)
        found = self._fitted(points, rig, cylinder, known)
        if found is None:
            return SizeReading(reasons=reasons | Reason.FIT_FAILED)
        bent, shift = found
        fit = bent.fit
        if not np.isfinite(fit.u_diameter_mm):
            return SizeReading(reasons=reasons | Reason.NO_WINDOWS, windows_total=total)
        window_px = points.window_medians(fit.residual_px, total)
        kept = int(np.count_nonzero(np.all(np.abs(window_px) <= WINDOW_AGREEMENT_PX, axis=0)))
        wander_px = _wander_px(window_px)
        reasons |= reasons_of_fit(fit, window_px, region) | reasons_of_ends(fit, points, region)
        reasons |= Reason.FEW_WINDOWS if 2 * kept < total else Reason.NONE
        reasons |= Reason.SHIMMER if wander_px > MOST_WANDER_PX else Reason.NONE
        if reasons.forbids_value:
            return SizeReading(reasons=reasons, windows_kept=kept, windows_total=total)
        if shift is None:
            known = known if _covers_region(reasons) else replace(known, point=None)
            solution = of_two_views(bent, points, rig, limbs, known)
        else:
            solution = of_one_view(bent, points, known, shift)
        reasons |= Reason.NONE if solution.agrees else Reason.ROUTES_DISAGREE
        budget = uncertainty_budget(solution, points, rig, limbs, known)
        return replace(
            _reading(solution, budget, reasons, kept, total),
            camber_mm=SAGITTA_MM2 * bent.bow.per_mm,
            u_camber_mm=SAGITTA_MM2 * bent.bow.u_per_mm,
            wander_px=wander_px,
            width_left_mm=_width_mm(fit, points, 0),
            width_right_mm=_width_mm(fit, points, 1),
        )

    def _fitted(
        self, points: EdgePoints, rig: Rig, cylinder: Array, known: Circumstances
    ) -> tuple[BentCylinder, Array | None] | None:
        """The cylinder of all limbs; of one view's with what a millimetre of the laser's point changes, else None."""
        rays, region = points.rays(rig), self.rig.region_y_mm
        if np.ptp(points.view) == 0 and known.point is not None:
            fitted = fit_with_point(rays, cylinder, known.point)
            return None if fitted is None else (BentCylinder(fitted[0], rays, UNSEEN_BOW), fitted[1])
        start = cylinder if rig is self.rig else nearest_cylinder(rays, cylinder)
        bent = fit_bent_cylinder(points, rays, start, (region[1] - region[0]) / 2)
        return None if bent is None else (bent, None)


def _covers_region(reasons: Reason) -> bool:
    """Whether the bar surely lies where the laser meets it."""
    return not reasons & (Reason.BAR_HEAD | Reason.BAR_TAIL)


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


def _reading(solution: Solution, budget: Budget, reasons: Reason, kept: int, total: int) -> SizeReading:
    fit = solution.fit
    x0, z0, _, _, _ = fit.parameters
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
        u_range_mm=budget.range_mm,
        range_gap_mm=solution.gap_mm,
    )
