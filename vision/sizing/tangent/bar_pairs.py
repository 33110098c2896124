"""Which outline of the left view and which of the right one are the same bar, where there are several side by side."""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Rig
from vision.geometry.measuring_plane import pixel_size_mm
from vision.sizing.limits import DIAMETER_MM, OFF_ROLLERS_MM, OFF_ROLLERS_SHARE
from vision.sizing.region_grid import Outline
from vision.sizing.tangent.tangent_planes import TangentPlane, rough_cylinder

Array = NDArray[np.float64]

MOST_BARS = 4  # bars that are measured side by side
# Chosen: two blurred edges of 2 px and a plateau of 2 px between them, with 2 px to spare.
# Outlines lie on whole pixels: half a pixel more, so that rounding does not decide over a gap of just 8 px.
LEAST_GAP_PX = 8.5
ROUGH_OUTLINE_MM = 4.0  # an outline lies within a few pixels of its limbs, and height is known less well by it


def pairs_of_bars(
    rig: Rig, left: Sequence[Outline], right: Sequence[Outline]
) -> tuple[list[tuple[Outline, Outline]], int]:
    """Outlines of both views that are one bar on the rollers, from smaller x.

    Bars lie on the rollers: outlines of different bars would meet far above or below. The pairs are those, in the same
    order in both views, whose axes lie nearest to R over the rollers.

    Parameters
    ----------
    rig : Rig
    left, right : sequence of Outline
        From smaller x.

    Returns
    -------
    pairs : list of tuple of two Outline
    alone : int
        Outlines without a partner in the other view.
    """
    off = np.array([[_off_rollers_mm(rig, one, other) for other in right] for one in left])
    pairs: list[tuple[Outline, Outline]] = []
    first = 0
    for index, one in enumerate(left):
        fitting = [place for place in range(first, len(right)) if np.isfinite(off[index, place])]
        if not fitting:
            continue
        place = min(fitting, key=lambda number: off[index, number])
        if any(off[later, place] < off[index, place] for later in range(index + 1, len(left))):
            continue  # the outline of the right view is another bar's
        pairs.append((one, right[place]))
        first = place + 1
    return pairs, len(left) + len(right) - 2 * len(pairs)


def crowded(rig: Rig, outlines: tuple[Sequence[Outline], Sequence[Outline]]) -> tuple[list[Outline], list[Outline]]:
    """Outlines of each view that come so near to a neighbour that its light lies in the dark beside their limbs.

    Parameters
    ----------
    rig : Rig
    outlines : tuple of two sequences of Outline
        Of the left and of the right view, from smaller x.
    """
    left, right = (
        [
            one
            for first, second in itertools.pairwise(view)
            for one in (first, second)
            if _gap_mm(first, second, rig.region_y_mm) < LEAST_GAP_PX * pixel_size_mm(camera)
        ]
        for camera, view in zip((rig.left, rig.right), outlines, strict=True)
    )
    return left, right


def _gap_mm(first: Outline, second: Outline, region_y_mm: tuple[float, float]) -> float:
    """Least distance of two neighbouring outlines over the region."""
    ends_mm = np.array(region_y_mm)
    return float(np.min((second.left - first.right)[0] * ends_mm + (second.left - first.right)[1]))


def _off_rollers_mm(rig: Rig, left: Outline, right: Outline) -> float:
    """How far the cylinder of two outlines lies off the rollers; infinite where it cannot be a bar."""
    planes = [
        TangentPlane.through(camera.centre_mm, line, side)
        for camera, outline in ((rig.left, left), (rig.right, right))
        for line, side in ((outline.left, -1), (outline.right, +1))
    ]
    cylinder = rough_cylinder(planes)
    if cylinder is None or not DIAMETER_MM[0] <= 2 * cylinder[4] <= DIAMETER_MM[1]:
        return np.inf
    off_mm = abs(float(cylinder[1] - cylinder[4]))
    limit_mm = OFF_ROLLERS_SHARE * 2 * cylinder[4] + OFF_ROLLERS_MM + ROUGH_OUTLINE_MM
    return off_mm if off_mm <= limit_mm else np.inf
