"""What makes a bar more than a smooth endless cylinder: patches of scale, uneven cooling, and its ends.

The silhouette knows the bar's limbs exactly. Here rays inside it are followed to the surface, and the parts that are
missing, darker or cooler are blurred like the whole: the quotient of the two blurs leaves the limbs where they are.
"""

import functools
import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.bars.background import blurred
from appliance.simulation.bars.bars import Bar, Oxide, levels
from appliance.simulation.bars.silhouette import (
    COARSE_PX,
    REACH_IN_HALOS,
    Silhouette,
    axis_distance,
    axis_near,
    rounded,
    station_mm,
)
from appliance.simulation.sensor import Blur, Light

SUBSAMPLES = 2
FACE_COOLER_C = 40.0
APERTURE_VARIANCE_PX2 = 1 / 12  # of the square pixel that the subsamples fill
CELL_MM = 1.0  # of the surface
PERIOD = 1600  # cells, after which scale repeats along the bar
COOLING_MM = 120.0
LEAST_WEIGHT = 1e-6

Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Hits:
    """Where rays meet a bar, arrays of one shape.

    Attributes
    ----------
    inside : ndarray of bool
        The ray meets the bar or would if the bar were endless.
    seen : ndarray of bool
        The ray meets the bar, on its side or on an end face.
    face : ndarray of bool
        The ray meets an end face.
    place : ndarray of float64
        Angle in the section, from across towards z, rad, of the point on the side.
    station_mm : ndarray of float64
        Its distance along the axis from y = 0.
    """

    inside: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    face: NDArray[np.bool_]
    place: Values
    station_mm: Values


def hits(centre_mm: Values, rays: NDArray[np.floating], bar: Bar) -> Hits:
    """Follow unit rays (..., 3) from a camera to the bar."""
    centre_mm, rays = rounded(centre_mm, rays.astype(np.float32), bar)
    point, direction = axis_near(centre_mm, rays, bar)
    from_axis = centre_mm - point
    cosine = np.einsum("...i,...i", rays, direction)
    nearest = station_mm(from_axis, rays, direction)
    free = (bar.diameter_mm / 2) ** 2 - axis_distance(centre_mm, rays, bar).astype(np.float64) ** 2
    half_chord = np.sqrt(np.maximum(free, 0)) / np.sqrt(1 - cosine**2)
    depth = nearest * cosine - np.einsum("...i,...i", rays, from_axis) - half_chord
    side = from_axis + depth[..., None] * rays
    offset = (point - bar.axis_point_mm) @ bar.axis_direction
    first, last = (offset + nearest + sign * half_chord * cosine for sign in (-1, 1))
    on_side = (first >= bar.tail_mm) & (first <= bar.head_mm)
    touches = (np.maximum(first, last) >= bar.tail_mm) & (np.minimum(first, last) <= bar.head_mm)
    across = np.cross(direction, [0.0, 0.0, 1.0])
    place = np.arctan2(side[..., 2], np.einsum("...i,...i", side, across))
    inside = free > 0
    return Hits(inside, inside & touches, inside & touches & ~on_side, place, first)


def cooler_c(oxide: Oxide, circumference_mm: float, place: Values, station_mm: Values) -> Values:
    """How much cooler than the bar its surface looks at points of the side, of any one shape."""
    around = round(circumference_mm / CELL_MM)
    field = _cooler_field(oxide, around)
    columns = np.floor(place * (around / (2 * np.pi))).astype(np.int64) % around
    rows = np.floor(station_mm / CELL_MM).astype(np.int64) % PERIOD
    return field[rows, columns]


@functools.lru_cache(maxsize=2)
def _cooler_field(oxide: Oxide, around: int) -> Values:
    """How much cooler the surface looks, one value per cell along and around the bar."""
    rng = np.random.default_rng([oxide.seed, 0x6F78])
    patches = _smooth_noise(rng, around, 0.3 * oxide.patch_mm)
    cooling = _smooth_noise(rng, around, COOLING_MM)
    return oxide.cooler_c * (patches > np.quantile(patches, 1 - oxide.part)) + oxide.unevenness_c * cooling


