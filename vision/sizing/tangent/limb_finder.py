"""One limb (edge of the bar) in one view: sub-pixel edge points along it, on raw pixels.

A limb is a straight line in the undistorted view, and so on any plane; it is kept as x(y) on the grid's plane.
Profiles run across it from the dark side to the bar.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.compression import compression_shift_px
from vision.edges.profiles import sample_profiles
from vision.edges.shaded import shaded_crossings
from vision.edges.subpixel import even_profiles, fitted_edges, half_level_crossing
from vision.edges.symmetric_plane import settled
from vision.geometry.camera import Camera
from vision.geometry.consensus_line import consensus_line
from vision.geometry.measuring_plane import PLANE_HEIGHT_MM
from vision.light_planes import Decoder, LightPlane
from vision.order_statistics import median_without_nan, quantiles
from vision.sent_picture import Coding, SentPicture
from vision.sizing.limits import CLIPPED_FEW_SHARE, FIRST_BLUR_PX, LEAST_POINTS

Array = NDArray[np.float64]

ROUGH_SPACING_PX = 4.0  # chosen: distance of the first pass's profiles along the limb
SPACING_PX = 1.0  # distance of the second pass's profiles along the limb: each has its own pixels
PROFILE_STEP_PX = 0.25  # chosen: distance of the samples along a profile
SEARCH_HALF_LENGTH_PX = 12.0  # chosen: half length of the first profiles; the grid gives the limb to a few pixels
REFINE_HALF_LENGTH_PX = 9.0  # chosen: half length of the second profiles, around a straight line
INSIDE_PX = 8.0  # chosen: this far inwards of the rough limb a pixel surely lies on the bar
BRIGHTEST_SHARE = 0.9  # chosen: a channel clips if a tenth of the bar's pixels do
U_SHADING = 0.25  # chosen, relative: standard uncertainty of the shift that corrects for shading towards the limb
MOST_UNEVEN_SHARE = (
    0.5  # chosen: beyond it the median profile's fall of light is a patch's, and no shading is corrected
)
MOST_SHADING_PX = 0.1  # chosen: what a bar that is darker at its limb by a third could do
SETTLED_STEP = 4  # chosen: every fourth profile tells which guess of a clipped channel is right
AGREEMENT_PX = 1.0  # chosen: a point of the first pass supports the limb's line within one pixel

SEARCH_OFFSETS_PX = np.arange(-SEARCH_HALF_LENGTH_PX, SEARCH_HALF_LENGTH_PX + PROFILE_STEP_PX, PROFILE_STEP_PX)
REFINE_OFFSETS_PX = np.arange(-REFINE_HALF_LENGTH_PX, REFINE_HALF_LENGTH_PX + PROFILE_STEP_PX, PROFILE_STEP_PX)


@dataclass(frozen=True, slots=True, eq=False)
class LimbPoints:
    """Edge points along one limb, n of them, none clipped.

    Attributes
    ----------
    view : int
        0 left, 1 right camera.
    side : int
        -1 for the limb at smaller x, +1 for the other.
    point_px : ndarray of float64, shape (n, 2)
        (x, y) in the raw picture.
    place_mm : ndarray of float64, shape (n,)
        y of each on the limb's line on the grid's plane.
    dark, bright : ndarray of float64, shape (n,)
        Light on either side of the edge, 0 to 1.
    blur_px : float
        Standard deviation of the edge's blur; NaN without points.
    shading_px : float
        How far the edge was moved because the bar is darker at its limb.
    u_shading_px : float
        Standard uncertainty of it.
    uneven_share : float
        Share of the profiles that cross a patch on the bar.
    clipped_share : float
        Share of the points found that were overexposed and left out.
    tried : int
        Profiles that were sampled.
    is_guess : bool
        Whether a channel is overexposed in luma, and how much light it lost a guess.
    u_compression_px : float
        Standard uncertainty of the correction for lossy compression.
    """

    view: int
    side: int
    point_px: Array
    place_mm: Array
    dark: Array
    bright: Array
    blur_px: float
    shading_px: float
    uneven_share: float
    clipped_share: float
    tried: int
    u_shading_px: float = 0.0
    is_guess: bool = False
    u_compression_px: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class RoughLimb:
    """A limb to within a pixel.

    Attributes
    ----------
    line : ndarray of float64, shape (2,)
        x(y) on the grid's plane: slope and intercept, mm.
    seen : float
        Share of its profiles that agree with the line.
    """

    line: Array
    seen: float


class LimbFinder:
    """Locates limbs in the pictures of one camera.

    Parameters
    ----------
    view : int
        0 for the left camera, 1 for the right one.
    camera : Camera
    decoder : Decoder
        Of the camera's code values.
    region_y_mm : tuple of float
        Measuring region along the rolling direction.
    """

    def __init__(self, view: int, camera: Camera, decoder: Decoder, region_y_mm: tuple[float, float]) -> None:
        self._view = view
        self._camera = camera
        self._lens = tuple(np.ascontiguousarray(part) for part in (camera.R, camera.t, camera.K, camera.dist))
        self._decoder = decoder
        self._region_y_mm = region_y_mm

    def roughly(self, picture: SentPicture, line: Array, side: int) -> RoughLimb:
        """Straight line of a limb that the grid knows to a few pixels.

        Parameters
        ----------
        picture : SentPicture
        line : ndarray of float64, shape (2,)
            x(y) on the grid's plane: slope and intercept, mm.
        side : int
            -1 for the limb at smaller x, +1 for the other.

        Returns
        -------
        RoughLimb
            `seen` is 0, and the line the given one, where there are fewer than `LEAST_POINTS`.
        """
        point, normal, y_mm = self._across(line, side, self._region_y_mm, ROUGH_SPACING_PX)
        (outside,), (inside,) = (_shown_levels(picture, point + way * INSIDE_PX * normal, (0.5,)) for way in (-1, 1))
        plane = self._decoder.planes(picture.coding, outside, inside)[0]
        profile = sample_profiles(picture.measured, plane, point, normal, SEARCH_OFFSETS_PX)
        place = half_level_crossing(profile, SEARCH_OFFSETS_PX, FIRST_BLUR_PX).place_px
        found = np.isfinite(place)
        if np.count_nonzero(found) < LEAST_POINTS:
            return RoughLimb(line, 0.0)
        x_mm, on_line_mm = self._on_plane(point[found] + place[found, None] * normal[found]).T[:2]
        pixel_mm = (
            float(np.linalg.norm(self._camera.centre_mm - [line[1], 0.0, PLANE_HEIGHT_MM])) / self._camera.K[0, 0]
        )
        fitted, agrees = consensus_line(on_line_mm, x_mm, AGREEMENT_PX * pixel_mm)
        return RoughLimb(fitted, np.count_nonzero(agrees) / len(y_mm))

    def finely(self, picture: SentPicture, line: Array, side: int, span_mm: tuple[float, float]) -> LimbPoints:
        """Edge points along a limb that is known to within a pixel.

        Parameters
        ----------
        picture : SentPicture
        line : ndarray of float64, shape (2,)
            x(y) on the grid's plane: slope and intercept, mm.
        side : int
            -1 for the limb at smaller x, +1 for the other.
        span_mm : tuple of float
            From where to where along the line.

        Returns
        -------
        LimbPoints
            From the brightest colour channel that is not overexposed along the limb, else from the one that is
            least overexposed.
        """
        point, normal, y_mm = self._across(line, side, span_mm, SPACING_PX)
        tried: list[LimbPoints] = []
        (outside,) = _shown_levels(picture, point - INSIDE_PX * normal, (0.5,))
        inside, brightest = _shown_levels(picture, point + INSIDE_PX * normal, (0.5, BRIGHTEST_SHARE))
        few = slice(None, None, SETTLED_STEP)
        for plane in settled(
            self._decoder.planes(picture.coding, outside, inside, brightest),
            lambda plane: sample_profiles(picture.measured, plane, point[few], normal[few], REFINE_OFFSETS_PX),
            REFINE_OFFSETS_PX,
        ):
            profile = sample_profiles(picture.measured, plane, point, normal, REFINE_OFFSETS_PX)
            tried.append(self._points(profile, (point, normal, y_mm), side, (plane, picture.coding)))
            if tried[-1].clipped_share <= CLIPPED_FEW_SHARE:
                break
        return min(tried, key=lambda limb: limb.clipped_share)

    def _points(
        self, profile: Array, across: tuple[Array, Array, Array], side: int, light: tuple[LightPlane, Coding]
    ) -> LimbPoints:
        (point, normal, y_mm), (plane, coding) = across, light
        shaded = shaded_crossings(profile, REFINE_OFFSETS_PX, FIRST_BLUR_PX)
        if shaded is None:
            return self._nothing(side, len(y_mm))
        crossings, blur_px = shaded.crossings, shaded.blur_px
        even = even_profiles(profile, REFINE_OFFSETS_PX, crossings, blur_px)
        if not even.size:
            return self._nothing(side, len(y_mm))
        place, step, uneven_share = fitted_edges(profile, REFINE_OFFSETS_PX, crossings, even, blur_px)
        bright = crossings.dark + step
        inwards_px, u_inwards_px = compression_shift_px(coding, plane, (crossings.dark, bright), blur_px)
        place = place - inwards_px
        shading_px = median_without_nan(crossings.place_px - shaded.unshaded_px)
        u_shading_px = U_SHADING * abs(shading_px)
        if uneven_share > MOST_UNEVEN_SHARE:  # most profiles cross patches, which are no shading
            place, u_shading_px, shading_px = place - shading_px, abs(shading_px) / np.sqrt(3), 0.0
        found = np.isfinite(place)
        clipped = np.maximum(bright, crossings.bright) >= plane.clipped_light
        kept = found & ~clipped
        share = np.count_nonzero(found & clipped) / max(1, np.count_nonzero(found))
        if np.count_nonzero(kept) < LEAST_POINTS:
            return self._nothing(side, len(y_mm), share)
        return LimbPoints(
            view=self._view,
            side=side,
            point_px=(point + place[:, None] * normal)[kept],
            place_mm=y_mm[kept],
            dark=crossings.dark[kept],
            bright=bright[kept],
            blur_px=blur_px,
            shading_px=shading_px,
            u_shading_px=min(u_shading_px, MOST_SHADING_PX),
            uneven_share=uneven_share,
            clipped_share=share,
            tried=len(y_mm),
            is_guess=plane.is_guess,
            u_compression_px=u_inwards_px,
        )

    def _nothing(self, side: int, tried: int, clipped_share: float = 0.0) -> LimbPoints:
        none = np.empty(0)
        return LimbPoints(self._view, side, np.empty((0, 2)), none, none, none, np.nan, 0.0, 0.0, clipped_share, tried)

    def _across(
        self, line: Array, side: int, span_mm: tuple[float, float], spacing_px: float
    ) -> tuple[Array, Array, Array]:
        """Points along a line on the plane, the unit vectors from there into the bar, and their y."""
        ends, _ = _across_limb(self._lens, line, side, np.array(span_mm))
        length_px = float(np.linalg.norm(ends[1] - ends[0]))
        count = max(2, int(length_px / spacing_px)) if np.isfinite(length_px) else 2
        y_mm = np.linspace(*span_mm, count)
        return *_across_limb(self._lens, line, side, y_mm), y_mm

    def _on_plane(self, point_px: Array) -> Array:
        centre, direction = self._camera.centre_mm, self._camera.rays(point_px)
        reach = (PLANE_HEIGHT_MM - centre[2]) / direction[:, 2]
        return centre + reach[:, None] * direction


def _shown_levels(picture: SentPicture, point: Array, shares: tuple[float, ...]) -> list[Array]:
    """Quantiles of each channel's code values as shown at some points, each of shape (channels,)."""
    at = np.rint(point[::8])
    shown = picture.shown.reshape(*picture.shown.shape[:2], -1)
    x, y = at[np.all((at >= 0) & (at < picture.size), axis=1)].astype(int).T
    return quantiles(shown[y, x], shares) if x.size else [np.zeros(shown.shape[2]) for _ in shares]


