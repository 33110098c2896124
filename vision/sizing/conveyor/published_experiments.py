"""The dissertation's four ways of sizing between barriers (its chapters 3.3 and 3.4), to be compared with ours.

Original or homographic pictures, and two ways of counting pixels between the bar's edges (algorithm 7): tracing its
boundary, or fitting lines to it in a local area. Whatever they count is turned into millimetres on the barriers'
plane by eq. 3.2 and 3.3. The local area is read as 85 columns by 20 rows: the other way round it could not hold both
edges of a bar.
"""

from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.edges.binary import BAR_EDGE_CONFIDENCE, binarised, denoised
from vision.edges.operators import detect_edges
from vision.edges.thinning import ridges
from vision.reasons import Reason
from vision.sizing.conveyor.barriers import Barriers, grey_light
from vision.sizing.conveyor.gauge import bar_spans

Array = NDArray[np.float64]
Points = NDArray[np.float32]
Picture = NDArray[np.uint8]
Homography = Literal["averaged", "fitted"]

AREA_COLUMNS, AREA_ROWS, AREA_STRIDE_ROWS = 85, 20, 5
SET_COUNT = 5  # sets of four points, eq. 3.4 to 3.6
MASK_MARGIN_PX = 4  # chosen: the bar's edges lie at most this far off its mask
LEAST_ROWS = 3  # chosen: rows with both edges that a line needs

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
    edges = _edges(np.clip(light, 0, 1), empty)
    if edges is None:
        return np.empty(0)
    width_px = edges[:, 1] - edges[:, 0]
    if number in {1, 2}:
        there = np.isfinite(width_px)
        return (ratio * width_px)[there]
    return _between_lines(edges, ratio)


def _edges(light: NDArray[np.float32], empty: NDArray[np.float32]) -> Array | None:
    """Outermost edge pixels of the bar in each row, shape (rows, 2), NaN without (algorithms 4 and 5)."""
    spans = bar_spans(light, empty)
    if isinstance(spans, Reason):
        return None
    found = detect_edges(light, "forest")
    thin = denoised(binarised(ridges(found.strength, found.normal_rad), BAR_EDGE_CONFIDENCE))
    columns = np.arange(light.shape[1])
    inside = (
        (columns >= spans[:, :1] - MASK_MARGIN_PX) & (columns <= spans[:, 1:] + MASK_MARGIN_PX) & (spans[:, :1] >= 0)
    )
    thin &= inside
    first, last = thin.argmax(axis=1), light.shape[1] - 1 - thin[:, ::-1].argmax(axis=1)
    both = thin.any(axis=1) & (last - first > (spans[:, 1] - spans[:, 0]) / 2)
    return np.where(both[:, None], np.column_stack([first, last]).astype(np.float64), np.nan)


def _between_lines(edges: Array, ratio: Array) -> Array:
    """Sub-algorithm 2: first-order fits of both edges in each local area, the mean of the pixels between them."""
    sized: list[float] = []
    for top in range(0, len(edges) - AREA_ROWS + 1, AREA_STRIDE_ROWS):
        rows = np.arange(top, top + AREA_ROWS)
        part = edges[rows]
        there = np.isfinite(part[:, 0]) & (np.ptp(np.nan_to_num(part), axis=1) < AREA_COLUMNS)
        if np.count_nonzero(there) < LEAST_ROWS:
            continue
        left, right = (np.polyval(np.polyfit(rows[there], part[there, side], 1), rows) for side in (0, 1))
        sized.append(float(np.mean(ratio[rows] * (right - left))))
    return np.array(sized)
