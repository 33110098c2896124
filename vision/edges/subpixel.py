"""Where a straight edge crosses its profiles, to a fraction of a pixel, halfway in light.

Profiles run from the dark side to the bright one. Half level between the plateaus on either side gives each crossing;
the median profile of the edge then tells its own shape, blur, halo and all, and fitting that shape over the dark flank
alone locates the edge anew without looking far into the bar, where patches may lie.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import special

Array = NDArray[np.float64]

PLATEAU_PX = 2.0  # width over which the level on either side of the edge is averaged
DEEPER_PX = 3.0  # width of the plateau behind it, which tells how light changes with depth
CLEARLY = 0.15  # of the step from background to bar: more than a reflection, less than a dark patch on the bar
REACH_SIGMAS = 2.2  # beyond it less than 1.4 % of the step is missing on either side, alike
LEAST_REACH_PX = 1.5  # bilinear interpolation alone blurs that far
SHAPE_PX = 6.0  # half length of an edge's own shape
SHAPE_STEP_PX = 0.25
FLANK_SIGMAS = (3.0, 1.2)  # outwards and inwards of the edge: where its shape is fitted
FIT_ROUNDS = 6
MISFIT, MISFITS = 0.04, 3.0  # of the step, root mean square, and of the median: beyond both it is another edge
EVEN, UNEVEN = 0.08, 0.15  # of the step: how far light behind the edge may differ, without and with noise
QUIET, NOISES = 0.25, 4.0  # share of the profiles that differ by noise alone, and how many times that is no noise
LEAST_EVEN = 0.4  # of the profiles: so many are kept
MOVED_PX = 1.5  # a fit that leaves its crossing further has found something else


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

    The plateaus begin where the edge's blur has died away on either side of the edge, and are found anew around the
    first crossing, so that the levels belong to this edge and not to what lies further off.

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
    reach = _reach(blur_px)
    start = _outermost(profile, offsets_px, reach) if expected_px is None else np.full(len(profile), expected_px)
    return Crossings(*_cross(profile, *_grid(offsets_px), start, reach, shading))


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
    reach = _reach(blur_px)
    plateau, behind = (reach, reach + PLATEAU_PX), (reach + PLATEAU_PX, reach + PLATEAU_PX + DEEPER_PX)
    deeper = _levels(profile, *_grid(offsets_px), crossings.place_px, 1, *behind)
    further = _levels(profile, *_grid(offsets_px), crossings.place_px, -1, *behind)
    root, deeper_root = _mean_root(plateau), _mean_root(behind)
    rise = (deeper - crossings.bright) - (crossings.dark - further)
    with np.errstate(divide="ignore", invalid="ignore"):
        k = rise / (crossings.bright - crossings.dark) / (deeper_root - root)
    found = k[np.isfinite(k)]
    return float(np.median(found) * (root - 0.822 * np.sqrt(blur_px))) if found.size else 0.0


def edge_blur_px(profile: Array, offsets_px: Array, place_px: Array) -> float:
    """Standard deviation of the Gaussian blur whose edge is as steep at half level as the median profile.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Places.
    place_px : ndarray of float64, shape (n,)
        Crossings; NaN where there is none.

    Returns
    -------
    float
        Pixels, the bilinear interpolation's own blur included; NaN without any crossing.
    """
    near, far = 0.5, 5.0
    around = _around(profile, *_grid(offsets_px), place_px, np.array([-far, -near, near, far]))
    around = around[np.isfinite(around).all(axis=1)]
    if not len(around):
        return np.nan
    level = np.median(around, axis=0)
    steepness = np.clip((level[2] - level[1]) / max(level[3] - level[0], 1e-9), 1e-3, 1 - 1e-6)
    return float(near / (np.sqrt(2) * special.erfinv(steepness)))


def even_profiles(profile: Array, offsets_px: Array, crossings: Crossings, blur_px: float) -> NDArray[np.intp]:
    """Numbers of the half of the profiles whose light is most even behind the edge: those cross no patch.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Places.
    crossings : Crossings
    blur_px : float
        Standard deviation of the edge's blur.

    Returns
    -------
    ndarray of int
        Empty without any crossing.
    """
    reach = _reach(blur_px)
    behind = _levels(profile, *_grid(offsets_px), crossings.place_px, 1, reach + PLATEAU_PX, reach + 2 * PLATEAU_PX)
    with np.errstate(divide="ignore", invalid="ignore"):
        uneven = np.abs(behind - crossings.bright) / (crossings.bright - crossings.dark)
    usable = np.flatnonzero(np.isfinite(uneven) & np.isfinite(crossings.place_px))
    return usable[np.argsort(uneven[usable], kind="stable")[: (usable.size + 1) // 2]]


def fitted_edges(
    profile: Array, offsets_px: Array, crossings: Crossings, even: NDArray[np.intp], blur_px: float
) -> tuple[Array, Array, float]:
    """Place of the edge on each profile by least squares of D + A T(x - e) over its dark flank.

    D is the dark plateau, T the edge's shape; the step A and the place e are fitted. What lies on the bar more than
    about one standard deviation of the blur behind the edge does not count.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Places.
    crossings : Crossings
        First guess.
    even : ndarray of int
        Numbers of profiles that cross no patch; see `even_profiles`.
    blur_px : float
        Standard deviation of the edge's blur.

    Returns
    -------
    place_px : ndarray of float64, shape (n,)
        NaN where the profile has no edge of this shape, or crosses a patch close behind it.
    step : ndarray of float64, shape (n,)
        A, light.
    uneven_share : float
        Share of the profiles that cross a patch.
    """
    shape = _shape(profile, offsets_px, crossings, even)
    outwards, inwards = (min(SHAPE_PX - 1.0, sigmas * blur_px) for sigmas in FLANK_SIGMAS)
    levels = crossings.place_px, crossings.dark, crossings.bright
    place, step, misfit = _fit(profile, *_grid(offsets_px), *levels, shape, outwards, inwards)
    found = np.isfinite(misfit)
    if found.any():
        place[misfit > max(MISFIT, MISFITS * float(np.median(misfit[found])))] = np.nan
    off = _unevenness(profile, offsets_px, place, crossings.dark, step, blur_px)
    found = np.isfinite(off)
    uneven_share = 0.0
    if found.any():
        quiet, enough = np.quantile(off[found], [QUIET, LEAST_EVEN])
        most = float(np.clip(NOISES * quiet, EVEN, UNEVEN))
        uneven_share = float(np.mean(off[found] > most))
        place[~(off <= max(most, enough))] = np.nan
    moved = (place - crossings.place_px)[even]
    return place - (np.median(moved[np.isfinite(moved)]) if np.isfinite(moved).any() else 0.0), step, uneven_share


def _shape(profile: Array, offsets_px: Array, crossings: Crossings, even: NDArray[np.intp]) -> Array:
    """Median light around the crossing, from 0 on the dark plateau to 1 at the bar's limb."""
    places = np.arange(-SHAPE_PX, SHAPE_PX + SHAPE_STEP_PX / 2, SHAPE_STEP_PX)
    around = _around(profile[even], *_grid(offsets_px), crossings.place_px[even], places)
    step = crossings.bright[even, None] - crossings.dark[even, None]
    return np.median((around - crossings.dark[even, None]) / step, axis=0)


