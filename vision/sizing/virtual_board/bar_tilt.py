"""How much a bar rises along the line against the virtual boards, from where both views put it along its length.

On a board that is parallel to the bar the middles of both outlines keep their distance along the bar; on a board that
is not, it grows by the parallax of the rise. So the slope of that distance along the rows, over the change that a
millimetre of height makes, is the tilt: a stereo measurement, which needs a baseline across the bar.
"""

import math

import numpy as np
from numpy.typing import NDArray

from vision.alignment.quality import BarOutline, offsets_px
from vision.geometry.homography import transformed
from vision.sizing.virtual_board.aligned_pair import AlignedPair
from vision.sizing.virtual_board.reading import VirtualBoardReading, without_uncertainty

Array = NDArray[np.float64]

STEP_MM = 5.0  # chosen: of height, over which the parallax is measured
PARTS = 20  # chosen: places along the bar
LEAST_PARALLAX = 0.02  # chosen, px per mm: below it 0.05 px of an outline are 2.5 mm of height, and no tilt is told

# Chosen: patches of scale tilt an outline by up to 0.45 degrees (132 bars on level lines); a line that rises by less
# is not told from them in a single pair.
MOST_TILT_DEG = 0.8


def unless_tilted(reading: VirtualBoardReading, pair: AlignedPair) -> VirtualBoardReading:
    """The reading, without an uncertainty (`uncertainty_unknown`) where the bar rises against its boards.

    Parameters
    ----------
    reading : VirtualBoardReading
    pair : AlignedPair
        Of the same pictures.
    """
    tilted = abs(bar_tilt_deg(pair)) > MOST_TILT_DEG  # false for NaN: not told
    return without_uncertainty(reading) if tilted and reading.valid else reading


def bar_tilt_deg(pair: AlignedPair) -> float:
    """Rise of the bar along y against the boards of its alignment, degrees.

    Parameters
    ----------
    pair : AlignedPair

    Returns
    -------
    float
        NaN where an outline is missing or the views have no parallax.
    """
    left, right = (view.outline for view in pair.edges)
    if left is None or right is None:
        return math.nan
    alignment, height_mm = pair.alignment, pair.height.height_mm
    rows = np.linspace(0.1, 0.9, PARTS) * alignment.left.shape[0]
    at, above = (_apart_px(pair, left, right, height, rows) for height in (height_mm, height_mm + STEP_MM))
    per_mm = float(np.mean(above - at)) / STEP_MM
    if not abs(per_mm) >= LEAST_PARALLAX:
        return math.nan
    middle = np.column_stack([np.full(PARTS, left.first[:, 0].mean()), rows])
    y_mm = transformed(alignment.to_plane(height_mm), middle)[:, 1]
    off_mm = y_mm - y_mm.mean()
    return math.degrees(math.atan(float(off_mm @ (-at / per_mm)) / float(off_mm @ off_mm)))


def _apart_px(pair: AlignedPair, left: BarOutline, right: BarOutline, height_mm: float, rows: Array) -> Array:
    """Distance of the outlines' middles across the bar in each row, on a board at a height."""
    moved = right.moved(pair.alignment.right_to_left(height_mm))
    return offsets_px(left, moved, rows)
