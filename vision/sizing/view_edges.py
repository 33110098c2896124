"""The bar's two edges in one resampled view, window by window.

The source's way splits each window's boundary points by k-means, wherever in the region they lie; oxide patches then
turn whole windows into nonsense. The corrected way holds all of a frame's points of one edge against one robust
line first, searches only strips along the edges, and may move points to the half level in linear light.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.alignment import BarOutline
from vision.edges.operators import EdgeMethod
from vision.edges.subpixel import edge_blur_px, edge_shading, half_level_crossing
from vision.sizing.boundary import Boundaries, boundaries_of_interest, hot_mask
from vision.sizing.limb import CLIPPED_CODE, CLIPPED_FEW
from vision.sizing.regression import WindowPoints, two_sides, windowed
from vision.sizing.robust_line import robust_line
from vision.turned_region import Picture, Region

Array = NDArray[np.float64]

SEARCH_PX = 12  # how far from the rough outline an edge may be
NEAR_LINE_PX = 2.5  # boundary points further from the frame's line are not the bar's edge
STRIP_PX = 16  # to either side of an edge: what counts to its boundaries of interest
MARGIN_PX = 48  # beyond the strip: as far as the forest looks, so that a strip gets what the whole region would
PROFILE_PX, PROFILE_STEP_PX = 9, 0.5  # half length of a row's profile across an edge, and its step
FIRST_BLUR_PX = 1.5  # taken before the edge's own is known
SPARSE_ROWS, BLUR_EVERY = 4, 4  # what changes little along an edge needs few rows, and few of those
WEAK = 0.5  # of Otsu's level: scale on the bar takes strength from its edge, and the line tells it from others
HOT_ROW = 0.4  # of the code values of a bright row
LEAST_STEP = 0.1  # of a strong row's step of light: scale leaves a fifth of it, the line without a bar less
LEAST_GATE_PX = 0.3  # points that near to the line are on it, however little the others scatter
LEAST_ROWS = 20  # with an edge: fewer are no limb


@dataclass(frozen=True, slots=True, eq=False)
class ViewEdges:
    """Both edges of the bar in one view.

    Attributes
    ----------
    sides : tuple of two WindowPoints
        Points of the edge at smaller and at larger columns.
    areas : ndarray of float64, shape (windows, 2)
        A_ij: area of the boundaries of interest of each edge, pixels.
    outline : BarOutline or None
        None when an edge was not found.
    clipped_share : float
        Largest share of overexposed points of an edge.
    contrast : float
        Smallest ratio of the bar's light to that of the background; infinite where light was not asked for.
    hot_share : float
        Share of the region's rows in which the bar glows.
    """

    sides: tuple[WindowPoints, WindowPoints]
    areas: Array
    outline: BarOutline | None
    clipped_share: float = 0.0
    contrast: float = np.inf
    hot_share: float = 1.0


def edges_by_windows(region: Region, window_rows: int, method: EdgeMethod) -> ViewEdges:
    """Edges by the source's steps: boundaries of interest of the whole region, k-means in each window.

    Parameters
    ----------
    region : Region
    window_rows : int
        H.
    method : str
        Edge detector.
    """
    windows = region.picture.shape[0] // window_rows
    found = boundaries_of_interest(region.picture, hot_mask(region.picture), method)
    sides = two_sides(windowed(found.traced(), window_rows, windows))
    centres = np.column_stack([_mean(side.column) for side in sides])
    return ViewEdges(sides, _areas_by_windows(found, centres, window_rows), _outline_of_windows(sides))


def _areas_by_windows(found: Boundaries, centres: Array, window_rows: int) -> Array:
    """Band pixels of each window that are nearer to one side's centre than to the other's."""
    windows = len(centres)
    rows, columns = np.nonzero(found.band[: windows * window_rows])
    window = rows // window_rows
    second = columns > centres.mean(axis=1)[window]
    return np.bincount(2 * window + second, minlength=2 * windows).reshape(windows, 2).astype(np.float64)


def _outline_of_windows(sides: tuple[WindowPoints, WindowPoints]) -> BarOutline | None:
    row, column = ([_mean(values) for values in pair] for pair in zip(*((s.row, s.column) for s in sides), strict=True))
    chains = [np.column_stack([c, r])[np.isfinite(c)] for r, c in zip(row, column, strict=True)]
    return BarOutline(*chains) if min(map(len, chains)) > 1 else None


def _mean(values: Array) -> Array:
    """Mean over the points of each window, NaN without any."""
    there = np.isfinite(values)
    with np.errstate(invalid="ignore"):
        return np.where(there, values, 0.0).sum(axis=1) / there.sum(axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class _Limb:
    """One edge: a column (NaN without one) and an area for each row, and its line."""

    column: Array
    area: Array
    line: Array | None
    clipped_share: float = 0.0
    contrast: float = np.inf


def edges_by_lines(
    region: Region,
    rough: tuple[Array, Array],
    window_rows: int,
    method: EdgeMethod,
    decode: NDArray[np.float32] | None,
) -> ViewEdges:
    """Edges by strips along the bar's outline, held against one robust line for each.

    Parameters
    ----------
    region : Region
    rough : tuple of two ndarray of float64, shape (2,)
        Slope and start of both edges, column = slope x row + start, to within `SEARCH_PX`.
    window_rows : int
        H.
    method : str
        Edge detector.
    decode : ndarray of float32, shape (256,), or None
        Light of every code value: points move to half level in linear light. None: they stay where the edge
        detector has its ridge.
    """
    hot = _hot_rows(region.picture, rough)
    limbs = [_limb(region, hot, line, side, method, decode) for line, side in zip(rough, (-1, 1), strict=True)]
    windows = region.picture.shape[0] // window_rows
    rows = np.arange(windows * window_rows, dtype=np.float64).reshape(windows, window_rows)
    columns = [limb.column[: rows.size].reshape(rows.shape) for limb in limbs]
    sides = [WindowPoints(np.where(np.isfinite(column), rows, np.nan), column) for column in columns]
    areas = [limb.area[: rows.size].reshape(rows.shape).sum(axis=1) for limb in limbs]
    return ViewEdges(
        (sides[0], sides[1]),
        np.column_stack(areas),
        _outline_of_lines([limb.line for limb in limbs], region.picture.shape[0]),
        max(limb.clipped_share for limb in limbs),
        min(limb.contrast for limb in limbs),
        float(hot.mean()),
    )


def _outline_of_lines(lines: list[Array | None], rows: int) -> BarOutline | None:
    ends = np.array([0.0, rows - 1.0])
    chains = [np.column_stack([line[0] * ends + line[1], ends]) for line in lines if line is not None]
    return BarOutline(*chains) if len(chains) == len(lines) else None


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """Thin edges in the strip along one edge of the bar, and the area of their band in each row."""

    row: NDArray[np.int64]
    column: Array
    area: Array

    @property
    def has_edge(self) -> NDArray[np.bool_]:
        """Rows with any edge."""
        return np.bincount(self.row, minlength=len(self.area)) > 0

    def near(self, line: Array) -> Array:
        """Mean column of the thin edge's pixels near a line in each row, NaN without any."""
        near = np.abs(self.column - (line[0] * self.row + line[1])) <= NEAR_LINE_PX
        count = np.bincount(self.row[near], minlength=len(self.area))
        with np.errstate(invalid="ignore"):
            total = np.bincount(self.row[near], self.column[near], minlength=len(self.area))
            return total / np.where(count > 0, count, np.nan)

    def nothing(self, clipped_share: float = 0.0) -> _Limb:
        """Return a limb without points."""
        return _Limb(np.full(len(self.area), np.nan), self.area, None, clipped_share)


