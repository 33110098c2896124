"""Alignment quality Q_R: how far the bar's outlines in both views agree (algorithms 11 and 12, eq. 4.1)."""

import math
from dataclasses import dataclass

import numpy as np
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
    row, first = np.unique(edge[:, 1], return_index=True)
    edge = edge[first]
    below, above = rows < row[0], rows > row[-1]
    column = np.interp(rows, row, edge[:, 0])
    (x0, y0), (x1, y1) = edge[0], edge[-1]
    slope = (x1 - x0) / (y1 - y0) if len(row) > 1 else 0.0
    column[below] = x0 + slope * (rows[below] - y0)
    column[above] = x1 + slope * (rows[above] - y1)
    return column
