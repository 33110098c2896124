"""Alignment quality Q_R: how far the bar's outlines in both views agree (algorithms 11 and 12, eq. 4.1)."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.geometry.homography import transformed

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class BarOutline:
    """The bar's two edges in one view, each a chain of points (column, row).

    Attributes
    ----------
    first, second : ndarray of float64, shape (n, 2), n at least 2
        Edge at smaller and at larger columns; their rows need not increase.
    """

    first: Array
    second: Array

    def moved(self, transform: Array) -> "BarOutline":
        """Return the outline after a homography."""
        return BarOutline(transformed(transform, self.first), transformed(transform, self.second))


@dataclass(frozen=True, slots=True)
class Quality:
    """How well the outlines of both views agree on one virtual board.

    Attributes
    ----------
    percent : float
        Q_R, eq. 4.1: area common to both outlines over that of the left view's, with the sign of algorithm 12:
        positive when the left view's centroid lies left of the right view's, which is when the board is too high.
        NaN when an outline is empty in the test region.
    offset_px : float
        Centroid of the left view's outline minus that of the right view's, across the bar.
    """

    percent: float
    offset_px: float


def alignment_quality(left: BarOutline, right: BarOutline, rows: Array) -> Quality:
    """Q_R between two outlines of one region, over some of its rows (algorithm 12).

    Parameters
    ----------
    left, right : BarOutline
        The right one already aligned.
    rows : ndarray of float64, shape (n,)
        The test region R_test.
    """
    (a, b), (c, d) = (_sides(outline, rows) for outline in (left, right))
    area_left, area_right = (np.maximum(width, 0.0) for width in (b - a, d - c))
    if not (area_left.sum() > 0.0 and area_right.sum() > 0.0):
        return Quality(math.nan, math.nan)
    common = np.maximum(np.minimum(b, d) - np.maximum(a, c), 0.0).sum() / area_left.sum()
    offset = area_left @ (a + b) / (2 * area_left.sum()) - area_right @ (c + d) / (2 * area_right.sum())
    return Quality(float(math.copysign(100.0 * common, -offset)), float(offset))


def offsets_px(left: BarOutline, right: BarOutline, rows: Array) -> Array:
    """Middle of the left view's outline minus that of the right view's, across the bar, row by row.

    Parameters
    ----------
    left, right : BarOutline
        The right one already aligned.
    rows : ndarray of float64, shape (n,)

    Returns
    -------
    ndarray of float64, shape (n,)
    """
    (a, b), (c, d) = (_sides(outline, rows) for outline in (left, right))
    return 0.5 * (a + b - c - d)


def _sides(outline: BarOutline, rows: Array) -> tuple[Array, Array]:
    first, second = (_column(edge, rows) for edge in (outline.first, outline.second))
    return first, second


def _column(edge: Array, rows: Array) -> Array:
    """Column of a chain of points at given rows; beyond its ends it goes on straight.

    The chain is put in order of rows: T_RL moves points that lie far off the edge to rows before their neighbours'.
    """
    return _columns(np.ascontiguousarray(edge[:, 1]), np.ascontiguousarray(edge[:, 0]), np.ascontiguousarray(rows))


@njit(nogil=True, cache=True)
def _columns(chain_row, chain_column, rows):  # type: ignore[no-untyped-def]
    order = np.argsort(chain_row, kind="mergesort")
    row, column = chain_row[order], chain_column[order]
    count = 1  # of points in rows of their own, of which the first in a row counts
    for point in range(1, len(row)):
        if row[point] != row[count - 1]:
            row[count], column[count] = row[point], column[point]
            count += 1
    columns = np.empty(len(rows))
    if count == 1:
        columns[:] = column[0]
        return columns
    outer = (column[count - 1] - column[0]) / (row[count - 1] - row[0])
    for number in range(len(rows)):
        at = rows[number]
        if at < row[0]:
            columns[number] = column[0] + outer * (at - row[0])
        elif at >= row[count - 1]:
            columns[number] = column[count - 1] + outer * (at - row[count - 1])
        else:
            before = np.searchsorted(row[:count], at, side="right") - 1
            slope = (column[before + 1] - column[before]) / (row[before + 1] - row[before])
            columns[number] = column[before] + slope * (at - row[before])
    return columns