def _limb(
    region: Region,
    hot: NDArray[np.bool_],
    rough: Array,
    side: int,
    method: EdgeMethod,
    decode: NDArray[np.float32] | None,
) -> _Limb:
    rows = region.picture.shape[0]
    edges, first = _strip_edges(region.picture, rough, method)
    row, column = np.nonzero(edges.thin * hot[:, None])
    column = column + float(first)
    line = _line(row.astype(np.float64), column, rough)
    if line is None:
        return _Limb(np.full(rows, np.nan), np.zeros(rows), None)
    found = _Found(row, column, _area(edges.band, first, line))
    if decode is None:
        return _Limb(found.near(line), found.area, line)
    return _at_half_level(region, line, side, found, decode)


def _hot_rows(picture: Picture, rough: tuple[Array, Array]) -> NDArray[np.bool_]:
    """Rows in which most of what lies between the rough edges glows: not beyond a bar's end, not where it is hidden."""
    brightest = picture if picture.ndim == 2 else picture.max(axis=2)
    rows, columns = brightest.shape
    middle, half = 0.5 * (rough[0] + rough[1]), 0.4 * (rough[1] - rough[0])
    at = np.arange(rows)[:, None]
    across = np.linspace(-1.0, 1.0, 33)
    place = middle[0] * at + middle[1] + across * (half[0] * at + half[1])
    level = np.median(brightest[at, np.clip(place, 0, columns - 1).astype(np.int64)], axis=1)
    return level >= HOT_ROW * np.percentile(level, 90)


