"""The barriers of an empty conveyor as straight lines in the picture (algorithm 6 of the dissertation).

The barriers are the ruler (known distance) of a camera that was never calibrated: parallel, a known distance apart. The
rolling direction has to run up and down the picture, and the barriers have to be brighter than the conveyor between
them.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vision.edges.binary import EVERY_EDGE_CONFIDENCE, binarised, denoised
from vision.edges.operators import detect_edges
from vision.edges.subpixel import Crossings, half_level_crossing
from vision.edges.thinning import ridges
from vision.geometry.robust_line import robust_line
from vision.reasons import Reason
from vision.sizing.conveyor.beside_rollers import BESIDE_OFFSETS_PX, crossings_beside_rollers, rollers_show
from vision.sizing.conveyor.lens import Lens, ideal_points, plumb_line
from vision.sizing.limits import FIRST_BLUR_PX

Array = NDArray[np.float64]
Plane = NDArray[np.float32]

SLOPES = np.linspace(-0.7, 0.7, 141)  # of a line, columns per row: 35 degrees to either side of upright
MOST_NORMAL_ANGLE_RAD = 0.7  # chosen: an upright edge's normal points at most this far away from the rows
LEAST_STRIP_PX, LEAST_STRIP_SHARE = 24.0, 0.05  # chosen, the larger: between barriers a bar has room
HINT_PX = 20.0  # chosen: a barrier lies at most this far from where the user says
LEAST_LINE_ROWS = 3  # a line is fitted to more
LEAST_SIDE_PX = 32  # rows and columns that the edge detector needs
MOST_LINES = 12  # chosen: straight edges that are compared, the longest first
LEAST_LINE_SHARE = 0.2  # chosen: straight edges over fewer of the picture's rows are no barriers
LINE_DISTANCE_PX = 2.5  # chosen: pixels this near belong to a line; twice that is the mask of algorithm 6
SIDE_OFFSET_PX = 4.0  # chosen: the light this far to either side shows which side of a line is brighter
SAMPLE_OFFSETS_PX = np.arange(-8.0, 6.25, 0.25)  # from the conveyor to the barrier, which may be narrow
CLEAR_STEP_SHARE = 0.4  # chosen: a row shows the barrier if its step of light is 40 % of the 90th percentile's
LEAST_SHOWN_SHARE = 0.8  # chosen: a barrier that shows in fewer rows of the empty line is `barrier_hidden`
LEAST_SEEN_SHARE = 0.2  # chosen: where a barrier shows in fewer rows its place cannot be compared with the empty line's
BAND_COUNT = 24  # chosen: bands of rows whose medians show whether a barrier is straight
# A row supports the barrier if its crossing lies within 1 px of the fitted line; in noise, crossings scatter over the
# 14 px profile.
LINE_GATE_PX = 1.0
MOST_BEND_PX = 0.3  # chosen: root mean square of the bands off a straight line; noise makes a tenth of it


@dataclass(frozen=True, slots=True, eq=False)
class Barriers:
    """Inner edges of both barriers, f_1 and f_2 of algorithm 6.

    A barrier's inner face and its top may be two edges a pixel or two apart; these lines lie between them.

    Attributes
    ----------
    lines : ndarray of float64, shape (2, 2)
        Slope and start of column(row) of the left and of the right edge.
    light : ndarray of float32, shape (rows, columns)
        The empty line, 0 to 1, as `lens` straightens it.
    lens : Lens
        What makes the barriers straight.
    over_rollers : bool
        Whether the light beside a barrier changes, as over rollers and their ends: then it may hang above them.
    correlated_px : float
        Distance over which errors of the picture go together.
    """

    lines: Array
    light: Plane
    lens: Lens = field(default_factory=Lens)
    over_rollers: bool = False
    correlated_px: float = 1.0

    def columns(self, row: Array) -> Array:
        """Columns of both edges, shape (n, 2), in rows (n,)."""
        return np.asarray(row)[:, None] * self.lines[:, 0] + self.lines[:, 1]

    def width_px(self, row: Array) -> Array:
        """w_p of eq. 3.2 in rows (n,), pixels."""
        return np.diff(self.columns(row), axis=1)[:, 0]

    def pixel_ratio(self, row: Array, spacing_mm: float) -> Array:
        """Ratio r = w / w_p of eq. 3.2, mm per pixel.

        Parameters
        ----------
        row : ndarray of float64, shape (n,)
        spacing_mm : float
            w, the barriers' distance.

        Returns
        -------
        ndarray of float64, shape (n,)
        """
        return spacing_mm / self.width_px(row)

    @property
    def levels(self) -> tuple[Array, Array]:
        """Light beside and on each barrier, shape (2,); NaN where the picture ends."""
        rows = np.arange(len(self.light), dtype=np.float64)
        beside = np.array([-SIDE_OFFSET_PX, SIDE_OFFSET_PX])
        sides = zip(self.lines, (-1, 1), strict=True)
        dark, bright = np.nanmedian([across(self.light, line, out, rows, beside) for line, out in sides], axis=1).T
        return dark, bright

    def shifted_px(self, light: Plane) -> float | None:
        """Distance of the barriers in a picture from their places in the empty ones.

        Parameters
        ----------
        light : ndarray of float32, shape (rows, columns)
            Straightened by `lens`.

        Returns
        -------
        float or None
            Farthest distance along a row, pixels; None when a barrier shows in less than `LEAST_SEEN_SHARE` of the
            rows.
        """
        ends = np.array([0.0, len(light) - 1.0])
        farthest = 0.0
        for line, outwards in zip(self.lines, (-1, 1), strict=True):
            rows = _whole_rows(light, line, outwards)
            column, shows = _columns(light, line, outwards, rows, over_rollers=self.over_rollers)
            if np.count_nonzero(shows) < LEAST_SEEN_SHARE * len(light):
                return None
            found = robust_line(rows[shows], column[shows])
            straight = np.abs(column - np.polyval(found, rows)) <= LINE_GATE_PX
            if np.count_nonzero(shows & straight) < LEAST_SEEN_SHARE * len(light):
                return None
            farthest = max(farthest, float(np.abs(np.polyval(found - line, ends)).max()))
        return farthest


@dataclass(frozen=True, slots=True, eq=False)
class _Edge:
    """A straight edge: column(row), the mean of its rows, its step of light to the right, and its share of the rows."""

    line: Array
    row: float
    step: float
    share: float


def find_barriers(light: Plane, near_columns: tuple[float, float] | None = None) -> Barriers | Reason:
    """Both barriers in a picture of the line, empty or with a bar between them.

    Parameters
    ----------
    light : ndarray of float32, shape (rows, columns)
        Mean of one or more pictures, 0 to 1.
    near_columns : tuple of float, optional
        Columns of both inner edges in the picture's middle row, to within `HINT_PX`; needed where other pairs of edges
        look like barriers.

    Returns
    -------
    Barriers or Reason
        `barrier_hidden` when a barrier is not found or shows in less than `LEAST_SHOWN_SHARE` of the rows, or the
        picture has fewer than `LEAST_SIDE_PX` rows or columns; `barrier_bent` when no lens makes both straight.

    Raises
    ------
    ValueError
        `light` is no grey picture of float32 from 0 to 1.
    """
    if light.ndim != 2:
        raise ValueError(f"light: a grey picture of shape (rows, columns) wanted, got {light.shape}")
    if min(light.shape) < LEAST_SIDE_PX:
        return Reason.BARRIER_HIDDEN
    pair = _inner_pair(_straight_edges(light), light.shape, near_columns)
    if pair is None:
        return Reason.BARRIER_HIDDEN
    over_rollers = any(
        rollers_show(_inner_profile(light, edge.line, out), abs(edge.step))
        for edge, out in zip(pair, (-1, 1), strict=True)
    )
    found = _straight_pair(light, [edge.line for edge in pair], over_rollers=over_rollers)
    if found is None:
        return Reason.BARRIER_HIDDEN
    lens = plumb_line([one.bands for one in found], light.shape)
    if lens.bending:
        light = lens.straightened(light)
        straight = [ideal_points(one.bands, lens.bending, light.shape) for one in found]
        lines = [np.polyfit(points[:, 1], points[:, 0], 1) for points in straight]
        found = _straight_pair(light, lines, over_rollers=over_rollers)
        if found is None:
            return Reason.BARRIER_HIDDEN
    if max(one.off_straight_px for one in found) > MOST_BEND_PX:
        return Reason.BARRIER_BENT
    return Barriers(np.array([one.line for one in found]), light, lens, over_rollers)


def across(light: Plane, line: Array, outwards: int, rows: Array, offsets_px: Array) -> Array:
    """Light along profiles at right angles to a line, shape (rows, offsets).

    Parameters
    ----------
    light : ndarray of float32, shape (rows, columns)
    line : ndarray of float64, shape (2,)
        Slope and start of column(row).
    outwards : int
        -1 when profiles run to smaller columns, +1 when to larger ones.
    rows : ndarray of float64, shape (n,)
        Where the profiles cross the line.
    offsets_px : ndarray of float64, shape (m,)
        Offsets of the samples from the line.

    Returns
    -------
    ndarray of float64, shape (n, m)
        NaN outside the picture.
    """
    step = outwards * np.array([1.0, -line[0]]) / np.hypot(1.0, line[0])
    column = (line[0] * rows + line[1])[:, None] + offsets_px * step[0]
    row = rows[:, None] + offsets_px * step[1]
    return ndimage.map_coordinates(light, [row, column], np.float64, order=1, cval=np.nan)


def _straight_edges(light: Plane) -> list[_Edge]:
    """Upright straight edges of the forest, longest first."""
    edges = detect_edges(light, "forest")
    away = np.minimum(edges.normal_rad, np.pi - edges.normal_rad)
    thin = ridges(edges.strength, edges.normal_rad)
    row, column = np.nonzero(denoised(binarised(thin, EVERY_EDGE_CONFIDENCE)) & (away <= MOST_NORMAL_ANGLE_RAD))
    found: list[_Edge] = []
    while len(found) < MOST_LINES:
        line = _most_voted(row, column, light.shape)
        if line is None:
            break
        masked = np.abs(column - line[0] * row - line[1]) <= 2 * LINE_DISTANCE_PX
        if np.ptp(row[masked]) >= LEAST_LINE_SHARE * len(light):
            found.append(_edge(light, line, row[masked], column[masked]))
        row, column = row[~masked], column[~masked]
    return found


def _most_voted(row: NDArray[np.int64], column: NDArray[np.int64], shape: tuple[int, ...]) -> Array | None:
    """Line near most pixels, to a slope of `SLOPES`; None when it has too few."""
    rows, columns = shape
    if not row.size:
        return None
    best, line = LEAST_LINE_SHARE * rows, None
    for slope in SLOPES:
        start = column - slope * (row - rows / 2)
        inside = (start >= 0) & (start < columns)  # a line that crosses the middle row beside the picture is no barrier
        votes = np.bincount((start[inside] / LINE_DISTANCE_PX).astype(np.int64), minlength=1)
        votes = np.convolve(votes, np.ones(2, dtype=np.int64))  # cell and the one before: no line falls between two
        place = int(np.argmax(votes))
        if votes[place] > best:
            best, line = float(votes[place]), np.array([slope, place * LINE_DISTANCE_PX - slope * rows / 2])
    return line


def _edge(light: Plane, line: Array, row: NDArray[np.int64], column: NDArray[np.int64]) -> _Edge:
    """The edge near a voted line; edges of something else beside it do not count."""
    near = np.abs(column - line[0] * row - line[1]) <= LINE_DISTANCE_PX
    if np.unique(row[near]).size > LEAST_LINE_ROWS:
        line = robust_line(row[near].astype(np.float64), column[near].astype(np.float64))
        near = np.abs(column - line[0] * row - line[1]) <= LINE_DISTANCE_PX
    rows = np.unique(row[near]).astype(np.float64)
    levels = across(light, line, 1, rows, np.array([-SIDE_OFFSET_PX, SIDE_OFFSET_PX]))
    step = float(np.nanmedian(np.diff(levels, axis=1))) if np.isfinite(levels).all(axis=1).any() else 0.0
    return _Edge(line, float(row[near].mean()) if near.any() else 0.0, step, len(rows) / len(light))


def _inner_pair(
    edges: list[_Edge], shape: tuple[int, ...], near_columns: tuple[float, float] | None
) -> tuple[_Edge, _Edge] | None:
    """The two edges that are most alike a pair of barriers.

    Bright outside, alike in light, long, room for a bar between them, and a vanishing point beyond the picture.
    """
    row = np.array([shape[0] / 2, 1.0])
    best, pair = 0.0, None
    for left in edges:
        for right in edges:
            width = float((right.line - left.line) @ row)
            if left.step >= 0 or right.step <= 0 or width < max(LEAST_STRIP_PX, LEAST_STRIP_SHARE * shape[1]):
                continue
            if not _meet_beyond(left.line, right.line, shape[0]):
                continue
            columns = np.array([left.line @ row, right.line @ row])
            if near_columns is not None and np.abs(columns - near_columns).max() > HINT_PX:
                continue
            weak, strong = sorted((-left.step, right.step))
            alike = weak * (weak / strong) ** 2 * min(left.share, right.share)
            if alike > best:
                best, pair = alike, (left, right)
    return pair


def _meet_beyond(left: Array, right: Array, rows: int) -> bool:
    """Whether two lines meet above or below the picture, as parallel ones do under a camera that looks down."""
    (m1, c1), (m2, c2) = left, right
    first, last = c2 - c1, (m2 - m1) * (rows - 1) + c2 - c1
    return bool(first > 0 and last > 0)


@dataclass(frozen=True, slots=True, eq=False)
class _Straight:
    """A barrier's edge at half level: its line, how far it is from straight, and the median points of its bands."""

    line: Array
    off_straight_px: float
    bands: Array


