"""Edges near the bar in one view and in fused pictures (figures 5.9 to 5.13): wrong ones, and the bar's own."""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.alignment.quality import BarOutline
from vision.edges.binary import binarised
from vision.edges.operators import detect_edges
from vision.edges.thinning import ridges
from vision.fusion.methods import fuse
from vision.fusion.names import Method
from vision.sizing.virtual_board.aligned_pair import AlignedPair

CONFIDENCE = 0.3  # "a threshold value of 30 %", section 5.1.3
NEAR_PX = 3.0  # chosen: an edge this near to the bar's is the bar's


class EdgesNear(NamedTuple):
    """Edges of one picture.

    Attributes
    ----------
    false : float
        Edge pixels per row that are further than `NEAR_PX` from the bar's edges in either view.
    kept : float
        Share of rows and sides with an edge pixel nearer than that.
    """

    false: float
    kept: float


def edges_near(pair: AlignedPair, methods: Sequence[Method]) -> dict[str, EdgesNear]:
    """Edges of the left view and of its fusions with the right one, in the strip around the bar.

    Parameters
    ----------
    pair : AlignedPair
        With the outlines of both views.
    methods : sequence of str
        Of `vision.fusion.methods`.
    """
    left, right = pair.alignment.left.picture, pair.alignment.right_on_left(pair.height.height_mm)
    onto = pair.alignment.right_to_left(pair.height.height_mm)
    outlines = [view.outline for view in pair.edges]
    moved = [one if not place else one.moved(onto) for place, one in enumerate(outlines) if one is not None]
    columns = np.array([_columns(outline, left.shape[0]) for outline in moved])
    pictures = {"left": left} | {method: fuse(left, right, method) for method in methods}
    return {name: _counted(picture, columns) for name, picture in pictures.items()}


def _columns(outline: BarOutline, rows: int) -> NDArray[np.float64]:
    """Columns of both edges in each row, shape (2, rows)."""
    lines = [np.polyfit(edge[:, 1], edge[:, 0], 1) for edge in (outline.first, outline.second)]
    return np.array([np.polyval(line, np.arange(rows)) for line in lines], dtype=np.float64)


def _counted(picture: NDArray[np.uint8], columns: NDArray[np.float64]) -> EdgesNear:
    ordered = picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB))
    found = detect_edges(np.multiply(ordered, np.float32(1 / 255), dtype=np.float32), "forest")
    row, column = np.nonzero(binarised(ridges(found.strength, found.normal_rad), CONFIDENCE))
    away = np.abs(column - columns[:, :, row])  # views, sides, pixels
    near = away.min(axis=0) <= NEAR_PX
    rows = len(picture)
    kept = sum(np.unique(row[side]).size for side in near) / (2 * rows)
    return EdgesNear(float((~near.any(axis=0)).sum() / rows), float(kept))