def _strip_edges(picture: Picture, rough: Array, method: EdgeMethod) -> tuple[Boundaries, int]:
    """Boundaries of interest of a strip along a rough line, and the strip's first column."""
    rows, columns = picture.shape[:2]
    ends = rough[1] + rough[0] * np.array([0.0, rows - 1.0])
    inner = max(0, int(ends.min()) - STRIP_PX), min(columns, int(ends.max()) + STRIP_PX + 1)
    outer = max(0, inner[0] - MARGIN_PX), min(columns, inner[1] + MARGIN_PX)
    strip = picture[:, outer[0] : outer[1]]
    seen = slice(inner[0] - outer[0], inner[1] - outer[0])
    return boundaries_of_interest(strip, None, method, seen=seen, weak=WEAK), inner[0]


def _line(row: Array, column: Array, rough: Array) -> Array | None:
    """Robust line through the thin edge that most rows agree on near the rough one."""
    away = column - (rough[0] * row + rough[1])
    near = np.abs(away) < SEARCH_PX
    if np.count_nonzero(near) < LEAST_ROWS:
        return None
    count = np.bincount(np.rint(away[near]).astype(np.int64) + SEARCH_PX, minlength=2 * SEARCH_PX + 1)
    middle = int(np.convolve(count, np.ones(5), "same").argmax()) - SEARCH_PX
    agree = np.abs(away - middle) <= 2 * NEAR_LINE_PX
    if np.count_nonzero(agree) < LEAST_ROWS or np.ptp(row[agree]) < LEAST_ROWS:
        return None
    return robust_line(row[agree], column[agree])


def _area(band: Picture, first: int, line: Array) -> Array:
    """Pixels of the band within `STRIP_PX` of the line in each row."""
    rows, columns = band.shape
    middle = np.rint(line[0] * np.arange(rows) + line[1]).astype(np.int64) - first
    at = middle[:, None] + np.arange(-STRIP_PX, STRIP_PX + 1)
    inside = (at >= 0) & (at < columns)
    return np.where(inside, np.take_along_axis(band, np.clip(at, 0, columns - 1), axis=1), 0).sum(axis=1, dtype=float)


def _at_half_level(region: Region, line: Array, side: int, found: _Found, decode: NDArray[np.float32]) -> _Limb:
    """Edge of each row at half level, from the brightest channel that is not overexposed along the edge."""
    tried: list[_Limb] = []
    for channel in np.argsort(-_brightness(region.picture, line, side)):
        tried.append(_channel_at_half_level(region, line, side, found, int(channel), decode))
        if tried[-1].clipped_share <= CLIPPED_FEW:
            break
    return min(tried, key=lambda limb: limb.clipped_share)