def with_details(seen: Silhouette, centre_mm: Values, rays: Light, bar: Bar, blur: Blur) -> Silhouette:
    """Silhouette of an endless bar without scale, with the ends and the scale that the bar has.

    Parameters
    ----------
    seen : Silhouette
    centre_mm : ndarray of float64, shape (3,)
        Projection centre of the camera, world frame.
    rays : ndarray of float32, shape (rows, columns, 3)
        Unit direction of each pixel's light in the whole picture.
    bar : Bar
    blur : Blur
    """
    shape = rays.shape[:2]
    if bar.oxide is not None:
        part = seen.rows, seen.columns
        factors = np.zeros((4, *shape), np.float32)
    elif bar.is_endless:
        return seen
    else:
        coarse = hits(centre_mm, rays[::COARSE_PX, ::COARSE_PX], bar)
        part = _around_ends(coarse, blur)
        on_bar = (coarse.station_mm >= bar.tail_mm) & (coarse.station_mm <= bar.head_mm)
        factors = np.broadcast_to(_full_size(on_bar, shape).astype(np.float32), (4, *shape)).copy()
    if part is not None:
        factors[:, *part] = _factors(centre_mm, rays[part], bar, blur)
    factors = factors[:, seen.rows, seen.columns]
    return Silhouette(seen.rows, seen.columns, seen.coverage * factors[0], seen.glow * factors[1:])


def _factors(centre_mm: Values, rays: Light, bar: Bar, blur: Blur) -> Light:
    """What is left of coverage, blue, green and red in a part of a picture, shape (4, rows, columns)."""
    subsamples = _subsampled(rays)
    inside = np.abs(axis_distance(*rounded(centre_mm, subsamples, bar), bar)) < bar.diameter_mm / 2
    found = hits(centre_mm, subsamples[inside], bar)
    shares = np.zeros((4, *inside.shape), np.float32)
    shares[0, inside] = found.seen
    shares[1:, inside] = (found.seen[:, None] * _brightness(found, bar)).T
    core_px = float(np.sqrt(blur.core_px**2 - APERTURE_VARIANCE_PX2))
    blur = Blur(core_px, blur.halo_px, blur.halo_part)
    whole = blurred(_pixels(inside.astype(np.float32)), blur)
    parts = np.stack([blurred(_pixels(shares[plane]), blur) for plane in range(len(shares))])
    return parts * np.divide(1, whole, where=whole > LEAST_WEIGHT, out=np.zeros_like(whole))


def _around_ends(coarse: Hits, blur: Blur) -> tuple[slice, slice] | None:
    """The part of a picture in which a bar's end shows, from hits of every `COARSE_PX`-th ray."""
    reach = math.ceil(REACH_IN_HALOS * blur.halo_px / COARSE_PX) + 1
    kernel = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    side = coarse.seen & ~coarse.face
    near_side, near_else = (cv2.dilate(cells.astype(np.uint8), kernel) for cells in (side, coarse.inside & ~side))
    rows, columns = np.nonzero(cv2.bitwise_and(near_side, near_else))
    if len(rows) == 0:
        return None
    low, high = np.array([rows.min(), columns.min()]), np.array([rows.max(), columns.max()]) + 1
    return slice(low[0] * COARSE_PX, high[0] * COARSE_PX), slice(low[1] * COARSE_PX, high[1] * COARSE_PX)


def _full_size(coarse: NDArray[np.bool_], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    return coarse.repeat(COARSE_PX, axis=0).repeat(COARSE_PX, axis=1)[: shape[0], : shape[1]]


def _brightness(found: Hits, bar: Bar) -> Values:
    """Light of each hit over that of the bar's middle, blue, green, red, shape (..., 3)."""
    cooler = np.zeros(found.place.shape)
    if bar.oxide is not None:
        cooler = cooler_c(bar.oxide, np.pi * bar.diameter_mm, found.place, found.station_mm - bar.travel_mm)
    cooler[found.face] = FACE_COOLER_C
    return levels(bar.temperature_c - cooler) / bar.levels


def _smooth_noise(rng: np.random.Generator, around: int, sigma_mm: float) -> Values:
    """Noise of mean 0 and standard deviation 1, shape (`PERIOD`, around), that repeats seamlessly."""
    along_cycles, around_cycles = np.fft.fftfreq(PERIOD, CELL_MM), np.fft.rfftfreq(around, CELL_MM)
    transfer = np.exp(-2 * (np.pi * sigma_mm) ** 2 * (along_cycles[:, None] ** 2 + around_cycles**2))
    transfer[0, 0] = 0
    smooth = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((PERIOD, around))) * transfer, (PERIOD, around))
    return smooth / smooth.std()


def _subsampled(rays: Light) -> Light:
    rows, columns = rays.shape[:2]
    size = (SUBSAMPLES * columns, SUBSAMPLES * rows)
    return cv2.resize(rays, size, interpolation=cv2.INTER_LINEAR).astype(np.float32, copy=False)


def _pixels(subsamples: Light) -> Light:
    """Mean of each pixel's subsamples."""
    size = subsamples.shape[1] // SUBSAMPLES, subsamples.shape[0] // SUBSAMPLES
    return cv2.resize(subsamples, size, interpolation=cv2.INTER_AREA).astype(np.float32, copy=False)
