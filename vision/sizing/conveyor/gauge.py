"""Diameter of a bar between two barriers, from one camera that was never calibrated (the dissertation's chapter 3).

Its measure, eq. 3.3, is the bar's width on the barriers' plane. But the edges that are seen are tangents, and the bar
is nearer to the camera than the plane: for a bar of radius R on the conveyor, seen between the angles a - b and a + b
by a camera Z above it, sin b = R / d, and d cos a + R = Z, so R = Z sin b / (cos a + sin b). At 165 mm from 2.6 m that
is 5 mm less than eq. 3.3 says: the fixed error that the dissertation found and compensated.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from vision.compression import compression_shift_px, correlated_px, quantiser_step, step_codes, u_place_px
from vision.edges.shaded import ShadedCrossings, shaded_crossings
from vision.geometry.robust_line import robust_line
from vision.light import CLIPPED_CODE, ResponseCurve, half_level_doubts_px, half_level_shift_px
from vision.light_planes import Decoder
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sent_picture import Codes, Coding, SentPicture
from vision.sizing.conveyor.bar_spans import LEAST_GAP_PX, bar_spans, hidden_bar, without_bar
from vision.sizing.conveyor.barriers import Barriers, across, crossed_columns, find_barriers
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.grey_light import grey_light
from vision.sizing.conveyor.scale import Scale, diameters_mm
from vision.sizing.limits import CLIPPED_MOST_SHARE, COVERED_SHARE, FIRST_BLUR_PX

Array = NDArray[np.float64]
Plane = NDArray[np.float32]

PROFILE_OFFSETS_PX = np.arange(-9.0, 9.25, 0.25)  # across an edge of the bar, from the conveyor inwards
WINDOW_COUNT = 24  # chosen: windows along the bar
LEAST_WINDOWS_SHARE = 0.2  # chosen: with fewer windows there is no value (`no_windows`)
LINE_DISTANCE_PX = 1.0  # chosen: a row whose edge lies further off the bar's straight line is left out
CLIPPED_LIGHT = (CLIPPED_CODE - 0.5) / 255  # linear light of an overexposed point: from code value 250 on
CAMERA_MOVED_PX = 0.3  # chosen: a barrier further from its place in the empty pictures; noise makes 0.03 px
# Chosen on simulated lines other than those of docs/studies/coded_conveyor.json, where U holds with it: coders flatten
# the fall of light towards a limb, which then lies further off than the edge of a straight step.
CODED_LIMB_FACTOR = 1.2
U_EXPONENT = 0.02  # chosen: standard uncertainty of a response's exponent that is given
MEDIAN_FACTOR = 1.2533  # standard error of a median over that of a mean, sqrt(pi / 2)


@dataclass(frozen=True, slots=True, eq=False)
class _Limb:
    """One edge of the bar: its line, its rows and their columns; light beside and on the bar, and the edge's blur."""

    line: Array
    rows: Array
    columns: Array
    levels: tuple[Array, Array]
    blur_px: float


