"""The bar's two edges in one resampled view, window by window.

The dissertation's method splits each window's boundary points by k-means, wherever in the region they lie; patches of
oxide then make whole windows wrong. The corrected method compares all of a frame's points of one edge with one robust
line first, searches only strips along the edges, and moves points to half level in linear light.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.alignment.quality import BarOutline
from vision.edges.operators import Edges
from vision.geometry.turned_region import Region
from vision.light_planes import Decoder
from vision.order_statistics import quantiles
from vision.pictures import brightest_channel
from vision.reasons import Reason
from vision.sizing.limits import CLIPPED_FEW_SHARE, CLIPPED_MOST_SHARE, COVERED_SHARE, LIMB_SIDES, WEAK_CONTRAST
from vision.sizing.virtual_board.boundaries_of_interest import Boundaries, boundaries_of_interest, hot_mask
from vision.sizing.virtual_board.half_level import LEAST_ROWS, LINE_DISTANCE_PX, HalfLevel, LimbRows, ThinEdges, line_of
from vision.sizing.virtual_board.parameters import Parameters
from vision.sizing.virtual_board.random_regression import WindowPoints, two_sides, windowed

Array = NDArray[np.float64]

SEARCH_REACH_PX = 12  # chosen: an edge lies at most this far from the rough outline
STRIP_HALF_WIDTH_PX = 16  # chosen: boundaries of interest count up to this far to either side of an edge
FOREST_MARGIN_PX = 48  # the forest reads no further, so that edges in a strip are those of the whole region
PLACES_ACROSS = 33  # chosen: an odd number of places across the bar, of which the median tells whether a row glows
HOT_ROW_SHARE = 0.4  # chosen: a row glows if its code values reach 40 % of a bright row's


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
        Smallest ratio of the bar's light to that of the background; infinite without half level.
    hot_share : float
        Share of the region's rows in which the bar glows.
    u_light_px : float
        Standard uncertainty of both edges' places from the response and from compression, mean of both.
    """

    sides: tuple[WindowPoints, WindowPoints]
    areas: Array
    outline: BarOutline | None
    clipped_share: float = 0.0
    contrast: float = np.inf
    hot_share: float = 1.0
    u_light_px: float = 0.0


def edges_by_windows(region: Region, parameters: Parameters, detector: Edges) -> ViewEdges:
    """Edges by the dissertation's steps: boundaries of interest of the whole region, k-means in each window.

    Parameters
    ----------
    region : Region
    parameters : Parameters
    detector : str or EdgeOptions
        Edge detector.

    Returns
    -------
    ViewEdges
    """
    window_rows = parameters.window_rows
    windows = region.picture.shape[0] // window_rows
    mask = hot_mask(region.picture, parameters.alpha)
    found = boundaries_of_interest(region.picture, mask, detector, parameters)
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


def edges_by_lines(
    region: Region,
    rough: tuple[Array, Array],
    parameters: Parameters,
    detector: Edges,
    decoder: Decoder | None,
) -> ViewEdges:
    """Edges by strips along the bar's outline, held against one robust line for each.

    Parameters
    ----------
    region : Region
    rough : tuple of two ndarray of float64, shape (2,)
        Slope and start of both edges, column = slope x row + start, to within `SEARCH_REACH_PX`.
    parameters : Parameters
    detector : str or EdgeOptions
        Edge detector.
    decoder : Decoder or None
        Of the camera's code values: points move to half level in linear light. None: they stay at the edge detector's
        ridge.

    Returns
    -------
    ViewEdges
    """
    hot = _hot_rows(region, rough)
    limbs = [
        _limb(region, _thin_edges(region, line, hot, parameters, detector), line, side, decoder)
        for line, side in zip(rough, LIMB_SIDES, strict=True)
    ]
    windows = region.shape[0] // parameters.window_rows
    rows = np.arange(windows * parameters.window_rows, dtype=np.float64).reshape(windows, parameters.window_rows)
    columns = [limb.column[: rows.size].reshape(rows.shape) for limb in limbs]
    sides = [WindowPoints(np.where(np.isfinite(column), rows, np.nan), column) for column in columns]
    areas = [limb.area[: rows.size].reshape(rows.shape).sum(axis=1) for limb in limbs]
    return ViewEdges(
        (sides[0], sides[1]),
        np.column_stack(areas),
        _outline_of_lines([limb.line for limb in limbs], region.shape[0]),
        max(limb.clipped_share for limb in limbs),
        min(limb.contrast for limb in limbs),
        float(hot.mean()),
        float(np.mean([limb.u_light_px for limb in limbs])),
    )


