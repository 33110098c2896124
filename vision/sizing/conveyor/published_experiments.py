"""The dissertation's four ways of sizing between barriers (its chapters 3.3 and 3.4), to be compared with ours.

Original or homographic pictures, and two ways of counting pixels between the bar's edges (algorithm 7): tracing its
boundary, or fitting lines to it in a local area. Whatever they count is turned into millimetres on the barriers'
plane by eq. 3.2 and 3.3. What the dissertation leaves open is read so:

- B_max, the boundary that is selected of all that were traced: on each side of the bar's middle the longest one.
- The local area is 85 columns by 20 rows: the other way round it could not hold both edges of a bar. In pictures
  whose bar is wider it is a quarter wider than the bar; it moves by 5 pixels down and across.
- An area counts where the longest boundary on either side of its middle crosses at least half of its rows.
"""

from typing import Literal, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.edges.binary import BAR_EDGE_CONFIDENCE, binarised, denoised
from vision.edges.operators import detect_edges
from vision.edges.thinning import ridges
from vision.reasons import Reason
from vision.sizing.conveyor.bar_spans import bar_spans
from vision.sizing.conveyor.barriers import Barriers
from vision.sizing.conveyor.grey_light import grey_light

Array = NDArray[np.float64]
Points = NDArray[np.float32]
Picture = NDArray[np.uint8]
Homography = Literal["averaged", "fitted"]

AREA_COLUMNS, AREA_ROWS, AREA_STRIDE_PX = 85, 20, 5  # w x h and s, section 3.4
WIDER_THAN_BAR = 1.25  # chosen: columns of the area over the bar's where 85 columns do not hold it
SET_COUNT = 5  # sets of four points, eq. 3.4 to 3.6
MASK_MARGIN_PX = 4  # chosen: the bar's edges lie at most this far off its mask
LEAST_ROWS = AREA_ROWS // 2  # chosen: rows that a boundary in a local area must cross

EXPERIMENTS = (1, 2, 3, 4)


def homography(barriers: Barriers, way: Homography = "averaged") -> Array:
    """Homography that makes the barriers upright (eq. 3.4 to 3.6), in column-vector convention, shape (3, 3).

    Parameters
    ----------
    barriers : Barriers
    way : {"averaged", "fitted"}
        Mean of five sets' matrices, each scaled so that its last element is 1; or one matrix by the ends of f_1 and
        f_2, which all points of the barriers were fitted to. Eq. 3.5 keeps y, which no one matrix can do for more
        than two rows: five sets cannot be met by one fit of their points.
    """
    rows = len(barriers.light)
    highs = np.linspace(0.0, 0.4 * rows, SET_COUNT) if way == "averaged" else np.zeros(1)
    matrices: list[Array] = []
    for high in highs:
        seen, wanted = _four_points(barriers, float(rows - 1), float(high))
        matrices.append(np.asarray(cv2.getPerspectiveTransform(seen, wanted), dtype=np.float64))
    return np.mean([matrix / matrix[2, 2] for matrix in matrices], axis=0)


def _four_points(barriers: Barriers, low: float, high: float) -> tuple[Points, Points]:
    """A, B on the lower row, C, D on the upper one, and where they go: C above A and D above B."""
    (ax, bx), (cx, dx) = barriers.columns(np.array([low, high]))
    return (
        np.array([[ax, low], [bx, low], [cx, high], [dx, high]], np.float32),
        np.array([[ax, low], [bx, low], [ax, high], [bx, high]], np.float32),
    )


def experiment(
    number: int, picture: Picture, barriers: Barriers, spacing_mm: float, way: Homography = "averaged"
) -> Array:
    """Diameters l_ij of one frame by one of the four experiments.

    Parameters
    ----------
    number : {1, 2, 3, 4}
        1 and 2 count between traced boundaries, 3 and 4 between fitted lines; 2 and 4 on homographic pictures.
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    barriers : Barriers
    spacing_mm : float
        W.
    way : {"averaged", "fitted"}
        See `homography`.

    Returns
    -------
    ndarray of float64, shape (n,)
        One for each row, or for each place of the local area; empty when no bar was found.

    Raises
    ------
    ValueError
        There is no such experiment.
    """
    if number not in EXPERIMENTS:
        raise ValueError(f"number is {number}; there are experiments 1 to 4")
    light, empty = barriers.lens.straightened(grey_light(picture)), barriers.light
    rows = np.arange(len(light), dtype=np.float64)
    ratio = barriers.pixel_ratio(rows, spacing_mm)
    if number in {2, 4}:
        H = homography(barriers, way)
        size = light.shape[1], light.shape[0]
        light, empty = (np.asarray(cv2.warpPerspective(one, H, size), np.float32) for one in (light, empty))
        ratio = np.full(len(rows), ratio[-1])
    section = _section(np.clip(light, 0, 1), empty)
    if section is None:
        return np.empty(0)
    if number in {1, 2}:
        width_px = traced_widths(section.edges, section.middle)
        there = np.isfinite(width_px)
        return (ratio * width_px)[there]
    columns = max(AREA_COLUMNS, round(WIDER_THAN_BAR * section.widest_px))
    place, width_px = local_area_widths(section.edges, (columns, AREA_ROWS), AREA_STRIDE_PX)
    return np.interp(place, rows, ratio) * width_px