def _unevenness(profile: Array, offsets_px: Array, place: Array, dark: Array, step: Array, blur_px: float) -> Array:
    """How far the light behind each edge is from that at the edge, over the step: more than noise at a patch.

    What all profiles share, as a bar's limb darkening, does not count.
    """
    reach = _reach(blur_px)
    spans = (reach, reach + PLATEAU_PX), (reach + PLATEAU_PX, reach + PLATEAU_PX + DEEPER_PX)
    behind, deeper = ((_levels(profile, *_grid(offsets_px), place, 1, *span) - dark) / step for span in spans)
    usual = np.nanmedian(behind) if np.isfinite(behind).any() else 1.0
    return np.maximum(np.abs(behind - usual), np.abs(deeper - behind))


def _reach(blur_px: float) -> float:
    return max(LEAST_REACH_PX, REACH_SIGMAS * blur_px)


def _grid(offsets_px: Array) -> tuple[float, float]:
    return float(offsets_px[0]), float(offsets_px[1] - offsets_px[0])


def _mean_root(span: tuple[float, float]) -> float:
    """Mean square root of the numbers between two."""
    return (span[1] ** 1.5 - span[0] ** 1.5) / (1.5 * (span[1] - span[0]))


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


# Compiled loops: one profile after the other, without a temporary array.