class ConveyorGauge:
    """Measures a bar between barriers.

    Parameters
    ----------
    empty : sequence of SentPicture, or of ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
        Pictures of the line, without a bar or with one that leaves both barriers in view.
    reference : ConveyorReference
    compensation_mm : float
        Added to every diameter, as the dissertation does; 0 adds nothing.
    ovality_mm : float
        Greatest minus least width that a section may have.
    near_columns : tuple of float, optional
        As for `find_barriers`.
    response_exponent : float or None
        Code values follow light to this power; 1 of a linear camera. One that is given, other than 1, counts as known
        to `U_EXPONENT`. None, not known: the camera is taken for a linear one, and U covers what a camera of sRGB
        would make of the bar's edges; a response of 0.8 that is taken for 1 moves each by some 0.15 px outwards.

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
        empty: Sequence[SentPicture | Codes],
        reference: ConveyorReference,
        compensation_mm: float = 0.0,
        ovality_mm: float = 0.0,
        *,
        near_columns: tuple[float, float] | None = None,
        response_exponent: float | None = None,
    ) -> None:
        pictures = [SentPicture.of(picture) for picture in empty]
        if len({picture.size for picture in pictures}) != 1:
            raise ValueError("empty: at least one picture of the empty line is wanted, all of one size")
        if not np.isfinite(compensation_mm):
            raise ValueError(f"compensation_mm is {compensation_mm}; a number of millimetres is wanted")
        if response_exponent is not None and not 0 < response_exponent < np.inf:
            raise ValueError(f"response_exponent is {response_exponent}; a number above 0 is wanted")
        self._response_is_known = response_exponent is not None
        self._response_exponent = 1.0 if response_exponent is None else response_exponent
        self._response = _told_response(self._response_exponent)
        self._decoder = Decoder(self._response)
        self._coding = max((picture.coding for picture in pictures), key=quantiser_step)
        self._empty: Plane = np.asarray(np.mean([self._light(picture) for picture in pictures], axis=0), np.float32)
        self._compensation_mm = compensation_mm
        self._u_shape_mm = float(ovality_mm / np.sqrt(12))
        self.barriers = find_barriers(self._empty, near_columns)
        if isinstance(self.barriers, Barriers):
            self._without_bar = without_bar(self.barriers)
            self._scale = cache(partial(_scale, self.barriers, reference))
            self._scale(correlated_px(self._coding))

    def measure(self, picture: SentPicture | Codes) -> SizeReading:
        """Diameter of the bar in a picture.

        Parameters
        ----------
        picture : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
            Coded as `response_exponent` says, of the size of the empty ones.

        Returns
        -------
        SizeReading
            Without a value: `edge_not_found` (with `barrier_hidden` or `barrier_bent` where it is a barrier's),
            `no_bar`, `several_bars`, `bar_too_short`, `edges_clipped`, `no_windows`; `camera_moved` when a barrier
            stands more than `CAMERA_MOVED_PX` from its place in the empty pictures; `implausible` with
            `barrier_height` when the barriers' faces contradict the heights that are given; `edge_not_found` with
            `low_contrast` where a bar is no lighter than the empty line. With a value: `routes_disagree` when the
            diameter changes along the line by more than U, as of a bar with one end lifted, and with `barrier_height`
            when the barriers' faces are narrower than those of walls of that height.

        Raises
        ------
        ValueError
            The picture has another size than the empty ones.
        """
        sent = SentPicture.of(picture)
        if sent.shown.shape[:2] != self._empty.shape:
            raise ValueError(
                f"picture: {sent.shown.shape[:2]} rows and columns, the empty line has {self._empty.shape}"
            )
        if not isinstance(self.barriers, Barriers):
            return _nothing(Reason.EDGE_NOT_FOUND | self.barriers)
        # an empty line that was stored without loss may have been compressed by the same camera before
        coding = max(self._coding, sent.coding, key=quantiser_step)
        if self._scale(correlated_px(coding)).faces_disagree:
            return _nothing(Reason.IMPLAUSIBLE | Reason.BARRIER_HEIGHT)
        light = self.barriers.lens.straightened(self._light(sent))
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
        return replace(_nothing(reason) if reason else self._read((left, right), sent.coding, coding), **limbs)

    def _light(self, picture: SentPicture) -> Plane:
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

    def _read(self, limbs: tuple[_Limb, _Limb], coding: Coding, barriers_coding: Coding) -> SizeReading:
        windows = np.array_split(np.intersect1d(limbs[0].rows, limbs[1].rows), WINDOW_COUNT)
        ends = [_ends(limb, windows) for limb in limbs]
        there = np.isfinite(ends[0][:, 0]) & np.isfinite(ends[1][:, 0])
        if np.count_nonzero(there) < LEAST_WINDOWS_SHARE * WINDOW_COUNT:
            return _nothing(Reason.NO_WINDOWS)
        ends, u_light_px = self._uncompressed([end[there] for end in ends], limbs, coding)
        scale = self._scale(correlated_px(barriers_coding))
        view = scale.view
        by_window = diameters_mm(view, *ends)
        diameter_mm = float(np.median(by_window))
        calibration_mm, model_mm = scale.u_view_mm(ends, diameter_mm, self._u_barriers_px(barriers_coding))
        mm_per_px = diameter_mm / abs(float(np.mean(ends[1][:, 0] - ends[0][:, 0])))
        unknown_mm = mm_per_px * self._u_unknown_response_px(limbs)
        light_mm = float(np.hypot(mm_per_px * u_light_px, unknown_mm))
        edge_mm = float(MEDIAN_FACTOR * by_window.std() / np.sqrt(len(by_window)))
        other_mm = float(np.linalg.norm([edge_mm, calibration_mm, self._u_shape_mm, light_mm]))
        correction_mm, u_mm = scale.assumed_law_mm(ends, diameter_mm, float(np.hypot(other_mm, model_mm)))
        model_mm = float(np.sqrt(u_mm**2 - other_mm**2))
        diameter_mm += correction_mm
        expanded_mm = 2 * u_mm
        middle = 0.5 * (view.tangent(ends[0]) + view.tangent(ends[1]))
        rows = np.mean([end[:, 1] for end in ends], axis=0)
        # what is not known of the response moves both ends of the bar alike, and hides no change between them
        along_mm = 2 * float(np.sqrt(u_mm**2 - unknown_mm**2))
        doubts = Reason.ROUTES_DISAGREE if _change_along(rows, by_window) > along_mm else Reason.NONE
        if view.narrow_faces:
            doubts |= Reason.ROUTES_DISAGREE | Reason.BARRIER_HEIGHT
        return SizeReading(
            reasons=doubts,
            diameter_mm=diameter_mm + self._compensation_mm,
            expanded_uncertainty_mm=expanded_mm,
            windows_kept=int(np.count_nonzero(there)),
            windows_total=WINDOW_COUNT,
            offset_mm=float(np.median(middle) * view.camera_height_mm),
            u_edge_mm=edge_mm,
            u_calibration_mm=calibration_mm,
            u_board_mm=0.0,
            u_light_mm=light_mm,
            u_shape_mm=self._u_shape_mm,
            u_model_mm=model_mm,
            method="conveyor",
        )

    def _uncompressed(self, ends: list[Array], limbs: tuple[_Limb, _Limb], coding: Coding) -> tuple[list[Array], float]:
        """Ends of the bar moved back by what compression moved them, and u of the width by it and a given response."""
        plane = self._decoder.whole(coding)
        moved: list[Array] = []
        u_width_px = 0.0
        for end, limb, outwards in zip(ends, limbs, (-1, 1), strict=True):
            inwards_px, u_inwards_px = compression_shift_px(coding, plane, limb.levels, limb.blur_px)
            crossed_px = abs(limb.line[0]) * np.ptp(limb.rows)
            place_px = CODED_LIMB_FACTOR * u_place_px(coding, step_codes(coding, plane, limb.levels), crossed_px)
            response_px = half_level_doubts_px(self._response, limb.levels, limb.blur_px)
            u_width_px += float(np.linalg.norm([u_inwards_px, place_px, *response_px]))
            moved.append(end + np.array([outwards * inwards_px, 0.0]))
        return moved, u_width_px

    def _u_unknown_response_px(self, limbs: tuple[_Limb, _Limb]) -> float:
        """Standard uncertainty of the width by a response that was not given: U reaches to what sRGB makes of it."""
        if self._response_is_known:
            return 0.0
        return 0.5 * sum(half_level_shift_px("srgb", limb.levels, limb.blur_px) for limb in limbs)

    def _u_barriers_px(self, coding: Coding) -> float:
        """Standard uncertainty of a barrier's place by compression, of the one that leans less."""
        assert isinstance(self.barriers, Barriers)  # noqa: S101  nothing is measured without
        step = step_codes(coding, self._decoder.whole(coding), self.barriers.levels)
        return u_place_px(coding, step, float(np.abs(self.barriers.lines[:, 0]).min()) * len(self._empty))


def _told_response(exponent: float) -> ResponseCurve:
    """Light of code values that follow it to a power, which is known to `U_EXPONENT` unless the camera is linear."""
    u_inverse = 0.0 if exponent == 1.0 else U_EXPONENT / exponent**2
    return ResponseCurve(1 / exponent, covariance=np.diag([u_inverse, 0.0, 0.0]) ** 2)


def _scale(barriers: Barriers, reference: ConveyorReference, correlated_over_px: float) -> Scale:
    return Scale.of(replace(barriers, correlated_px=correlated_over_px), reference)


def _change_along(row: Array, diameter_mm: Array) -> float:
    """Change of the diameter from the first to the last window by a straight line, less its expanded uncertainty."""
    place = (row - row.mean()) / np.ptp(row)
    slope = float(place @ diameter_mm / (place @ place))
    scatter = float(np.std(diameter_mm - diameter_mm.mean() - slope * place))
    return abs(slope) - 2 * scatter / float(np.sqrt(place @ place))


def _limb(light: Plane, spans: NDArray[np.int64], side: int) -> _Limb | None:
    """Edge of the bar at half level, row by row, around one straight line."""
    rows = np.flatnonzero(spans[:, 0] >= 0).astype(np.float64)
    line = robust_line(rows, spans[rows.astype(np.int64), side].astype(np.float64))
    inwards = 1 if side == 0 else -1
    for _ in range(2):  # the second time around the first one's line
        column, shows, _ = _columns(light, line, inwards, rows)
        if np.count_nonzero(shows) < COVERED_SHARE * len(rows):
            return None
        line = robust_line(rows[shows], column[shows])
    column, shows, found = _columns(light, line, inwards, rows)
    near = shows & (np.abs(column - line[0] * rows - line[1]) <= LINE_DISTANCE_PX)
    if found is None or np.count_nonzero(near) < COVERED_SHARE * len(rows):
        return None
    levels = found.crossings.dark[near], found.crossings.bright[near]
    return _Limb(line, rows[near], column[near], levels, found.blur_px)


def _columns(
    light: Plane, line: Array, inwards: int, rows: Array
) -> tuple[Array, NDArray[np.bool_], ShadedCrossings | None]:
    """Column of the edge in each row, where there is a clear step of light, and the edge itself."""
    found = shaded_crossings(across(light, line, inwards, rows, PROFILE_OFFSETS_PX), PROFILE_OFFSETS_PX, FIRST_BLUR_PX)
    if found is None:
        return np.full(len(rows), np.nan), np.zeros(len(rows), dtype=np.bool_), None
    return *crossed_columns(found.crossings, line, inwards, rows), found


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
