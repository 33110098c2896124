"""Where a straight edge crosses its profiles, to a fraction of a pixel, halfway in light."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, special

Array = NDArray[np.float64]

PLATEAU_PX = 2.0  # width over which the level on either side of the edge is averaged
DEEPER_PX = 3.0  # width of the plateau behind it, which tells how light changes with depth
CLEARLY = 0.15  # of the step from background to bar: more than a reflection, less than a dark patch on the bar
REACH_SIGMAS = 2.2  # beyond it less than 1.4 % of the step is missing on either side, alike
LEAST_REACH_PX = 1.5  # bilinear interpolation alone blurs that far


def sample_profiles(
    light: NDArray[np.float32], point_px: Array, normal: Array, offsets_px: Array
) -> NDArray[np.float64]:
    """Light along straight profiles, bilinear between pixel centres.

    Parameters
    ----------
    light : ndarray of float32, shape (rows, columns)
        Linear light.
    point_px : ndarray of float64, shape (n, 2)
        Middles of the profiles, (x, y).
    normal : ndarray of float64, shape (n, 2)
        Unit vectors along which they run, (x, y).
    offsets_px : ndarray of float64, shape (m,)
        Places on each profile.

    Returns
    -------
    ndarray of float64, shape (n, m)
        NaN outside the image.
    """
    x = point_px[:, 0, None] + normal[:, 0, None] * offsets_px
    y = point_px[:, 1, None] + normal[:, 1, None] * offsets_px
    return ndimage.map_coordinates(light, [y, x], output=np.float64, order=1, cval=np.nan)


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Where n profiles cross half level.

    Attributes
    ----------
    place_px : ndarray of float64, shape (n,)
        Offset of the crossing; NaN where the profile leaves the image, has no step, or a plateau does not fit in.
    dark, bright : ndarray of float64, shape (n,)
        Levels of both plateaus.
    """

    place_px: Array
    dark: Array
    bright: Array


def half_level_crossing(
    profile: Array, offsets_px: Array, blur_px: float, *, expected_px: float | None = None, shading: float = 0.0
) -> Crossings:
    """Place on each profile where light is halfway between its two plateaus.

    Profiles run from the dark side to the bright one. The plateaus begin where the edge's blur has died away on
    either side of the edge, and are found anew around the first crossing, so that the levels belong to
    this edge and not to what lies further off.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light.
    offsets_px : ndarray of float64, shape (m,)
        Places, evenly spaced, increasing.
    blur_px : float
        Standard deviation of the edge's blur.
    expected_px : float, optional
        Where the edge is to within its blur; without it the first clear rise is taken.
    shading : float
        Share of the step by which the bright side is darker at its edge than on its plateau; see `edge_shading`.

    Returns
    -------
    Crossings
    """
    reach = max(LEAST_REACH_PX, REACH_SIGMAS * blur_px)
    start = _outermost(profile, offsets_px, reach) if expected_px is None else np.full(len(profile), expected_px)
    first = _between_plateaus(profile, offsets_px, start, reach, shading)
    return _between_plateaus(profile, offsets_px, first.place_px, reach, shading)


def edge_shading(profile: Array, offsets_px: Array, crossings: Crossings, blur_px: float) -> float:
    """Share of the step by which the limb of a round bar is darker than the plateau beside it.

    Light that depends on the angle at which it leaves a cylinder changes with the square root of the depth below the
    limb: L(d) = L0 + k sqrt(d). k follows from two plateaus at different depths, less what the dark side shows in
    the mirror: there the lens' own halo is the same, and it moves no edge. At the limb itself the blur, of
    standard deviation sigma, turns L into half of L0 + 0.822 k sqrt(sigma), 0.822 being the mean root of a standard
    normal variable's absolute value.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Places.
    crossings : Crossings
        Found without shading.
    blur_px : float
        Standard deviation of the edge's blur.

    Returns
    -------
    float
        Median over the profiles, so that patches on the bar do not count; 0 without any profile.
    """
    reach = max(LEAST_REACH_PX, REACH_SIGMAS * blur_px)
    plateau, behind = (reach, reach + PLATEAU_PX), (reach + PLATEAU_PX, reach + PLATEAU_PX + DEEPER_PX)
    deeper = _plateau(profile, offsets_px, crossings.place_px, +1, behind)
    further = _plateau(profile, offsets_px, crossings.place_px, -1, behind)
    root, deeper_root = _mean_root(plateau), _mean_root(behind)
    rise = (deeper - crossings.bright) - (crossings.dark - further)
    with np.errstate(divide="ignore", invalid="ignore"):
        k = rise / (crossings.bright - crossings.dark) / (deeper_root - root)
    found = k[np.isfinite(k)]
    return float(np.median(found) * (root - 0.822 * np.sqrt(blur_px))) if found.size else 0.0


