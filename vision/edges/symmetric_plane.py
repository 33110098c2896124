"""Which of several guesses of an overexposed channel's light makes an edge symmetric.

Where red is clipped, nothing tells how much light it lost, and luma holds red. But a lens blurs a straight edge alike
to both sides, L(d) + L(-d) = D + B in light, and only under the right guess the decoded luma does that.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from vision.edges.subpixel import half_level_crossing
from vision.light_planes import LightPlane

Array = NDArray[np.float64]

FLANK_PX = np.arange(0.25, 3.1, 0.25)  # distances from half level at which both flanks are compared
PLATEAU_PX = np.array([3.5, 4.0, 4.5, 5.0])
BLUR_PX = 1.5  # taken for where plateaus begin


def settled(
    planes: Sequence[LightPlane], profiles: Callable[[LightPlane], Array], offsets_px: Array
) -> list[LightPlane]:
    """Planes as they are; of guesses the one under which the edge is most symmetric.

    Parameters
    ----------
    planes : sequence of LightPlane
    profiles : callable
        Gives some profiles of the edge, shape (n, m), dark side first, decoded by a plane.
    offsets_px : ndarray of float64, shape (m,)
        Places on each profile, evenly spaced.
    """
    if not planes[0].is_guess:
        return list(planes)
    return [min(planes, key=lambda plane: _asymmetry(profiles(plane), offsets_px))]


def _asymmetry(profile: Array, offsets_px: Array) -> float:
    """Root mean square of y(d) + y(-d) - 1 on the median profile, y from 0 to 1; infinite without an edge."""
    place = half_level_crossing(profile, offsets_px, BLUR_PX).place_px
    middle = np.nanmedian(place) if np.isfinite(place).any() else np.nan
    found = np.flatnonzero(np.abs(place - middle) < 2 * BLUR_PX)
    if not found.size:
        return np.inf
    levels = [_aligned(profile[found], offsets_px, place[found], d) for d in (-PLATEAU_PX, PLATEAU_PX)]
    dark, bright = (float(np.mean(level)) for level in levels)
    flanks = [_aligned(profile[found], offsets_px, place[found], d) for d in (-FLANK_PX, FLANK_PX)]
    off = (flanks[0] + flanks[1] - dark - bright) / (bright - dark)
    return float(np.sqrt(np.mean(off**2)))


def _aligned(profile: Array, offsets_px: Array, place: Array, distances_px: Array) -> Array:
    """Median light at distances from each profile's own crossing."""
    return np.nanmedian(
        [np.interp(at + distances_px, offsets_px, row) for at, row in zip(place, profile, strict=True)], axis=0
    )
