"""Where a straight edge crosses its profiles, to a fraction of a pixel, halfway in light.

Profiles run from the dark side to the bright one. Each crossing is where light is halfway between the plateaus on
either side. The median profile is then the edge's own shape, blur and halo included; fitted to each profile over its
dark flank alone it locates the edge again without the light inside the bar, where patches of scale may lie.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import special

from vision.order_statistics import column_medians, median, median_without_nan, quantiles

Array = NDArray[np.float64]

PLATEAU_PX = 2.0  # chosen: width over which the light on either side of the edge is averaged
DEEPER_PLATEAU_PX = 3.0  # chosen: width of a second plateau behind the first; both tell how light changes with depth
CLEAR_RISE_SHARE = 0.15  # chosen: a rise of less than 15 % of the step from background to bar is a reflection
REACH_SIGMAS = 2.2  # plateaus begin there: a Gaussian blur leaves 1.4 % of the step beyond 2.2 standard deviations
LEAST_REACH_PX = 1.5  # chosen: bilinear interpolation alone blurs the edge over this distance
SHAPE_HALF_LENGTH_PX = 6.0  # chosen: half length of the median profile that is the edge's own shape
SHAPE_STEP_PX = 0.25
# Chosen: the shape is fitted from 3 blurs outside the edge to 1.2 inside, before patches begin.
FLANK_SIGMAS = 3.0, 1.2
FIT_ROUNDS = 6  # Gauss-Newton steps of a profile's fit
# Chosen: a fit whose root mean square residual exceeds 4 % of the step and 3 times the median one is another edge.
MISFIT_SHARE, MISFIT_FACTOR = 0.04, 3.0
# Chosen: light behind the edge that differs by more than this share of the step is a patch: 8 % on quiet profiles, at
# most 15 % on noisy ones. In between the limit is 4 times the lower quartile, which noise alone explains.
LEAST_UNEVENNESS, MOST_UNEVENNESS = 0.08, 0.15
QUIET_SHARE, NOISE_FACTOR = 0.25, 4.0
LEAST_KEPT_SHARE = 0.4  # chosen: of a limb's profiles the most even 40 % are kept however uneven they are
MOST_SHIFT_PX = 1.5  # chosen: a fit that ends further from its half-level crossing has found another edge
SHADED_BLUR_ROOT = 0.822  # mean of sqrt|x| of a standard normal variable, 2^(1/4) Gamma(3/4) / sqrt(pi)


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
        Offsets of the samples along a profile, evenly spaced, increasing.
    blur_px : float
        Standard deviation of the edge's blur.
    expected_px : float, optional
        Where the edge is, to within its blur; without it the search begins at the first clear rise of light.
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
    limb: L(d) = L0 + k sqrt(d). k follows from two plateaus at different depths, less the same difference on the dark
    side: the lens' halo is alike on both sides and moves no edge. At the limb itself the blur, of standard deviation
    sigma, turns L into half of L0 + 0.822 k sqrt(sigma), 0.822 being the mean of sqrt|x| of a standard normal x.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Offsets of the samples along a profile, evenly spaced, increasing.
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
    plateau, behind = (reach, reach + PLATEAU_PX), (reach + PLATEAU_PX, reach + PLATEAU_PX + DEEPER_PLATEAU_PX)
    deeper = _levels(profile, *_grid(offsets_px), crossings.place_px, 1, *behind)
    further = _levels(profile, *_grid(offsets_px), crossings.place_px, -1, *behind)
    root, deeper_root = _mean_root(plateau), _mean_root(behind)
    rise = (deeper - crossings.bright) - (crossings.dark - further)
    with np.errstate(divide="ignore", invalid="ignore"):
        k = rise / (crossings.bright - crossings.dark) / (deeper_root - root)
    found = k[np.isfinite(k)]
    return float(median(found) * (root - SHADED_BLUR_ROOT * np.sqrt(blur_px))) if found.size else 0.0


def edge_blur_px(profile: Array, offsets_px: Array, place_px: Array) -> float:
    """Standard deviation of the Gaussian blur whose edge is as steep at half level as the median profile.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Offsets of the samples along a profile, evenly spaced, increasing.
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
    level = column_medians(around)
    steepness = np.clip((level[2] - level[1]) / max(level[3] - level[0], 1e-9), 1e-3, 1 - 1e-6)
    return float(near / (np.sqrt(2) * special.erfinv(steepness)))