def _channel_at_half_level(
    region: Region, line: Array, side: int, found: _Found, channel: int, decode: NDArray[np.float32]
) -> _Limb:
    """Two passes: the outermost rise of light finds the line, whatever patches lie behind it; then half level around it.

    The first pass, and what the second needs to know of blur and shading, look at every `SPARSE_ROWS`th row only.
    """
    rows = np.arange(len(found.area), dtype=np.float64)
    offsets = np.arange(-PROFILE_PX, PROFILE_PX + PROFILE_STEP_PX, PROFILE_STEP_PX)

    def profiles(line: Array, wanted: NDArray[np.bool_]) -> tuple[Array, NDArray[np.int64], Array]:
        at = np.flatnonzero(wanted)
        middle = line[0] * rows[at] + line[1]
        return region.light(at, middle[:, None] - side * offsets, channel, decode), at, middle

    sparse = (rows % SPARSE_ROWS == 0) if len(rows) > 3 * SPARSE_ROWS * LEAST_ROWS else rows >= 0
    profile, at, middle = profiles(line, found.has_edge & sparse)
    place = half_level_crossing(profile, offsets, FIRST_BLUR_PX).place_px
    better, blur_px = _line_of(at, middle - side * place), _blur_px(profile, offsets, place)
    if better is None or blur_px is None:
        return found.nothing()
    profile, at, middle = profiles(better, np.isfinite(found.near(better)))
    few = sparse[at]
    even = half_level_crossing(profile[few], offsets, blur_px, expected_px=0.0)
    shading = edge_shading(profile[few], offsets, even, blur_px)
    edge = half_level_crossing(profile, offsets, blur_px, expected_px=0.0, shading=shading)
    step = edge.bright - edge.dark
    if not np.isfinite(step).any():
        return found.nothing()
    with np.errstate(invalid="ignore"):
        there = np.isfinite(edge.place_px) & (step >= LEAST_STEP * np.nanpercentile(step, 90))
    clipped = there & (edge.bright >= decode[CLIPPED_CODE])
    share = np.count_nonzero(clipped) / max(1, np.count_nonzero(there))
    column = np.full(len(rows), np.nan)
    column[at] = np.where(there & ~clipped, middle - side * edge.place_px, np.nan)
    best = _line_of(rows, column)
    if best is None:
        return found.nothing(share)
    with np.errstate(divide="ignore", invalid="ignore"):
        contrast = float(np.median(edge.bright[there]) / np.median(edge.dark[there]))
    return _Limb(_on_line(column, best), found.area, best, share, contrast)


def _blur_px(profile: Array, offsets: Array, place: Array) -> float | None:
    found = np.flatnonzero(np.isfinite(place))
    if found.size < LEAST_ROWS:
        return None
    sample = found[:: max(1, min(BLUR_EVERY, found.size // LEAST_ROWS))]
    return edge_blur_px(profile[sample], offsets, place[sample])


def _on_line(column: Array, line: Array) -> Array:
    """Columns without those off the line by more than their scatter explains."""
    away = np.abs(column - (line[0] * np.arange(len(column)) + line[1]))
    limit = max(LEAST_GATE_PX, 3 * 1.4826 * float(np.nanmedian(away)))
    return np.where(away <= limit, column, np.nan)


def _brightness(picture: Picture, line: Array, side: int) -> Array:
    """Median code value of each channel just inside an edge."""
    rows, columns = picture.shape[:2]
    inside = np.rint(line[0] * np.arange(rows) + line[1]).astype(np.int64) - side * (PROFILE_PX - 1)
    channels = picture.reshape(rows, columns, -1)
    return np.median(channels[np.arange(rows), np.clip(inside, 0, columns - 1)], axis=0)


def _line_of(row: Array, column: Array) -> Array | None:
    there = np.isfinite(column)
    return robust_line(row[there].astype(np.float64), column[there]) if there.sum() >= LEAST_ROWS else None
