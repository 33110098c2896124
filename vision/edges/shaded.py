"""Half level at the limb of a round bar, which is darker there than further inside."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.edges.subpixel import Crossings, edge_blur_px, edge_shading, half_level_crossing

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ShadedCrossings:
    """Where n profiles cross half level, the bar's shading towards its limb counted.

    Attributes
    ----------
    crossings : Crossings
    unshaded_px : ndarray of float64, shape (n,)
        Where they would cross without any shading.
    blur_px : float
        Standard deviation of the edge's blur.
    """

    crossings: Crossings
    unshaded_px: Array
    blur_px: float


def shaded_crossings(profile: Array, offsets_px: Array, first_blur_px: float) -> ShadedCrossings | None:
    """Half level of an edge near the middle of its profiles.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Places, evenly spaced, increasing.
    first_blur_px : float
        Blur that is taken until the edge's own is known.

    Returns
    -------
    ShadedCrossings or None
        None when the profiles tell no blur: too few of them have an edge.
    """
    first = half_level_crossing(profile, offsets_px, first_blur_px, expected_px=0.0)
    blur_px = edge_blur_px(profile, offsets_px, first.place_px)
    if not np.isfinite(blur_px):
        return None
    unshaded = half_level_crossing(profile, offsets_px, blur_px, expected_px=0.0)
    shading = edge_shading(profile, offsets_px, unshaded, blur_px)
    crossings = half_level_crossing(profile, offsets_px, blur_px, expected_px=0.0, shading=shading)
    return ShadedCrossings(crossings, unshaded.place_px, blur_px)