def _straight_pair(light: Plane, lines: list[Array], *, over_rollers: bool) -> list[_Straight] | None:
    """Both edges at half level; None when one shows in too few rows."""
    found = [
        _at_half_level(light, line, outwards, over_rollers=over_rollers)
        for line, outwards in zip(lines, (-1, 1), strict=True)
    ]
    both = [one for one in found if one is not None]
    return both if len(both) == len(found) else None


def _at_half_level(light: Plane, line: Array, outwards: int, *, over_rollers: bool) -> _Straight | None:
    rows, column, shows = np.empty(0), np.empty(0), np.zeros(0, dtype=np.bool_)
    for _ in range(2):
        rows = _whole_rows(light, line, outwards)
        column, shows = _columns(light, line, outwards, rows, over_rollers=over_rollers)
        if np.count_nonzero(shows) < LEAST_SHOWN_SHARE * len(light):
            return None
        line = robust_line(rows[shows], column[shows])
    bands = np.array(
        [
            [np.median(columns), part.mean()]
            for columns, part in zip(
                np.array_split(column[shows], BAND_COUNT), np.array_split(rows[shows], BAND_COUNT), strict=True
            )
        ]
    )
    x, y = bands.T
    off = x - np.polyval(np.polyfit(y, x, 1), y)
    return _Straight(line, float(np.sqrt(np.mean(off**2))), bands)


