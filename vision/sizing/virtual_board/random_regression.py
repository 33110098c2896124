"""Sliding-window random regression (algorithm 9): from boundary points to lines, many times over.

A window is a strip of H rows. Its boundary points belong to one of the bar's two edges; T times, S of them are drawn
and a line is fitted, so that the scatter of what follows says how far the points agree. Arrays are (windows, points)
with NaN where a window has fewer points.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_KMEANS_ROUNDS = 20  # chosen: k-means ends earlier when no point changes its cluster


@dataclass(frozen=True, slots=True, eq=False)
class WindowPoints:
    """Boundary points of one edge of the bar, window by window.

    Attributes
    ----------
    row, column : ndarray of float64, shape (windows, points)
        NaN where there is no point.
    """

    row: Array
    column: Array


def windowed(points: Array, window_rows: int, windows: int) -> WindowPoints:
    """Sort points into windows.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 2)
        (column, row).
    window_rows : int
        H.
    windows : int
        m; points below the last window are left out.

    Returns
    -------
    WindowPoints
    """
    window = np.floor_divide(points[:, 1], window_rows).astype(np.int64)
    order = np.argsort(window, kind="stable")
    order = order[window[order] < windows]
    points, window = points[order], window[order]
    count = np.bincount(window, minlength=windows)
    place = np.arange(len(window)) - np.repeat(np.cumsum(count) - count, count)
    row, column = (np.full((windows, max(1, int(count.max(initial=0)))), np.nan) for _ in range(2))
    row[window, place], column[window, place] = points[:, 1], points[:, 0]
    return WindowPoints(row, column)


def two_sides(points: WindowPoints) -> tuple[WindowPoints, WindowPoints]:
    """Split each window's points into the bar's two edges by k-means with two clusters (step 5 of algorithm 9).

    Parameters
    ----------
    points : WindowPoints
        All boundary points.

    Returns
    -------
    tuple of two WindowPoints
        Cluster that starts at the smallest, and at the largest column of its window.
    """
    xy = np.stack([points.column, points.row], axis=-1)
    there = np.isfinite(points.column)
    rows = np.arange(len(xy))
    filled = (
        np.where(there, points.column, np.inf).argmin(axis=1),
        np.where(there, points.column, -np.inf).argmax(axis=1),
    )
    centres = np.stack([xy[rows, filled[0]], xy[rows, filled[1]]], axis=1)
    second = np.zeros(there.shape, dtype=bool)
    for _ in range(MOST_KMEANS_ROUNDS):
        distance = ((xy[:, :, None] - centres[:, None]) ** 2).sum(axis=-1)
        nearer = there & (distance[..., 1] < distance[..., 0])
        if np.array_equal(nearer, second):
            break
        second = nearer
        for number, mine in enumerate((there & ~second, second)):
            count = mine.sum(axis=1)
            total = np.where(mine[..., None], xy, 0.0).sum(axis=1)
            has = count > 0
            centres[has, number] = total[has] / count[has, None]
    return _only(points, there & ~second), _only(points, second)


def _only(points: WindowPoints, mine: NDArray[np.bool_]) -> WindowPoints:
    return WindowPoints(np.where(mine, points.row, np.nan), np.where(mine, points.column, np.nan))


@dataclass(frozen=True, slots=True, eq=False)
class RandomLines:
    """Lines column = slope x row + start through random samples, shape (windows, T); NaN where points are too few."""

    slope: Array
    start: Array

    def at(self, rows: Array) -> Array:
        """Columns at the rows of each window, shape (windows, H), as shape (windows, T, H): eq. 3.12."""
        return self.slope[..., None] * rows[:, None, :] + self.start[..., None]


def random_regression(points: WindowPoints, samples: int, times: int, rng: np.random.Generator) -> RandomLines:
    """First-order fits to random samples of each window's points (step 6 of algorithm 9, eq. 3.10).

    Parameters
    ----------
    points : WindowPoints
        Of one edge.
    samples : int
        S, points drawn each time, none twice.
    times : int
        T.
    rng : numpy.random.Generator
        Its state decides which points are drawn.

    Returns
    -------
    RandomLines
        NaN for windows with fewer than S points. Where all that were drawn lie in one row, the line is upright.
    """
    windows, most = points.column.shape
    if most < samples:
        nothing = np.full((windows, times), np.nan)
        return RandomLines(nothing, nothing)
    lot = rng.random((windows, times, most), dtype=np.float32)
    return RandomLines(*_lines(np.ascontiguousarray(points.row), np.ascontiguousarray(points.column), lot, samples))


@njit(nogil=True, cache=True)
def _lines(row, column, lot, samples):  # type: ignore[no-untyped-def]
    """Slopes and starts of the lines through those points of each window that have drawn the least lots."""
    windows, times, most = lot.shape
    slope, start = np.full((windows, times), np.nan), np.full((windows, times), np.nan)
    drawn = np.empty(samples, np.int64)
    for window in range(windows):
        for time in range(times):
            count = 0
            for point in range(most):
                if not np.isfinite(column[window, point]):
                    continue
                place = count  # among those drawn so far, in the order of their lots
                while place > 0 and lot[window, time, point] < lot[window, time, drawn[place - 1]]:
                    if place < samples:
                        drawn[place] = drawn[place - 1]
                    place -= 1
                if place < samples:
                    drawn[place] = point
                    count = min(count + 1, samples)
            if count == samples:
                slope[window, time], start[window, time] = _line(row[window], column[window], drawn)
    return slope, start


@njit(nogil=True, cache=True)
def _line(row, column, drawn):  # type: ignore[no-untyped-def]
    """Least squares through some points; upright where all lie in one row."""
    middle_row, middle_column = row[drawn].mean(), column[drawn].mean()
    spread, product = 0.0, 0.0
    for point in drawn:
        away = row[point] - middle_row
        spread += away * away
        product += away * column[point]
    slope = 0.0 if spread == 0.0 else product / spread
    return slope, middle_column - slope * middle_row
