"""How good an edge detector is: against people's boundaries (the rule of BSDS500), and against a bar's limbs.

The rule of the Berkeley benchmark, doi:10.1109/TPAMI.2010.161, allows 0.0075 of the diagonal, 4.3 pixels there: it says
whether edges are the right ones, and nothing of where they lie. `limb_rows` measures that.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import maximum_flow
from skimage.morphology import thin

THRESHOLDS = np.linspace(0, 1, 35)[1:-1]  # the rule's 33
REACH_OF_DIAGONAL = 0.0075

Strength = NDArray[np.float32]
Mask = NDArray[np.bool_]
Counts = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class BoundaryCounts:
    """Pixels of one picture at each threshold, arrays of shape (thresholds,).

    Attributes
    ----------
    found, found_right : ndarray of int64
        Edge pixels, and those that match a boundary of at least one person.
    wanted, wanted_found : ndarray of int64
        Boundary pixels of all people, and those that an edge pixel matches.
    """

    found: Counts
    found_right: Counts
    wanted: Counts
    wanted_found: Counts


@dataclass(frozen=True, slots=True)
class BoundaryScores:
    """Summary of many pictures.

    Attributes
    ----------
    ods : float
        Best F with one threshold for all pictures.
    ods_threshold : float
    ois : float
        F with the best threshold for each picture.
    ap : float
        Area under precision over recall.
    """

    ods: float
    ods_threshold: float
    ois: float
    ap: float


def boundary_counts(
    strength: Strength, boundaries: Sequence[Mask], thresholds: NDArray[np.float64] = THRESHOLDS
) -> BoundaryCounts:
    """Count one picture's edges against people's boundaries.

    Parameters
    ----------
    strength : ndarray of float32, shape (rows, columns)
        Edge strength, 0 to 1, after non-maximum suppression; what passes a threshold is thinned.
    boundaries : sequence of ndarray of bool, shape (rows, columns)
        One per person, one pixel wide.
    thresholds : ndarray of float64, shape (n,)
        Increasing.
    """
    reach_px = REACH_OF_DIAGONAL * float(np.hypot(*strength.shape))
    counts = np.zeros((4, len(thresholds)), np.int64)
    counts[2] = sum(np.count_nonzero(boundary) for boundary in boundaries)
    for number, threshold in enumerate(thresholds[thresholds <= strength.max()]):
        edges = thin(strength >= threshold)
        right = np.zeros(edges.shape, np.bool_)
        for boundary in boundaries:
            edge_matched, boundary_matched = matched(edges, boundary, reach_px)
            right |= edge_matched
            counts[3, number] += np.count_nonzero(boundary_matched)
        counts[:2, number] = np.count_nonzero(edges), np.count_nonzero(right)
    return BoundaryCounts(*counts)


def matched(one: Mask, other: Mask, reach_px: float) -> tuple[Mask, Mask]:
    """Which pixels of two pictures find a partner in the other one no further away than `reach_px`.

    Every pixel has at most one partner, and as many as possible have one.
    """
    of_one, of_other = np.zeros(one.shape, np.bool_), np.zeros(one.shape, np.bool_)
    first, second = _pairs(one, other, reach_px)
    if len(first):
        places, partners = np.flatnonzero(one), np.flatnonzero(other)
        used_first, used_second = _greatest_matching(first, second, len(places), len(partners))
        of_one.flat[places[used_first]] = True
        of_other.flat[partners[used_second]] = True
    return of_one, of_other


def _greatest_matching(
    first: NDArray[np.int32], second: NDArray[np.int32], firsts: int, seconds: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Partners in one of the greatest matchings, as the pairs that carry a flow of one.

    A source feeds each of the `firsts`, each of the `seconds` drains. SciPy's `maximum_bipartite_matching` finds as
    many, but takes seconds for some pictures of boundaries where the flow takes milliseconds.
    """
    source, drain = firsts + seconds, firsts + seconds + 1
    start = np.concatenate([np.full(firsts, source), first, np.arange(firsts, source)])
    end = np.concatenate([np.arange(firsts), firsts + second, np.full(seconds, drain)])
    graph = sparse.csr_array((np.ones(len(start), np.int32), (start, end)), (drain + 1, drain + 1))
    flow = maximum_flow(graph, source, drain, method="dinic").flow.tocoo()
    used = (flow.data > 0) & (flow.row < firsts) & (flow.col < source)
    return flow.row[used], flow.col[used] - firsts