def _whole_rows(light: Plane, line: Array, outwards: int) -> Array:
    """Rows whose profile across a line lies in the picture."""
    rows = np.arange(len(light), dtype=np.float64)
    return rows[np.isfinite(across(light, line, outwards, rows, SAMPLE_OFFSETS_PX)).all(axis=1)]


def _inner_profile(light: Plane, line: Array, outwards: int) -> Array:
    """Light on the conveyor beside a barrier, from row to row, shape (rows, offsets)."""
    rows = np.arange(len(light), dtype=np.float64)
    profile = across(light, line, outwards, rows, BESIDE_OFFSETS_PX)
    return profile[np.isfinite(profile).all(axis=1)]


def _columns(
    light: Plane, line: Array, outwards: int, rows: Array, *, over_rollers: bool
) -> tuple[Array, NDArray[np.bool_]]:
    profile = across(light, line, outwards, rows, SAMPLE_OFFSETS_PX)
    if over_rollers:
        crossings = crossings_beside_rollers(profile, SAMPLE_OFFSETS_PX)
    else:
        crossings = half_level_crossing(profile, SAMPLE_OFFSETS_PX, FIRST_BLUR_PX, expected_px=0.0)
    return crossed_columns(crossings, line, outwards, rows)


def crossed_columns(crossings: Crossings, line: Array, outwards: int, rows: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Column of half level in each row, and where there is a clear step of light.

    Parameters
    ----------
    crossings : Crossings
        On profiles of `across`.
    line : ndarray of float64, shape (2,)
    outwards : int
    rows : ndarray of float64, shape (n,)
        As given to `across`.

    Returns
    -------
    column : ndarray of float64, shape (n,)
    shows : ndarray of bool, shape (n,)
    """
    step = np.nan_to_num(np.where(np.isfinite(crossings.place_px), crossings.bright - crossings.dark, 0.0))
    shows = step > CLEAR_STEP_SHARE * np.percentile(step, 90) if len(step) else np.zeros(0, dtype=np.bool_)
    return line[0] * rows + line[1] + outwards * crossings.place_px * np.hypot(1.0, line[0]), shows
