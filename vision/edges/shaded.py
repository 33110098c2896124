"""Half level at the limb of a round bar, whose light falls off towards the limb (shading)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.edges.subpixel import Crossings, edge_blur_px, edge_shading, half_level_crossing

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ShadedCrossings:
    """Where n profiles cross half level, corrected for the bar's shading towards its limb.

    Attributes
    ----------
    crossings : Crossings
    unshaded_px : ndarray of float64, shape (n,)
        Crossings without the correction for shading.
    blur_px : float
        Standard deviation of the edge's blur.
    """

    crossings: Crossings
    unshaded_px: Array
    blur_px: float


def shaded_crossings(profile: Array, offsets_px: Array, first_blur_px: float) -> ShadedCrossings | None:
    """Half level of an edge near the middle of its profiles, corrected for shading.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Offsets of the samples along a profile, evenly spaced, increasing.
    first_blur_px : float
        Standard deviation of the blur that is assumed until the edge's own is estimated.

    Returns
    -------
    ShadedCrossings or None
        None when no profile has an edge whose blur could be estimated.
    """
    first = half_level_crossing(profile, offsets_px, first_blur_px, expected_px=0.0)
    blur_px = edge_blur_px(profile, offsets_px, first.place_px)
    if not np.isfinite(blur_px):
        return None
    unshaded = half_level_crossing(profile, offsets_px, blur_px, expected_px=0.0)
    shading = edge_shading(profile, offsets_px, unshaded, blur_px)
    crossings = half_level_crossing(profile, offsets_px, blur_px, expected_px=0.0, shading=shading)
    return ShadedCrossings(crossings, unshaded.place_px, blur_px)
