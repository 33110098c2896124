"""One limb of the bar in one view: sub-pixel edge points along it, on raw pixels.

A limb is a straight line in the undistorted view, and so on any plane; its first guess and its second are kept as
x(y) on the grid's plane. Profiles run across it from the dark side to the bar.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Camera
from vision.edges.subpixel import edge_blur_px, edge_shading, half_level_crossing, sample_profiles
from vision.sizing.region import PLANE_HEIGHT_MM

Array = NDArray[np.float64]

LINE_ROUNDS = 6
SPACING_PX = 1.0  # along the limb: each point then has its own pixels
STEP_PX = 0.25  # along a profile
SEARCH_PX = 12.0  # half length of the first profiles: the grid knows the limb to a few pixels
INSIDE_PX = 8.0  # from the rough limb: surely on the bar
FIRST_BLUR_PX = 1.5  # taken for the wide pass; the narrow one uses what that one found
REFINE_PX = 9.0  # half length of the second ones, around a straight line
CLIPPED_CODE = 250  # from here a channel may have lost light
LEAST_POINTS = 30  # fewer are no limb
CLIPPED_FEW = 0.05  # share of a limb's points: below it a channel is as good as unclipped


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
    y_mm : ndarray of float64, shape (n,)
        Where along the line each lies, as seen on the grid's plane.
    dark, bright : ndarray of float64, shape (n,)
        Light on either side of the edge, 0 to 1.
    blur_px : float
        Standard deviation of the edge's blur; NaN without points.
    clipped_share : float
        Share of the points found that were overexposed and left out.
    tried : int
        Profiles that were sampled.
    """

    view: int
    side: int
    point_px: Array
    y_mm: Array
    dark: Array
    bright: Array
    blur_px: float
    clipped_share: float
    tried: int


