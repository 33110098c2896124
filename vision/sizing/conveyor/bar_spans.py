"""Where a bar is between the barriers: hot columns row by row, by what a picture shows more than the empty line."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.reasons import Reason
from vision.sizing.conveyor.barriers import Barriers
from vision.sizing.limits import COVERED_SHARE

Plane = NDArray[np.float32]

LEAST_GAIN_CHANGE = 0.2  # chosen: a line that is darker than its empty picture by more has been dimmed by the camera
HOT_FLOOR_LIGHT = 0.08  # chosen: a bar is brighter than the empty line by more than 8 % of full scale
OPENING_PX = 5  # chosen: side of the square that opens the mask of what is hot
LEAST_BAR_PX = 8  # chosen: fewer hot columns are no bar
LEAST_GAP_PX = 9.0  # chosen: nearer to a barrier the bar's edge has no dark side
END_ROWS = 4  # chosen: rows at either end of the picture that are left out
DARK_PERCENTILE = 20  # chosen: of the light between barriers in a row, the conveyor beside a bar


def bar_spans(light: Plane, empty: Plane) -> NDArray[np.int64] | Reason:
    """First and last hot column of the bar in each row, shape (rows, 2), -1 where there is none (algorithm 5).

    Parameters
    ----------
    light, empty : ndarray of float32, shape (rows, columns)
        With the bar and without.

    Returns
    -------
    ndarray of int64 or Reason
        `no_bar`, `several_bars` or `bar_too_short` without a bar to be measured.
    """
    more = np.clip(np.rint(255 * np.clip(light - empty, 0, 1)), 0, 255).astype(np.uint8)
    level, _ = cv2.threshold(more, 0, 1, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    mask = (more > max(level, 255 * HOT_FLOOR_LIGHT)).astype(np.uint8)
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((OPENING_PX, OPENING_PX), np.uint8)))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    rows = len(light)
    long = [i for i in range(1, count) if stats[i, cv2.CC_STAT_HEIGHT] >= COVERED_SHARE * rows]
    if not long:
        hot = stats[1:, cv2.CC_STAT_AREA].max(initial=0)
        return Reason.BAR_TOO_SHORT if hot > LEAST_BAR_PX * COVERED_SHARE * rows / 2 else Reason.NO_BAR
    if len(long) > 1:
        return Reason.SEVERAL_BARS
    bar = labels == long[0]
    first, last = bar.argmax(axis=1), bar.shape[1] - 1 - bar[:, ::-1].argmax(axis=1)
    there = bar.any(axis=1) & (last - first >= LEAST_BAR_PX)
    spans = np.where(there[:, None], np.column_stack([first, last]), -1)
    spans[:END_ROWS] = spans[-END_ROWS:] = -1
    return spans if np.count_nonzero(spans[:, 0] >= 0) >= COVERED_SHARE * rows else Reason.BAR_TOO_SHORT


def hidden_bar(light: Plane, empty: Plane) -> Reason:
    """`no_bar`, unless a bar shows as dark on light, or against the empty line at the gain of this picture.

    Parameters
    ----------
    light, empty : ndarray of float32, shape (rows, columns)
        With the bar that `bar_spans` does not find, and without.

    Returns
    -------
    Reason
        `no_bar`, or `edge_not_found` with `low_contrast`.
    """
    if not isinstance(bar_spans(empty, light), Reason):
        return Reason.EDGE_NOT_FOUND | Reason.LOW_CONTRAST
    lit = empty > HOT_FLOOR_LIGHT
    gain = float(np.median(light[lit] / empty[lit])) if lit.any() else 1.0
    if gain < 1 - LEAST_GAIN_CHANGE and not isinstance(bar_spans(light, gain * empty), Reason):
        return Reason.EDGE_NOT_FOUND | Reason.LOW_CONTRAST
    return Reason.NO_BAR


def without_bar(barriers: Barriers) -> Plane:
    """The empty line, 0 to 1; where its picture shows a bar, rows between barriers are as light as their dark part."""
    light = barriers.light
    rows, columns = light.shape
    edges = barriers.columns(np.arange(rows, dtype=np.float64))
    inside = (np.arange(columns) > edges[:, :1] + LEAST_GAP_PX) & (np.arange(columns) < edges[:, 1:] - LEAST_GAP_PX)
    between = np.where(inside, light, np.nan)
    shown = inside.any(axis=1)
    dark = np.zeros((rows, 1))
    dark[shown] = np.nanpercentile(between[shown], DARK_PERCENTILE, axis=1)[:, None]
    flat = np.where(inside, np.minimum(light, dark), light).astype(np.float32)
    return light if bar_spans(light, flat) is Reason.NO_BAR else flat