class _Section(NamedTuple):
    """E_section of algorithm 5: thin edges of the bar, bool, the middle of its mask in each row, its greatest width."""

    edges: NDArray[np.bool_]
    middle: Array
    widest_px: int


def _section(light: NDArray[np.float32], empty: NDArray[np.float32]) -> _Section | None:
    spans = bar_spans(light, empty)
    if isinstance(spans, Reason):
        return None
    found = detect_edges(light, "forest")
    thin = denoised(binarised(ridges(found.strength, found.normal_rad), BAR_EDGE_CONFIDENCE))
    columns, there = np.arange(light.shape[1]), spans[:, 0] >= 0
    inside = (columns >= spans[:, :1] - MASK_MARGIN_PX) & (columns <= spans[:, 1:] + MASK_MARGIN_PX) & there[:, None]
    rows = np.flatnonzero(there)
    middle = np.interp(np.arange(len(spans)), rows, spans[rows].mean(axis=1))
    return _Section(thin & inside, middle, int(np.diff(spans[rows]).max()) + 1)


def traced_widths(edges: NDArray[np.bool_], middle: Array) -> Array:
    """Sub-algorithm 1 of algorithm 7: pixels between the two boundaries, row by row.

    Parameters
    ----------
    edges : ndarray of bool, shape (rows, columns)
        Thin edges of the section.
    middle : ndarray of float64, shape (rows,)
        Middle of the section, which parts its two boundaries.

    Returns
    -------
    ndarray of float64, shape (rows,)
        Distance of the outermost pixels of both boundaries; NaN in rows that lack one.
    """
    chains = _traced(edges)
    sides = [_longest(chains, middle, side) for side in (-1, 1)]
    ends = np.full((2, len(edges)), np.nan)
    for end, chain, outermost in zip(ends, sides, (np.fmin, np.fmax), strict=True):
        if chain is not None:
            outermost.at(end, chain[:, 1], chain[:, 0].astype(np.float64))
    return ends[1] - ends[0]


def local_area_widths(edges: NDArray[np.bool_], area: tuple[int, int], stride_px: int) -> tuple[Array, Array]:
    """Sub-algorithm 2 of algorithm 7: pixels between two lines in a local area that moves down and across.

    Parameters
    ----------
    edges : ndarray of bool, shape (rows, columns)
        Thin edges of the section.
    area : tuple of int
        w, h: columns and rows of the area.
    stride_px : int
        s, down and across.

    Returns
    -------
    tuple of two ndarray of float64, shape (n,)
        Middle row of each area that shows both boundaries, and the mean number of pixels between its lines.
    """
    width, height = area
    seen = np.flatnonzero(edges.any(axis=0))
    places: list[float] = []
    widths: list[float] = []
    if not seen.size:
        return np.empty(0), np.empty(0)
    first, last = max(0, int(seen[-1]) - width + 1), max(0, min(int(seen[0]), edges.shape[1] - width))
    lefts = range(min(first, last), max(first, last) + 1, stride_px)
    for top in range(0, len(edges) - height + 1, stride_px):
        strip = edges[top : top + height]
        whole_px = _between_lines(strip)  # of every area that holds all of the strip's edges
        for left in lefts:
            part = strip[:, left : left + width]
            width_px = whole_px if part.sum() == strip.sum() else _between_lines(part)
            if np.isfinite(width_px):
                places.append(top + (height - 1) / 2)
                widths.append(width_px)
    return np.array(places), np.array(widths)


def _between_lines(area: NDArray[np.bool_]) -> float:
    """Mean pixels between first-order fits to the area's two boundaries, over its rows; NaN without two."""
    columns, rows = np.nonzero(area)[1], np.arange(len(area))
    if not columns.size:
        return np.nan
    chains, middle = _traced(area), np.full(len(area), 0.5 * (columns.min() + columns.max()))
    lines: list[Array] = []
    for side in (-1, 1):
        chain = _longest(chains, middle, side)
        if chain is None or len(np.unique(chain[:, 1])) < LEAST_ROWS:
            return np.nan
        slope, start = np.polyfit(chain[:, 1], chain[:, 0], 1).tolist()
        lines.append(slope * rows + start)
    return float(np.mean(lines[1] - lines[0]))


def _traced(edges: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Boundaries B_1 ... B_n by Moore-neighbour tracing, each as pixels (column, row)."""
    framed = np.pad(edges.astype(np.uint8), 1)  # a boundary at the picture's border is traced too
    chains, _ = cv2.findContours(framed, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return [chain[:, 0].astype(np.int64) - 1 for chain in chains]


def _longest(chains: list[NDArray[np.int64]], middle: Array, side: int) -> NDArray[np.int64] | None:
    """B_max on one side of the middle: the part of a chain there that crosses the most rows."""
    parts = [chain[side * (chain[:, 0] - middle[chain[:, 1]]) > 0] for chain in chains]
    return max(parts, key=lambda part: len(np.unique(part[:, 1])), default=None) if parts else None
