"""Alignment of the right view to the left one by virtual boards, and the height at which the bar's outlines agree.

Algorithms 11, 12 and 13 of the source. T_RL takes the right view's board corners to the left view's; whatever lies in
the board's plane then coincides. Q_R says how far the two outlines of the bar do; the board is raised or lowered
virtually until they agree, by the source's search over n boards or by a loop that starts from the last frame's height.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Camera, Rig
from vision.calibration.virtual_board import VirtualBoards
from vision.turned_region import Region

Array = NDArray[np.float64]

LOWEST_MM, HIGHEST_MM = 0.0, 320.0  # where the outlines of bars of 40 to 500 mm may agree
BOARDS = 40  # n of algorithm 13; the source does not give it
HEIGHT_STEP_MM = 0.01  # heights are whole steps, so that the loop's start does not show in the result
FIRST_MM = 100.0  # where the loop begins
ROUNDS = 6  # evaluations of the loop before it gives up


@dataclass(frozen=True, slots=True, eq=False)
class BarOutline:
    """The bar's two edges in one view, each a chain of points (column, row), downwards.

    Attributes
    ----------
    first, second : ndarray of float64, shape (n, 2), n at least 2
        Edge at smaller and at larger columns.
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


@dataclass(frozen=True, slots=True)
class Height:
    """The height that was chosen.

    Attributes
    ----------
    height_mm : float
        NaN when no height makes the outlines agree.
    quality : Quality
        At that height.
    evaluations : int
        Boards that were tried.
    """

    height_mm: float
    quality: Quality
    evaluations: int


Evaluate = Callable[[float], Quality]


def transformed(homography: Array, points: Array) -> Array:
    """Points (x, y), shape (..., 2), after a homography."""
    moved = points @ homography[:, :2].T + homography[:, 2]
    return moved[..., :2] / moved[..., 2:]


def solved(homography: Array, of: Array) -> Array:
    """Inverse of a homography, times another."""
    return np.asarray(np.linalg.solve(homography, of), dtype=np.float64)


def plane_to_ideal(camera: Camera, height_mm: float) -> Array:
    """Homography from (x, y), mm, on the plane z = height to the camera's ideal points."""
    return np.column_stack([camera.R[:, 0], camera.R[:, 1], camera.R[:, 2] * height_mm + camera.t])


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """Both views of one pair, and the boards that align them.

    Attributes
    ----------
    rig : Rig
    boards : VirtualBoards
    left, right : Region
    projective : bool
        How boards are interpolated; see `VirtualBoards.corners`.
    """

    rig: Rig
    boards: VirtualBoards
    left: Region
    right: Region
    projective: bool

    def right_to_left(self, height_mm: float) -> Array:
        """T_RL of algorithm 11 for the virtual board at a height: homography from the right to the left region."""
        to, of = self.boards.corners(height_mm, projective=self.projective)
        T, _ = cv2.findHomography(of, to, 0)
        return solved(self.left.to_ideal, np.asarray(T, dtype=np.float64) @ self.right.to_ideal)

    def parallax(self, height_mm: float) -> Array:
        """Change of `right_to_left` per mm of height, as the rig's cameras have it, at one height."""
        up, down = (self._by_cameras(height_mm + step) for step in (0.5, -0.5))
        return up / up[2, 2] - down / down[2, 2]

    def _by_cameras(self, height_mm: float) -> Array:
        left, right = (plane_to_ideal(camera, height_mm) for camera in (self.rig.left, self.rig.right))
        return solved(self.left.to_ideal, left @ solved(right, self.right.to_ideal))

    def to_plane(self, height_mm: float) -> Array:
        """Homography from the left region to (x, y), mm, on the plane z = height: eq. 3.13 read as a plane's."""
        return solved(plane_to_ideal(self.rig.left, height_mm), self.left.to_ideal)

    def test_rows(self, height_mm: float) -> Array:
        """Rows of the left region within P_re of the board's middle, P_re a quarter of the region (algorithm 12)."""
        corners, _ = self.boards.corners(height_mm, projective=self.projective)
        middle = float(transformed(solved(self.left.to_ideal, np.eye(3)), corners)[:, 1].mean())
        rows = self.left.picture.shape[0]
        middle = min(max(middle, rows / 4), 3 * rows / 4)
        return np.arange(math.ceil(middle - rows / 4), math.floor(middle + rows / 4) + 1, dtype=np.float64)

    def quality(self, left: BarOutline, right: BarOutline, height_mm: float) -> Quality:
        """Q_R and the offset of the outlines' centroids for the virtual board at a height (algorithm 12)."""
        return alignment_quality(left, right.moved(self.right_to_left(height_mm)), self.test_rows(height_mm))


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


def _sides(outline: BarOutline, rows: Array) -> tuple[Array, Array]:
    first, second = (_column(edge, rows) for edge in (outline.first, outline.second))
    return first, second


