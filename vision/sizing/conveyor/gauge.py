"""Diameter of a bar between two barriers, from one camera that was never calibrated (the dissertation's chapter 3).

Its measure, eq. 3.3, is the bar's width on the barriers' plane. But the edges that are seen are tangents, and the bar
is nearer to the camera than the plane: for a bar of radius R on the conveyor, seen between the angles a - b and a + b
by a camera Z above it, sin b = R / d, and d cos a + R = Z, so R = Z sin b / (cos a + sin b). At 165 mm from 2.6 m that
is 5 mm less than eq. 3.3 says: the fixed error that the dissertation found and compensated.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.edges.shaded import shaded_crossings
from vision.geometry.robust_line import robust_line
from vision.light import CLIPPED_CODE
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.conveyor.bar_spans import LEAST_GAP_PX, bar_spans, hidden_bar, without_bar
from vision.sizing.conveyor.barriers import Barriers, across, crossed_columns, find_barriers, grey_light
from vision.sizing.conveyor.camera_view import (
    FOCAL_SHARE,
    U_BARRIER_HEIGHT_MM,
    U_CAMERA_HEIGHT_MM,
    U_FOCAL_SHARE,
    ConveyorReference,
    ConveyorView,
    conveyor_view,
    faces_disagree,
)
from vision.sizing.limits import CLIPPED_MOST_SHARE, COVERED_SHARE, FIRST_BLUR_PX

Array = NDArray[np.float64]
Plane = NDArray[np.float32]

PROFILE_OFFSETS_PX = np.arange(-9.0, 9.25, 0.25)  # across an edge of the bar, from the conveyor inwards
WINDOW_COUNT = 24  # chosen: windows along the bar
LEAST_WINDOWS_SHARE = 0.2  # chosen: with fewer windows there is no value (`no_windows`)
LINE_DISTANCE_PX = 1.0  # chosen: a row whose edge lies further off the bar's straight line is left out
# Budget (docs/methods/conveyor.md), standard uncertainties, all chosen:
U_EDGE_PX = 0.02  # of a whole limb or barrier: blur and halo that are not alike on both sides
U_SPACING_SHARE = 0.0005  # of W, relative
INTERVAL_95 = (0.025, 0.975)
LAW_PARTS = 16  # equally probable parts of the law of an assumed quantity (JCGM 101)
CLIPPED_LIGHT = (CLIPPED_CODE - 0.5) / 255  # linear light of an overexposed point: from code value 250 on
CAMERA_MOVED_PX = 0.3  # chosen: a barrier further from its place in the empty pictures; noise makes 0.03 px
MEDIAN_FACTOR = 1.2533  # standard error of a median over that of a mean, sqrt(pi / 2)


@dataclass(frozen=True, slots=True, eq=False)
class _Limb:
    line: Array
    rows: Array
    columns: Array


class ConveyorGauge:
    """Measures a bar between barriers.

    Parameters
    ----------
    empty : sequence of ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Pictures of the line, without a bar or with one that leaves both barriers in view.
    reference : ConveyorReference
    compensation_mm : float
        Added to every diameter, as the dissertation does; 0 adds nothing.
    ovality_mm : float
        Greatest minus least width that a section may have.
    near_columns : tuple of float, optional
        As for `find_barriers`.
    response_exponent : float
        Code values follow light to this power. A response of 0.8 that is taken for 1 moves each edge of a bar by some
        0.15 px outwards.

    Attributes
    ----------
    barriers : Barriers or Reason
        As `find_barriers` returns them.

    Raises
    ------
    ValueError
        There is no picture, or pictures differ in size; the compensation is not finite; the response's exponent is
        not above 0.
    """

    def __init__(
        self,
        empty: list[NDArray[np.uint8]],
        reference: ConveyorReference,
        compensation_mm: float = 0.0,
        ovality_mm: float = 0.0,
        *,
        near_columns: tuple[float, float] | None = None,
        response_exponent: float = 1.0,
    ) -> None:
        if not empty or len({picture.shape[:2] for picture in empty}) != 1:
            raise ValueError("empty: at least one picture of the empty line is wanted, all of one size")
        if not np.isfinite(compensation_mm):
            raise ValueError(f"compensation_mm is {compensation_mm}; a number of millimetres is wanted")
        if not 0 < response_exponent < np.inf:
            raise ValueError(f"response_exponent is {response_exponent}; a number above 0 is wanted")
        self._response_exponent = response_exponent
        self._empty: Plane = np.asarray(np.mean([self._light(picture) for picture in empty], axis=0), np.float32)
        self._compensation_mm = compensation_mm
        self._u_shape_mm = float(ovality_mm / np.sqrt(12))
        self.barriers = find_barriers(self._empty, near_columns)
        if isinstance(self.barriers, Barriers):
            self._lens = self.barriers.lens
            self._without_bar = without_bar(self.barriers)
            self._view = conveyor_view(self.barriers, reference)
            self._changed = _changed_views(self.barriers, reference, self._view)
            self._assumed = _assumed_views(self.barriers, reference, self._view)
            self._faces_disagree = faces_disagree(self.barriers, reference, self._view)
            self._barriers_px = float(self.barriers.width_px(np.array([len(self._empty) / 2]))[0])

    def measure(self, picture: NDArray[np.uint8]) -> SizeReading:
        """Diameter of the bar in a picture.

        Parameters
        ----------
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
            Coded as `response_exponent` says, of the size of the empty ones.

        Returns
        -------
        SizeReading
            Without a value: `edge_not_found` (with `barrier_hidden` or `barrier_bent` where it is a barrier's),
            `no_bar`, `several_bars`, `bar_too_short`, `edges_clipped`, `no_windows`; `camera_moved` when a barrier
            stands more than `CAMERA_MOVED_PX` from its place in the empty pictures; `implausible` with
            `barrier_height` when the barriers' faces contradict the heights that are given; `edge_not_found` with
            `low_contrast` where a bar is no lighter than the empty line. With a value: `routes_disagree` when the
            diameter changes along the line by more than U, as of a bar with one end lifted.

        Raises
        ------
        ValueError
            The picture has another size than the empty ones.
        """
        if picture.shape[:2] != self._empty.shape:
            raise ValueError(f"picture: {picture.shape[:2]} rows and columns, the empty line has {self._empty.shape}")
        if not isinstance(self.barriers, Barriers):
            return _nothing(Reason.EDGE_NOT_FOUND | self.barriers)
        if self._faces_disagree:
            return _nothing(Reason.IMPLAUSIBLE | Reason.BARRIER_HEIGHT)
        light = self.barriers.lens.straightened(self._light(picture))
        spans = bar_spans(light, self._without_bar)
        if isinstance(spans, Reason):
            return _nothing(hidden_bar(light, self._without_bar) if spans is Reason.NO_BAR else spans)
        left, right = (_limb(light, spans, side) for side in (0, 1))
        if left is None or right is None or _touches(left, right, self.barriers):
            return _nothing(Reason.EDGE_NOT_FOUND)
        inside = [_inside(light, left, 1), _inside(light, right, -1)]
        limbs = {
            "clipped_share": max(float(np.mean(one >= CLIPPED_LIGHT)) for one in inside),
            "limb_light": min(float(np.median(one)) for one in inside),
        }
        reason = self._forbids(light, limbs["clipped_share"])
        return replace(_nothing(reason) if reason else self._read(left, right), **limbs)

    def _light(self, picture: NDArray[np.uint8]) -> Plane:
        return grey_light(picture, self._response_exponent)

    def _forbids(self, light: Plane, clipped_share: float) -> Reason:
        """Reasons that forbid a value although there is a bar with two edges."""
        if clipped_share >= CLIPPED_MOST_SHARE:
            return Reason.EDGES_CLIPPED
        assert isinstance(self.barriers, Barriers)  # noqa: S101  nothing is measured without
        shifted_px = self.barriers.shifted_px(light)
        if shifted_px is None:
            return Reason.EDGE_NOT_FOUND | Reason.BARRIER_HIDDEN
        return Reason.CAMERA_MOVED if shifted_px > CAMERA_MOVED_PX else Reason.NONE

    def _read(self, left: _Limb, right: _Limb) -> SizeReading:
        windows = np.array_split(np.intersect1d(left.rows, right.rows), WINDOW_COUNT)
        ends = [_ends(limb, windows) for limb in (left, right)]
        there = np.isfinite(ends[0][:, 0]) & np.isfinite(ends[1][:, 0])
        if np.count_nonzero(there) < LEAST_WINDOWS_SHARE * WINDOW_COUNT:
            return _nothing(Reason.NO_WINDOWS)
        ends = [end[there] for end in ends]
        view = self._view
        by_window = diameters_mm(view, *ends)
        diameter_mm = float(np.median(by_window))
        calibration_mm, model_mm = self._u_of_view(ends, diameter_mm)
        correction_mm, u_assumed_mm = self._assumed_law(ends, diameter_mm)
        diameter_mm += correction_mm
        model_mm = float(np.hypot(model_mm, u_assumed_mm))
        edge_mm = float(MEDIAN_FACTOR * by_window.std() / np.sqrt(len(by_window)))
        expanded_mm = float(2 * np.linalg.norm([edge_mm, calibration_mm, self._u_shape_mm, model_mm]))
        middle = 0.5 * (view.tangent(ends[0]) + view.tangent(ends[1]))
        rows = np.mean([end[:, 1] for end in ends], axis=0)
        changes = _change_along(rows, by_window) > expanded_mm
        return SizeReading(
            reasons=Reason.ROUTES_DISAGREE if changes else Reason.NONE,
            diameter_mm=diameter_mm + self._compensation_mm,
            expanded_uncertainty_mm=expanded_mm,
            windows_kept=int(np.count_nonzero(there)),
            windows_total=WINDOW_COUNT,
            offset_mm=float(np.median(middle) * view.camera_height_mm),
            u_edge_mm=edge_mm,
            u_calibration_mm=calibration_mm,
            u_board_mm=0.0,
            u_light_mm=0.0,
            u_shape_mm=self._u_shape_mm,
            u_model_mm=model_mm,
            method="conveyor",
        )

    def _u_of_view(self, ends: list[Array], diameter_mm: float) -> tuple[float, float]:
        """Standard uncertainties from the ruler, and from the heights and the camera's place."""
        width_px = abs(float(np.mean(ends[1][:, 0] - ends[0][:, 0])))
        edges = diameter_mm * np.sqrt(2) * U_EDGE_PX / width_px
        ruler = diameter_mm * np.hypot(np.sqrt(2) * U_EDGE_PX, self._view.u_width_px) / self._barriers_px
        half = np.array([self._barriers_px, width_px]) / self._empty.shape[1]  # in half widths of the picture
        lens = diameter_mm * self._lens.u_bending * abs(float(half[0] ** 2 - half[1] ** 2))
        calibration = np.linalg.norm([ruler, U_SPACING_SHARE * diameter_mm, lens])
        changes = [float(np.median(diameters_mm(view, *ends))) - diameter_mm for view in self._changed]
        return float(calibration), float(np.linalg.norm([edges, *changes]))

    def _assumed_law(self, ends: list[Array], diameter_mm: float) -> tuple[float, float]:
        """Correction and standard uncertainty, mm, from assumed quantities, propagated as whole laws (JCGM 101).

        The correction leads to the middle of the interval that holds 95 % of the diameters; the uncertainty is that of
        a normal law whose interval is as wide.
        """
        summed = np.zeros(1)
        for views in self._assumed:
            changes = [float(np.median(diameters_mm(view, *ends))) - diameter_mm for view in views]
            summed = np.add.outer(summed, changes).ravel()
        low, high = np.quantile(summed, INTERVAL_95).tolist()
        return 0.5 * (low + high), 0.25 * (high - low)


def _change_along(row: Array, diameter_mm: Array) -> float:
    """Change of the diameter from the first to the last window by a straight line, less its expanded uncertainty."""
    place = (row - row.mean()) / np.ptp(row)
    slope = float(place @ diameter_mm / (place @ place))
    scatter = float(np.std(diameter_mm - diameter_mm.mean() - slope * place))
    return abs(slope) - 2 * scatter / float(np.sqrt(place @ place))


def _changed_views(barriers: Barriers, reference: ConveyorReference, view: ConveyorView) -> list[ConveyorView]:
    """Views with one measured quantity off by a standard uncertainty.

    The quantities are the given heights, and the camera's height and place by the barriers' faces where they show.
    """
    changed: list[ConveyorView] = []
    if (camera_mm := reference.camera_height_mm) is not None:
        higher = replace(reference, camera_height_mm=camera_mm + U_CAMERA_HEIGHT_MM)
        changed.append(conveyor_view(barriers, higher))
    if (barrier_mm := reference.barrier_height_mm) is not None and view.u_width_px > 0:
        lower = replace(reference, barrier_height_mm=barrier_mm - min(U_BARRIER_HEIGHT_MM, barrier_mm / 2))
        changed += [
            conveyor_view(barriers, lower),
            replace(view, above_plane_mm=view.above_plane_mm * (1 + view.u_height)),
            replace(view, across_mm=view.across_mm + view.u_across_mm),
        ]
    return changed


def _assumed_views(barriers: Barriers, reference: ConveyorReference, view: ConveyorView) -> list[list[ConveyorView]]:
    """Views over assumed quantities: for each, one in every equally probable part of its rectangular law."""
    if view.u_plane_mm == 0:
        return []
    places = np.sqrt(3) * (2 * (np.arange(LAW_PARTS) + 0.5) / LAW_PARTS - 1)  # in standard uncertainties
    edges_mm = view.plane_mm + places * view.u_plane_mm
    focal_shares = FOCAL_SHARE * (1 + places * U_FOCAL_SHARE)
    laws = [
        [conveyor_view(barriers, reference, edge_mm=float(edge_mm)) for edge_mm in edges_mm],
        [replace(view, across_mm=view.across_mm + place * view.u_across_mm) for place in places.tolist()],
    ]
    if reference.camera_height_mm is None:
        laws.append([conveyor_view(barriers, reference, float(share), view.plane_mm) for share in focal_shares])
    return laws


def diameters_mm(view: ConveyorView, left_px: Array, right_px: Array) -> Array:
    """Diameter of a round bar on the conveyor from points on its two edges.

    Parameters
    ----------
    view : ConveyorView
    left_px, right_px : ndarray of float64, shape (n, 2)
        (x, y), one pair for each section.

    Returns
    -------
    ndarray of float64, shape (n,)
        2 R = 2 Z sin b / (cos a + sin b).
    """
    first, second = np.arctan(view.tangent(left_px)), np.arctan(view.tangent(right_px))
    a, b = 0.5 * (first + second), 0.5 * np.abs(second - first)
    return 2 * view.camera_height_mm * np.sin(b) / (np.cos(a) + np.sin(b))


def _limb(light: Plane, spans: NDArray[np.int64], side: int) -> _Limb | None:
    """Edge of the bar at half level, row by row, around one straight line."""
    rows = np.flatnonzero(spans[:, 0] >= 0).astype(np.float64)
    line = robust_line(rows, spans[rows.astype(np.int64), side].astype(np.float64))
    inwards = 1 if side == 0 else -1
    for _ in range(2):  # the second time around the first one's line
        column, shows = _columns(light, line, inwards, rows)
        if np.count_nonzero(shows) < COVERED_SHARE * len(rows):
            return None
        line = robust_line(rows[shows], column[shows])
    column, shows = _columns(light, line, inwards, rows)
    near = shows & (np.abs(column - line[0] * rows - line[1]) <= LINE_DISTANCE_PX)
    return _Limb(line, rows[near], column[near]) if np.count_nonzero(near) >= COVERED_SHARE * len(rows) else None


def _columns(light: Plane, line: Array, inwards: int, rows: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Column of the edge in each row, and where there is a clear step of light."""
    found = shaded_crossings(across(light, line, inwards, rows, PROFILE_OFFSETS_PX), PROFILE_OFFSETS_PX, FIRST_BLUR_PX)
    if found is None:
        return np.full(len(rows), np.nan), np.zeros(len(rows), dtype=np.bool_)
    return crossed_columns(found.crossings, line, inwards, rows)


def _touches(left: _Limb, right: _Limb, barriers: Barriers) -> bool:
    rows = np.array([left.rows.min(), left.rows.max()])
    edges = barriers.columns(rows)
    free = [left.line[0] * rows + left.line[1] - edges[:, 0], edges[:, 1] - right.line[0] * rows - right.line[1]]
    return bool(np.min(free) < LEAST_GAP_PX)


def _inside(light: Plane, limb: _Limb, inwards: int) -> Array:
    """Light of the bar just inside an edge, row by row."""
    column = np.clip(np.rint(limb.columns + 5 * inwards), 0, light.shape[1] - 1).astype(np.int64)
    return np.asarray(light[limb.rows.astype(np.int64), column], np.float64)


def _ends(limb: _Limb, windows: list[Array]) -> Array:
    """Mean point (x, y) of an edge in each window, NaN where it shows nothing; y is that of the window."""
    column = dict(zip(limb.rows.tolist(), limb.columns.tolist(), strict=True))
    return np.array(
        [[np.mean([column[row] for row in part]), part.mean()] if len(part) else [np.nan, np.nan] for part in windows]
    )


def _nothing(reason: Reason) -> SizeReading:
    return SizeReading(reasons=reason, windows_total=WINDOW_COUNT, method="conveyor")