def _mean_root(span: tuple[float, float]) -> float:
    """Mean square root of the numbers between two."""
    return (span[1] ** 1.5 - span[0] ** 1.5) / (1.5 * (span[1] - span[0]))


def edge_blur_px(profile: Array, offsets_px: Array, place_px: Array) -> float:
    """Standard deviation of the Gaussian blur whose edge is as steep at half level as the median profile.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Places.
    place_px : ndarray of float64, shape (n,)
        Crossings; finite.

    Returns
    -------
    float
        Pixels, the bilinear interpolation's own blur included.
    """
    near, far = 0.5, 5.0
    level = [
        np.median([np.interp(at + d, offsets_px, row) for row, at in zip(profile, place_px, strict=True)])
        for d in (-far, -near, near, far)
    ]
    steepness = np.clip((level[2] - level[1]) / max(level[3] - level[0], 1e-9), 1e-3, 1 - 1e-6)
    return float(near / (np.sqrt(2) * special.erfinv(steepness)))


def _outermost(profile: Array, offsets_px: Array, reach: float) -> Array:
    """First place from the dark side that is clearly brighter than the background, far enough from both ends.

    A dark patch on the bar has edges of its own, often steeper ones; the bar's edge is the first.
    """
    inner = np.abs(offsets_px) <= offsets_px[-1] - reach - 1
    whole = profile[np.isfinite(profile).all(axis=1)]
    if not len(whole):
        return np.full(len(profile), np.nan)
    dark = np.median(whole[:, offsets_px < offsets_px[inner][0]])
    bright = np.median(whole[:, offsets_px > offsets_px[inner][-1]])
    above = profile[:, inner] > dark + CLEARLY * (bright - dark)
    return offsets_px[inner][np.argmax(above, axis=1)]


def _between_plateaus(profile: Array, offsets_px: Array, near: Array, reach: float, shading: float) -> Crossings:
    """Crossing halfway between the plateaus on either side of a place."""
    dark = _plateau(profile, offsets_px, near, -1, (reach, reach + PLATEAU_PX))
    bright = _plateau(profile, offsets_px, near, +1, (reach, reach + PLATEAU_PX))
    bright = bright - shading * (bright - dark)
    place = _crossing(profile, offsets_px, 0.5 * (dark + bright), near)
    return Crossings(np.where(bright > dark, place, np.nan), dark, bright)


def _plateau(profile: Array, offsets_px: Array, place: Array, side: int, span: tuple[float, float]) -> Array:
    """Mean light between two distances from a place on one side of it."""
    away = side * (offsets_px - place[:, None])
    inside = (away >= span[0]) & (away <= span[1])
    count = np.count_nonzero(inside, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(inside, profile, 0.0).sum(axis=1) / count


def _crossing(profile: Array, offsets_px: Array, level: Array, place: Array) -> Array:
    """Upward crossing of the level that is nearest to a place."""
    above = profile >= level[:, None]
    rises = ~above[:, :-1] & above[:, 1:]
    distance = np.abs(0.5 * (offsets_px[1:] + offsets_px[:-1]) - place[:, None])
    distance[~rises] = np.inf
    nearest = np.argmin(distance, axis=1)
    row = np.arange(profile.shape[0])
    low, high = profile[row, nearest], profile[row, nearest + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        place = offsets_px[nearest] + (level - low) / (high - low) * (offsets_px[1] - offsets_px[0])
    return np.where(np.isfinite(distance[row, nearest]) & np.isfinite(level), place, np.nan)