def _outline_of_lines(lines: list[Array | None], rows: int) -> BarOutline | None:
    ends = np.array([0.0, rows - 1.0])
    chains = [np.column_stack([line[0] * ends + line[1], ends]) for line in lines if line is not None]
    return BarOutline(*chains) if len(chains) == len(lines) else None


def _limb(region: Region, edges: ThinEdges, rough: Array, side: int, decoder: Decoder | None) -> LimbRows:
    line = _line(edges, rough)
    if line is None:
        return LimbRows.nothing(edges.area)
    if decoder is None:
        return LimbRows(edges.near(line), edges.area, line)
    return HalfLevel(region, side, decoder).locate(line, edges)


def _thin_edges(
    region: Region, rough: Array, hot: NDArray[np.bool_], parameters: Parameters, detector: Edges
) -> ThinEdges:
    """Thin edges of a strip along a rough line, in rows that glow."""
    rows, columns = region.shape
    ends = rough[1] + rough[0] * np.array([0.0, rows - 1.0])
    inner = max(0, int(ends.min()) - STRIP_HALF_WIDTH_PX), min(columns, int(ends.max()) + STRIP_HALF_WIDTH_PX + 1)
    outer = max(0, inner[0] - FOREST_MARGIN_PX), min(columns, inner[1] + FOREST_MARGIN_PX)
    seen = slice(inner[0] - outer[0], inner[1] - outer[0])
    found = boundaries_of_interest(region.part(slice(*outer)), None, detector, parameters, seen=seen)
    row, column = np.nonzero(found.thin * hot[:, None])
    return ThinEdges(row, (column + inner[0]).astype(np.float64), found.band.sum(axis=1, dtype=np.float64))


def _hot_rows(region: Region, rough: tuple[Array, Array]) -> NDArray[np.bool_]:
    """Rows in which most of what lies between the rough edges glows: not beyond a bar's end, not where it is hidden."""
    rows, columns = region.shape
    seen = brightest_channel(region.at(_places_across(rows, columns, rough[0], rough[1])))
    level = np.partition(seen, PLACES_ACROSS // 2, axis=1)[:, PLACES_ACROSS // 2]
    return level >= HOT_ROW_SHARE * quantiles(level, (0.9,))[0]


@njit(nogil=True, cache=True)
def _places_across(rows, columns, first, second):  # type: ignore[no-untyped-def]
    """Columns between two lines in each row, from a tenth to nine tenths of the way."""
    places = np.empty((rows, PLACES_ACROSS), np.int64)
    for row in range(rows):
        left, right = first[0] * row + first[1], second[0] * row + second[1]
        for number in range(PLACES_ACROSS):
            place = 0.5 * (left + right) + (2.0 * number / (PLACES_ACROSS - 1) - 1.0) * 0.4 * (right - left)
            places[row, number] = int(min(max(place, 0.0), columns - 1.0))
    return places


def _line(edges: ThinEdges, rough: Array) -> Array | None:
    """Robust line through the thin edge that most rows agree on near the rough one."""
    away = edges.column - (rough[0] * edges.row + rough[1])
    near = np.abs(away) < SEARCH_REACH_PX
    count = np.bincount(np.rint(away[near]).astype(np.int64) + SEARCH_REACH_PX, minlength=2 * SEARCH_REACH_PX + 1)
    middle = int(np.convolve(count, np.ones(5), "same").argmax()) - SEARCH_REACH_PX
    agree = np.abs(away - middle) <= 2 * LINE_DISTANCE_PX
    if np.count_nonzero(np.bincount(edges.row[agree])) < LEAST_ROWS:
        return None
    return line_of(edges.row[agree], edges.column[agree])


def reasons_of_edges(edges: list[ViewEdges]) -> Reason:
    """Reasons for doubt that the edges of one or two views give."""
    reasons = Reason.NONE
    for view in edges:
        if view.clipped_share > CLIPPED_MOST_SHARE:
            reasons |= Reason.EDGES_CLIPPED
        elif view.outline is None or view.hot_share < COVERED_SHARE:
            reasons |= Reason.EDGE_NOT_FOUND
        elif view.contrast < WEAK_CONTRAST:
            reasons |= Reason.LOW_CONTRAST
        if CLIPPED_FEW_SHARE < view.clipped_share <= CLIPPED_MOST_SHARE:
            reasons |= Reason.SOME_EDGES_CLIPPED
    return reasons
