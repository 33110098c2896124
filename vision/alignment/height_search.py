"""The height of the virtual board at which the bar's outlines agree: algorithm 13, and a loop from frame to frame."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.alignment.quality import Quality

Array = NDArray[np.float64]

LOWEST_BOARD_MM, HIGHEST_BOARD_MM = 0.0, 320.0  # heights at which the outlines of bars of 40 to 500 mm may agree
BOARD_COUNT = 40  # chosen: n of algorithm 13, which the dissertation does not give
HEIGHT_STEP_MM = 0.01  # chosen: heights are whole steps, so that the result does not depend on the loop's start
FIRST_HEIGHT_MM = 100.0  # chosen: the loop begins there before the first bar
MOST_EVALUATIONS = 6  # chosen: boards that the loop tries before it gives up and all boards are searched


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


def search_by_overlap(evaluate: Evaluate, boards: int = BOARD_COUNT) -> Height:
    """Algorithm 13 to the letter: of n boards the one whose |Q_R| is largest.

    Parameters
    ----------
    evaluate : callable
        Quality at a height.
    boards : int
        n.
    """
    heights = np.linspace(LOWEST_BOARD_MM, HIGHEST_BOARD_MM, boards)
    qualities = [evaluate(float(height)) for height in heights]
    return _best(heights, qualities, [-abs(quality.percent) for quality in qualities])


def search_by_offset(evaluate: Evaluate, boards: int = BOARD_COUNT) -> Height:
    """Algorithm 13 on the centroids: of n boards the one at which the outlines' centroids are nearest.

    The overlap is flat where one outline holds the other, as on rigs whose cameras are not alike.

    Parameters
    ----------
    evaluate : callable
        Quality at a height.
    boards : int
        n.
    """
    heights = np.linspace(LOWEST_BOARD_MM, HIGHEST_BOARD_MM, boards)
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
    gives, and ends after a few boards, also when the bar's size has jumped. Only if it does not end all n boards are
    searched and the loop starts again from the best. Without a bar it is not called and its height stays.
    """

    def __init__(self) -> None:
        self.height_mm = math.nan

    def find(self, evaluate: Evaluate, offset_per_mm: Callable[[float], float], boards: int = BOARD_COUNT) -> Height:
        """Height at which the outlines' centroids coincide, in whole steps of `HEIGHT_STEP_MM`.

        Parameters
        ----------
        evaluate : callable
            Quality at a height.
        offset_per_mm : callable
            Change of the offset per mm, at a height.
        boards : int
            n of the search that follows where the loop does not end.

        Returns
        -------
        Height
            NaN without such a height between `LOWEST_BOARD_MM` and `HIGHEST_BOARD_MM`; the loop then keeps its last
            height.
        """
        start_mm = self.height_mm if math.isfinite(self.height_mm) else FIRST_HEIGHT_MM
        found = _follow(evaluate, offset_per_mm, start_mm)
        if not math.isfinite(found.height_mm):
            best = search_by_offset(evaluate, boards)
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
    """Secant steps from a height, the first along the rig's slope; NaN when they leave the range or do not converge."""
    height, tried = start_mm, 0
    slope = offset_per_mm(start_mm) if math.isfinite(start_mm) else math.nan
    before: tuple[float, float] | None = None
    while tried < MOST_EVALUATIONS and LOWEST_BOARD_MM <= height <= HIGHEST_BOARD_MM:
        quality = evaluate(height)
        tried += 1
        if before is not None:
            slope = (quality.offset_px - before[1]) / (height - before[0])
        if not abs(quality.offset_px) < abs(slope) * HIGHEST_BOARD_MM:
            break
        goal = HEIGHT_STEP_MM * round((height - quality.offset_px / slope) / HEIGHT_STEP_MM)
        if abs(goal - height) < HEIGHT_STEP_MM / 2:
            return Height(goal, quality, tried)
        before, height = (height, quality.offset_px), goal
    return Height(math.nan, Quality(math.nan, math.nan), tried)