def straight(y: Array, x: Array) -> Array:
    """Robust line x(y): slope and intercept, shape (2,).

    Biweight from the median slope between the outer thirds, so a third of outliers does not move it.
    """
    third = max(1, len(y) // 3)
    order = np.argsort(y)
    low, high = order[:third], order[-third:]
    slope = (np.median(x[high]) - np.median(x[low])) / (np.median(y[high]) - np.median(y[low]))
    line = np.array([slope, np.median(x - slope * y)])
    for _ in range(LINE_ROUNDS):
        residual = x - _at(line, y)
        ratio = residual / (4.685 * max(1.4826 * float(np.median(np.abs(residual))), 1e-9))
        weight = np.where(np.abs(ratio) < 1, (1 - ratio**2) ** 2, 0.0)
        middle_y, middle_x = weight @ y / weight.sum(), weight @ x / weight.sum()
        off_y = weight * (y - middle_y)
        slope = off_y @ (x - middle_x) / (off_y @ (y - middle_y))
        line = np.array([slope, middle_x - slope * middle_y])
    return line


class LimbFinder:
    """Locates limbs in the pictures of one camera.

    Parameters
    ----------
    view : int
        0 for the left camera, 1 for the right one.
    camera : Camera
    decode : ndarray of float32, shape (256,)
        Light of every code value.
    region_y_mm : tuple of float
        Measuring region along the rolling direction.
    """

    def __init__(
        self, view: int, camera: Camera, decode: NDArray[np.float32], region_y_mm: tuple[float, float]
    ) -> None:
        self._view = view
        self._camera = camera
        self._decode = decode
        self._region_y_mm = region_y_mm

    def locate(self, image: NDArray[np.uint8], line: Array, side: int) -> LimbPoints:
        """Edge points along a limb that is roughly known.

        Parameters
        ----------
        image : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
            Raw picture.
        line : ndarray of float64, shape (2,)
            x(y) on the grid's plane: slope and intercept, mm.
        side : int
            -1 for the limb at smaller x, +1 for the other.

        Returns
        -------
        LimbPoints
            From the brightest colour channel that is not overexposed along the limb, else from the one that is
            least overexposed.
        """
        planes = image[:, :, None] if image.ndim == 2 else image
        tried: list[LimbPoints] = []
        for index in np.argsort(-self._brightness(planes, line, side)):
            tried.append(self._two_passes(planes[:, :, index], line, side))
            if tried[-1].clipped_share <= CLIPPED_FEW:
                break
        return min(tried, key=lambda limb: limb.clipped_share)

    def _brightness(self, planes: NDArray[np.uint8], line: Array, side: int) -> Array:
        """Median code value of each channel just inside the limb, shape (channels,)."""
        point, normal, _ = self._across(line, side, 8.0)
        inside = np.rint(point + INSIDE_PX * normal)
        rows, columns = planes.shape[:2]
        seen = np.all((inside >= 0) & (inside < [columns, rows]), axis=1)
        x, y = inside[seen].astype(int).T
        return np.median(planes[y, x], axis=0) if seen.any() else np.zeros(planes.shape[2])

    def _two_passes(self, channel: NDArray[np.uint8], line: Array, side: int) -> LimbPoints:
        """A wide pass around the rough line, then a narrow one around the straight line through its points."""
        point, normal, y_mm = self._across(line, side, 2.0)
        offsets = np.arange(-SEARCH_PX, SEARCH_PX + STEP_PX, STEP_PX)
        profile = self._profiles(channel, point, normal, offsets)
        place = half_level_crossing(profile, offsets, FIRST_BLUR_PX).place_px
        found = np.isfinite(place)
        if np.count_nonzero(found) < LEAST_POINTS:
            return self._nothing(side, len(y_mm))
        x_mm = self._on_plane(point[found] + place[found, None] * normal[found])
        blur_px = edge_blur_px(profile[found][::4], offsets, place[found][::4])
        return self._narrow(channel, straight(x_mm[:, 1], x_mm[:, 0]), side, blur_px)

    def _narrow(self, channel: NDArray[np.uint8], line: Array, side: int, blur_px: float) -> LimbPoints:
        point, normal, y_mm = self._across(line, side, SPACING_PX)
        offsets = np.arange(-REFINE_PX, REFINE_PX + STEP_PX, STEP_PX)
        profile = self._profiles(channel, point, normal, offsets)
        even = half_level_crossing(profile, offsets, blur_px, expected_px=0.0)
        shading = edge_shading(profile, offsets, even, blur_px)
        edge = half_level_crossing(profile, offsets, blur_px, expected_px=0.0, shading=shading)
        found = np.isfinite(edge.place_px)
        clipped = edge.bright >= self._decode[CLIPPED_CODE]
        kept = found & ~clipped
        share = np.count_nonzero(found & clipped) / max(1, np.count_nonzero(found))
        if np.count_nonzero(kept) < LEAST_POINTS:
            return self._nothing(side, len(y_mm), share)
        return LimbPoints(
            view=self._view,
            side=side,
            point_px=(point + edge.place_px[:, None] * normal)[kept],
            y_mm=y_mm[kept],
            dark=edge.dark[kept],
            bright=edge.bright[kept],
            blur_px=blur_px,
            clipped_share=share,
            tried=len(y_mm),
        )

    def _nothing(self, side: int, tried: int, clipped_share: float = 0.0) -> LimbPoints:
        none = np.empty(0)
        return LimbPoints(self._view, side, np.empty((0, 2)), none, none, none, np.nan, clipped_share, tried)

    def _across(self, line: Array, side: int, spacing_px: float) -> tuple[Array, Array, Array]:
        """Points along a line on the plane, the unit vectors from there into the bar, and their y."""
        ends_y_mm = np.array(self._region_y_mm)
        ends = self._project(_at(line, ends_y_mm), ends_y_mm)
        length_px = float(np.linalg.norm(ends[1] - ends[0]))
        count = max(2, int(length_px / spacing_px)) if np.isfinite(length_px) else 2
        y_mm = np.linspace(*self._region_y_mm, count)
        x_mm = _at(line, y_mm)
        point = self._project(x_mm, y_mm)
        along = _unit(self._project(_at(line, y_mm + 1.0), y_mm + 1.0) - point)
        inward = self._project(x_mm - side, y_mm) - point
        return point, _unit(inward - np.sum(inward * along, axis=1, keepdims=True) * along), y_mm

    def _project(self, x_mm: Array, y_mm: Array) -> Array:
        return self._camera.project(np.column_stack([x_mm, y_mm, np.full(len(y_mm), PLANE_HEIGHT_MM)]))

    def _on_plane(self, point_px: Array) -> Array:
        centre, direction = self._camera.centre_mm, self._camera.rays(point_px)
        reach = (PLANE_HEIGHT_MM - centre[2]) / direction[:, 2]
        return centre + reach[:, None] * direction

    def _profiles(self, channel: NDArray[np.uint8], point: Array, normal: Array, offsets: Array) -> Array:
        """Light along profiles; only the part of the picture that they touch is decoded."""
        ends = np.concatenate([point + offset * normal for offset in (offsets[0], offsets[-1])])
        ends = ends[np.isfinite(ends).all(axis=1)]
        rows, columns = channel.shape
        if not len(ends):
            return np.full((len(point), len(offsets)), np.nan)
        x0, y0 = np.clip(np.floor(ends.min(axis=0)).astype(int) - 1, 0, [columns - 1, rows - 1])
        x1, y1 = np.clip(np.ceil(ends.max(axis=0)).astype(int) + 2, [x0 + 1, y0 + 1], [columns, rows])
        light = self._decode[channel[y0:y1, x0:x1]]
        return sample_profiles(light, point - [x0, y0], normal, offsets)


def _at(line: Array, y_mm: Array) -> Array:
    return line[0] * y_mm + line[1]


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector, axis=1, keepdims=True)