def _pairs(one: Mask, other: Mask, reach_px: float) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Numbers of all pixels of `one` and of `other` that are near each other."""
    reach = int(reach_px)
    number = np.full(np.array(one.shape) + 2 * reach, -1, np.int32)
    number[reach : reach + one.shape[0], reach : reach + one.shape[1]][other] = np.arange(np.count_nonzero(other))
    rows, columns = np.nonzero(one)
    numbers = np.arange(len(rows), dtype=np.int32)
    first, second = [np.empty(0, np.int32)], [np.empty(0, np.int32)]
    for down, right in np.argwhere(np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) <= reach_px):
        partner = number[rows + down, columns + right]
        first.append(numbers[partner >= 0])
        second.append(partner[partner >= 0])
    return np.concatenate(first), np.concatenate(second)


def boundary_scores(pictures: Sequence[BoundaryCounts], thresholds: NDArray[np.float64] = THRESHOLDS) -> BoundaryScores:
    """Summary of pictures that were counted at the same thresholds."""
    counts = np.array([[p.found, p.found_right, p.wanted, p.wanted_found] for p in pictures])
    precision, recall, f = _precision_recall(counts.sum(axis=0))
    best_of_each = np.argmax(np.array([_precision_recall(picture)[2] for picture in counts]), axis=1)
    own_best = counts[np.arange(len(counts)), :, best_of_each].sum(axis=0)
    best = int(np.argmax(f))
    order = np.argsort(recall)
    places = np.linspace(0, 1, 101)
    area = np.interp(places, recall[order], precision[order], left=0, right=0).sum() / 100
    return BoundaryScores(float(f[best]), float(thresholds[best]), float(_precision_recall(own_best)[2]), float(area))


def _precision_recall(counts: Counts) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    found, found_right, wanted, wanted_found = counts.astype(np.float64)
    precision, recall = found_right / np.maximum(found, 1), wanted_found / np.maximum(wanted, 1)
    return precision, recall, 2 * precision * recall / np.maximum(precision + recall, 1e-12)


@dataclass(frozen=True, slots=True, eq=False)
class LimbRows:
    """What a detector says of the rows of a picture in which a bar stands upright.

    Attributes
    ----------
    found : ndarray of float32, shape (2, rows)
        Strength of the strongest edge within `LIMB_REACH_PX` of the left and of the right limb; 0 if there is none.
    near : ndarray of float32, shape (2, rows)
        The same within `LIMB_MARGIN_PX`.
    offset_px : ndarray of float64, shape (2, rows)
        Where the found edge lies: pixels from the limb, positive to the right, between pixels by the parabola through
        three strengths; NaN if there is none.
    false : ndarray of float32, shape (rows,)
        Strength of the strongest edge between the limbs that is further than `LIMB_MARGIN_PX` from both.
    """

    found: Strength
    near: Strength
    offset_px: NDArray[np.float64]
    false: Strength


LIMB_REACH_PX = 1.0
LIMB_MARGIN_PX = 3.0


def limb_rows(strength: Strength, suppressed: Strength, limbs_px: NDArray[np.float64]) -> LimbRows:
    """Compare edges with a bar's true limbs, row by row.

    Parameters
    ----------
    strength, suppressed : ndarray of float32, shape (rows, columns)
        Edge strength before and after non-maximum suppression.
    limbs_px : ndarray of float64, shape (2, rows)
        Column of the left and of the right limb, pixel centres at integers; both at least 4 pixels inside the picture.
    """
    rows = np.arange(strength.shape[0])
    found, near = np.zeros(limbs_px.shape, np.float32), np.zeros(limbs_px.shape, np.float32)
    offset = np.full(limbs_px.shape, np.nan)
    for side, limb in enumerate(limbs_px):
        column = np.rint(limb).astype(np.int64)[:, None] + np.arange(-3, 4)
        distance, edge = np.abs(column - limb[:, None]), suppressed[rows[:, None], column]
        near[side] = np.where(distance <= LIMB_MARGIN_PX, edge, 0).max(axis=1)
        edge = np.where(distance <= LIMB_REACH_PX, edge, 0)
        found[side] = edge.max(axis=1)
        best = np.take_along_axis(column, np.argmax(edge, axis=1)[:, None], 1)[:, 0]
        before, here, after = (strength[rows, best + step].astype(np.float64) for step in (-1, 0, 1))
        bend = before - 2 * here + after
        shift = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, -1), 0)
        offset[side] = np.where(found[side] > 0, best + np.clip(shift, -1, 1) - limb, np.nan)
    columns = np.arange(strength.shape[1])
    inside = (columns > limbs_px[0][:, None] + LIMB_MARGIN_PX) & (columns < limbs_px[1][:, None] - LIMB_MARGIN_PX)
    return LimbRows(found, near, offset, np.where(inside, suppressed, 0).max(axis=1))