def even_profiles(profile: Array, offsets_px: Array, crossings: Crossings, blur_px: float) -> NDArray[np.intp]:
    """Numbers of the half of the profiles whose light is most even behind the edge: those cross no patch.

    Parameters
    ----------
    profile : ndarray of float64, shape (n, m)
        Light, from dark to bright.
    offsets_px : ndarray of float64, shape (m,)
        Offsets of the samples along a profile, evenly spaced, increasing.
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
        Offsets of the samples along a profile, evenly spaced, increasing.
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
    outwards, inwards = (min(SHAPE_HALF_LENGTH_PX - 1.0, sigmas * blur_px) for sigmas in FLANK_SIGMAS)
    levels = crossings.place_px, crossings.dark, crossings.bright
    place, step, misfit = _fit(profile, *_grid(offsets_px), *levels, shape, outwards, inwards)
    found = np.isfinite(misfit)
    if found.any():
        place[misfit > max(MISFIT_SHARE, MISFIT_FACTOR * median(misfit[found]))] = np.nan
    off = _unevenness(profile, offsets_px, place, crossings.dark, step, blur_px)
    found = np.isfinite(off)
    uneven_share = 0.0
    if found.any():
        quiet, enough = quantiles(off[found], (QUIET_SHARE, LEAST_KEPT_SHARE))
        most = float(np.clip(NOISE_FACTOR * quiet, LEAST_UNEVENNESS, MOST_UNEVENNESS))
        uneven_share = float(np.mean(off[found] > most))
        place[~(off <= max(most, enough))] = np.nan
    moved = (place - crossings.place_px)[even]
    return place - (median(moved[np.isfinite(moved)]) if np.isfinite(moved).any() else 0.0), step, uneven_share


def _shape(profile: Array, offsets_px: Array, crossings: Crossings, even: NDArray[np.intp]) -> Array:
    """Median light around the crossing, from 0 on the dark plateau to 1 at the bar's limb."""
    places = np.arange(-SHAPE_HALF_LENGTH_PX, SHAPE_HALF_LENGTH_PX + SHAPE_STEP_PX / 2, SHAPE_STEP_PX)
    around = _around(profile[even], *_grid(offsets_px), crossings.place_px[even], places)
    step = crossings.bright[even, None] - crossings.dark[even, None]
    return column_medians((around - crossings.dark[even, None]) / step)


def _unevenness(profile: Array, offsets_px: Array, place: Array, dark: Array, step: Array, blur_px: float) -> Array:
    """Difference of the light behind each edge from the usual light there, over the step; large at a patch of scale.

    The median over all profiles is the usual light, so that limb darkening, which all profiles share, is no patch.
    """
    reach = _reach(blur_px)
    spans = (reach, reach + PLATEAU_PX), (reach + PLATEAU_PX, reach + PLATEAU_PX + DEEPER_PLATEAU_PX)
    behind, deeper = ((_levels(profile, *_grid(offsets_px), place, 1, *span) - dark) / step for span in spans)
    usual = median_without_nan(behind) if np.isfinite(behind).any() else 1.0
    return np.maximum(np.abs(behind - usual), np.abs(deeper - behind))


def _reach(blur_px: float) -> float:
    return max(LEAST_REACH_PX, REACH_SIGMAS * blur_px)


def _grid(offsets_px: Array) -> tuple[float, float]:
    return float(offsets_px[0]), float(offsets_px[1] - offsets_px[0])


def _mean_root(span: tuple[float, float]) -> float:
    """Mean of sqrt(d) over the depths d of a span."""
    return (span[1] ** 1.5 - span[0] ** 1.5) / (1.5 * (span[1] - span[0]))


def _outermost(profile: Array, offsets_px: Array, reach: float) -> Array:
    """Offset of the first sample from the dark side that is clearly brighter than the background.

    A dark patch on the bar has edges of its own, often steeper ones; the bar's edge is the first. Samples too near an
    end of the profile for a plateau are left out.
    """
    inner = np.flatnonzero(np.abs(offsets_px) <= offsets_px[-1] - reach - 1)
    first = _first_rise(profile, inner[0], inner[-1] + 1)
    return np.where(first < 0, np.nan, offsets_px[first])


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
    """Upward crossing of the level that is nearest to a place, of two alike the first; searched from there outwards."""
    last = row.shape[0] - 2
    right = min(max(int(np.floor((at - first) / step)), 0), last + 1)
    left = right - 1
    while left >= 0 or right <= last:
        is_left = right > last or (
            left >= 0 and at - (first + (left + 0.5) * step) <= first + (right + 0.5) * step - at
        )
        j = left if is_left else right
        if row[j] < level <= row[j + 1]:
            return first + (j + (level - row[j]) / (row[j + 1] - row[j])) * step
        if is_left:
            left -= 1
        else:
            right += 1
    return np.nan


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
                where = (first + j * step - at + SHAPE_HALF_LENGTH_PX) / SHAPE_STEP_PX
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
            if not (abs(at - start[i]) < MOST_SHIFT_PX):
                misfit = np.nan
                break
        if not np.isnan(misfit):
            place[i], height[i], misfits[i] = at, a, misfit
    return place, height, misfits


@njit(nogil=True, cache=True)
def _first_rise(profile, begin, end):
    """First sample from `begin` on that is clearly above what lies before, or `begin`; -1 without a whole profile."""
    whole = np.array([row for row in range(profile.shape[0]) if np.isfinite(profile[row]).all()], dtype=np.int64)
    first = np.full(profile.shape[0], begin if whole.size else -1)
    if whole.size:
        dark, bright = np.median(profile[whole, :begin]), np.median(profile[whole, end:])
        level = dark + CLEAR_RISE_SHARE * (bright - dark)
        for row in range(profile.shape[0]):
            for sample in range(end - 1, begin - 1, -1):
                if profile[row, sample] > level:
                    first[row] = sample
    return first