def _column(edge: Array, rows: Array) -> Array:
    """Column of a chain of points at given rows; beyond its ends it goes on straight."""
    below, above = rows < edge[0, 1], rows > edge[-1, 1]
    column = np.interp(rows, edge[:, 1], edge[:, 0])
    (x0, y0), (x1, y1) = edge[0], edge[-1]
    slope = (x1 - x0) / (y1 - y0)
    column[below] = x0 + slope * (rows[below] - y0)
    column[above] = x1 + slope * (rows[above] - y1)
    return column


def search_by_overlap(evaluate: Evaluate, boards: int = BOARDS) -> Height:
    """Algorithm 13 to the letter: of n boards the one whose |Q_R| is largest.

    Parameters
    ----------
    evaluate : callable
        Quality at a height.
    boards : int
        n.
    """
    heights = np.linspace(LOWEST_MM, HIGHEST_MM, boards)
    qualities = [evaluate(float(height)) for height in heights]
    return _best(heights, qualities, [-abs(quality.percent) for quality in qualities])


def search_by_offset(evaluate: Evaluate, boards: int = BOARDS) -> Height:
    """Algorithm 13 on the centroids: of n boards the one at which the outlines' centroids are nearest.

    The overlap is flat where one outline holds the other, as on rigs whose cameras are not alike.

    Parameters
    ----------
    evaluate : callable
        Quality at a height.
    boards : int
        n.
    """
    heights = np.linspace(LOWEST_MM, HIGHEST_MM, boards)
    qualities = [evaluate(float(height)) for height in heights]
    return _best(heights, qualities, [abs(quality.offset_px) for quality in qualities])


def _best(heights: Array, qualities: Sequence[Quality], costs: Sequence[float]) -> Height:
    cost = np.where(np.isfinite(costs), costs, np.inf)
    best = int(np.argmin(cost))
    height_mm = float(heights[best]) if np.isfinite(cost[best]) else math.nan
    return Height(height_mm, qualities[best], len(qualities))


class HeightLoop:
    """Algorithm 13 as a closed loop from frame to frame.

    It starts from the last frame's height, steps on the offset of the outlines' centroids with the slope that the rig
    gives, and ends after a few boards, also when the bar's size has jumped. Only where that leads nowhere all n boards
    are searched and the loop starts again from the best. Without a bar nothing is asked of it and its height stays.
    """

    def __init__(self) -> None:
        self.height_mm = math.nan

    def find(self, evaluate: Evaluate, offset_per_mm: Callable[[float], float]) -> Height:
        """Height at which the outlines' centroids coincide, in whole steps of `HEIGHT_STEP_MM`.

        Parameters
        ----------
        evaluate : callable
            Quality at a height.
        offset_per_mm : callable
            Change of the offset per mm, at a height.

        Returns
        -------
        Height
            NaN without such a height between `LOWEST_MM` and `HIGHEST_MM`; the loop then keeps its last height.
        """
        start_mm = self.height_mm if math.isfinite(self.height_mm) else FIRST_MM
        found = _follow(evaluate, offset_per_mm, start_mm)
        if not math.isfinite(found.height_mm):
            best = search_by_offset(evaluate)
            again = _follow(evaluate, lambda height: _slope(evaluate, height), best.height_mm)
            tried = found.evaluations + best.evaluations + again.evaluations
            found = Height(again.height_mm, again.quality, tried)
        if math.isfinite(found.height_mm):
            self.height_mm = found.height_mm
        return found


def _slope(evaluate: Evaluate, height_mm: float) -> float:
    """Change of the offset per mm, from two boards beside each other."""
    return evaluate(height_mm + 0.5).offset_px - evaluate(height_mm - 0.5).offset_px


def _follow(evaluate: Evaluate, offset_per_mm: Callable[[float], float], start_mm: float) -> Height:
    """Secant steps from a height, the first along the rig's slope; NaN when they lead too far or do not end."""
    height, tried = start_mm, 0
    slope = offset_per_mm(start_mm) if math.isfinite(start_mm) else math.nan
    before: tuple[float, float] | None = None
    while tried < ROUNDS and LOWEST_MM <= height <= HIGHEST_MM:
        quality = evaluate(height)
        tried += 1
        if before is not None:
            slope = (quality.offset_px - before[1]) / (height - before[0])
        if not abs(quality.offset_px) < abs(slope) * HIGHEST_MM:
            break
        goal = HEIGHT_STEP_MM * round((height - quality.offset_px / slope) / HEIGHT_STEP_MM)
        if abs(goal - height) < HEIGHT_STEP_MM / 2:
            return Height(goal, quality, tried)
        before, height = (height, quality.offset_px), goal
    return Height(math.nan, Quality(math.nan, math.nan), tried)