@njit(nogil=True, cache=True)
def _level(row, first, step, at, side, near, far):
    """Mean light between two distances from a place on one side of it."""
    low, high = (at + near, at + far) if side > 0 else (at - far, at - near)
    if np.isnan(low):
        return np.nan
    begin = max(0, int(np.ceil((low - first) / step - 1e-9)))
    end = min(row.shape[0] - 1, int(np.floor((high - first) / step + 1e-9)))
    if end < begin:
        return np.nan
    total = 0.0
    for j in range(begin, end + 1):
        total += row[j]
    return total / (end - begin + 1)


@njit(nogil=True, cache=True)
def _levels(profile, first, step, place, side, near, far):
    level = np.empty(profile.shape[0])
    for i in range(profile.shape[0]):
        level[i] = _level(profile[i], first, step, place[i], side, near, far)
    return level


@njit(nogil=True, cache=True)
def _rise(row, first, step, level, at):
    """Upward crossing of the level that is nearest to a place."""
    place, nearest = np.nan, np.inf
    for j in range(row.shape[0] - 1):
        if row[j] < level <= row[j + 1]:
            distance = abs(first + (j + 0.5) * step - at)
            if distance < nearest:
                nearest = distance
                place = first + (j + (level - row[j]) / (row[j + 1] - row[j])) * step
    return place


@njit(nogil=True, cache=True)
def _cross(profile, first, step, start, reach, shading):
    count = profile.shape[0]
    place, dark, bright = np.empty(count), np.empty(count), np.empty(count)
    for i in range(count):
        at = start[i]
        for _ in range(2):
            dark[i] = _level(profile[i], first, step, at, -1, reach, reach + PLATEAU_PX)
            bright[i] = _level(profile[i], first, step, at, 1, reach, reach + PLATEAU_PX)
            bright[i] -= shading * (bright[i] - dark[i])
            at = _rise(profile[i], first, step, 0.5 * (dark[i] + bright[i]), at) if bright[i] > dark[i] else np.nan
        place[i] = at
    return place, dark, bright


@njit(nogil=True, cache=True)
def _around(profile, first, step, place, offsets):
    """Light at offsets from each profile's place, linear between samples, the outermost sample beyond the ends."""
    light = np.full((profile.shape[0], offsets.shape[0]), np.nan)
    for i in range(profile.shape[0]):
        if np.isnan(place[i]):
            continue
        for j in range(offsets.shape[0]):
            at = min(max((place[i] + offsets[j] - first) / step, 0.0), profile.shape[1] - 1.0)
            k = min(int(at), profile.shape[1] - 2)
            light[i, j] = profile[i, k] + (at - k) * (profile[i, k + 1] - profile[i, k])
    return light


@njit(nogil=True, cache=True)
def _fit(profile, first, step, start, dark, bright, shape, outwards, inwards):
    count, samples, last = profile.shape[0], profile.shape[1], shape.shape[0] - 1
    place, height, misfits = np.full(count, np.nan), np.full(count, np.nan), np.full(count, np.nan)
    for i in range(count):
        at, a, misfit = start[i], bright[i] - dark[i], np.nan
        if np.isnan(at):
            continue
        for _ in range(FIT_ROUNDS):
            begin = max(0, int(np.ceil((at - outwards - first) / step)))
            end = min(samples - 1, int(np.floor((at + inwards - first) / step)))
            tt, ts, ss, tr, sr, rr = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for j in range(begin, end + 1):
                where = (first + j * step - at + SHAPE_PX) / SHAPE_STEP_PX
                k = min(max(int(where), 0), last - 1)
                slope = shape[k + 1] - shape[k]
                t = shape[k] + (where - k) * slope
                s = -a * slope / SHAPE_STEP_PX
                r = profile[i, j] - dark[i] - a * t
                tt += t * t
                ts += t * s
                ss += s * s
                tr += t * r
                sr += s * r
                rr += r * r
            determinant = tt * ss - ts * ts
            if not (determinant > 0.0 and a > 0.0):
                misfit = np.nan
                break
            misfit = np.sqrt(rr / (end - begin + 1)) / a
            shift = (tt * sr - ts * tr) / determinant
            at += min(max(shift, -0.5), 0.5)
            a += (ss * tr - ts * sr) / determinant
            if abs(shift) < 1e-4:
                break
            if not (abs(at - start[i]) < MOVED_PX):
                misfit = np.nan
                break
        if not np.isnan(misfit):
            place[i], height[i], misfits[i] = at, a, misfit
    return place, height, misfits