@njit(nogil=True, cache=True)
def _across_limb(lens, line, side, y_mm):  # type: ignore[no-untyped-def]
    """Pixels of points on a limb's line, and the unit vectors from there into the bar, at a right angle to the limb."""
    point, normal = np.empty((y_mm.shape[0], 2)), np.empty((y_mm.shape[0], 2))
    for i in range(y_mm.shape[0]):
        y = y_mm[i]
        x = line[0] * y + line[1]
        here_x, here_y = _pixel(lens, x, y)
        ahead_x, ahead_y = _pixel(lens, line[0] * (y + 1.0) + line[1], y + 1.0)
        inward_x, inward_y = _pixel(lens, x - side, y)
        along_x, along_y = _unit(ahead_x - here_x, ahead_y - here_y)
        into_x, into_y = inward_x - here_x, inward_y - here_y
        along = into_x * along_x + into_y * along_y
        point[i, 0], point[i, 1] = here_x, here_y
        normal[i, 0], normal[i, 1] = _unit(into_x - along * along_x, into_y - along * along_y)
    return point, normal


@njit(nogil=True, cache=True, error_model="numpy")
def _unit(x, y):  # type: ignore[no-untyped-def]
    length = np.sqrt(x * x + y * y)
    return x / length, y / length


@njit(nogil=True, cache=True)
def _pixel(lens, x_mm, y_mm):  # type: ignore[no-untyped-def]
    """Where a point of the grid's plane appears, `Camera.project` for one point; NaN behind the camera."""
    R, t, K, dist = lens
    depth = R[2, 0] * x_mm + R[2, 1] * y_mm + R[2, 2] * PLANE_HEIGHT_MM + t[2]
    if not depth > 0.0:
        return np.nan, np.nan
    x = (R[0, 0] * x_mm + R[0, 1] * y_mm + R[0, 2] * PLANE_HEIGHT_MM + t[0]) / depth
    y = (R[1, 0] * x_mm + R[1, 1] * y_mm + R[1, 2] * PLANE_HEIGHT_MM + t[1]) / depth
    k1, k2, p1, p2, k3 = dist
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    shown_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    shown_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return shown_x * K[0, 0] + K[0, 2], shown_y * K[1, 1] + K[1, 2]
