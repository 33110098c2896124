"""How much a bar rises along the line against the virtual boards, from where both views put it along its length.

On a board that is parallel to the bar the middles of both outlines keep their distance along the bar; on a board that
is not, it grows by the parallax of the rise. So the slope of that distance along the rows, over the change that a
millimetre of height makes, is the tilt: a stereo measurement, which needs a baseline across the bar.
"""

import numpy as np
from numpy.typing import NDArray

from vision.alignment.quality import BarOutline, alignment_quality
from vision.geometry.homography import transformed
from vision.sizing.virtual_board.aligned_pair import AlignedPair

Array = NDArray[np.float64]

STEP_MM = 5.0  # chosen: of height, over which the parallax is measured
PARTS = 20  # chosen: places along the bar
LEAST_PARALLAX = 0.02  # chosen, px per mm: below it 0.05 px of an outline are 2.5 mm of height, and no tilt is told


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
        return float("nan")
    alignment, height_mm = pair.alignment, pair.height.height_mm
    rows = np.linspace(0.1, 0.9, PARTS) * alignment.left.shape[0]
    at, above = (_apart_px(pair, left, right, height, rows) for height in (height_mm, height_mm + STEP_MM))
    per_mm = float(np.mean(above - at)) / STEP_MM
    if not abs(per_mm) >= LEAST_PARALLAX:
        return float("nan")
    middle = np.column_stack([np.full(PARTS, left.first[:, 0].mean()), rows])
    y_mm = transformed(alignment.to_plane(height_mm), middle)[:, 1]
    rise = np.polyfit(y_mm, -at / per_mm, 1)[0]
    return float(np.rad2deg(np.arctan(rise)))


def _apart_px(pair: AlignedPair, left: BarOutline, right: BarOutline, height_mm: float, rows: Array) -> Array:
    """Distance of the outlines' middles across the bar in each row, on a board at a height."""
    moved = right.moved(pair.alignment.right_to_left(height_mm))
    return np.array([alignment_quality(left, moved, rows[[place]]).offset_px for place in range(len(rows))])
