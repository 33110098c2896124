"""The measuring region seen from above, and the rough outline of the hot bar in it.

Each view is sampled on a grid on a horizontal plane: rows run across the line, columns along it, so that a bar
stands nearly upright in it however obliquely it crosses the picture. A limb is then a long, nearly upright step of
light: every row votes for the lines that run through its steps, so that oxide, rollers, glare or a post, which cover
only a part of the bar, are outvoted. The grid gives the limbs (edges of the bar) to within a few pixels; edges are
located on raw pixels afterwards.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.geometry.camera import Camera
from vision.geometry.measuring_plane import PLANE_HEIGHT_MM, farthest_ideal_radius, pixel_size_mm
from vision.pictures import brightest_channel

Array = NDArray[np.float64]
Plane = NDArray[np.float32]

ROW_STEP_MM = 10.0  # chosen: distance of the grid's rows along the line
COLUMN_STEP_PX = 2.0  # chosen: distance of the grid's columns, in pixels at the measuring plane
REACH_ACROSS_MM = 1500.0  # chosen: the grid reaches this far to either side across the line
LEAST_SEEN_SHARE = 0.6  # chosen: a column belongs to the grid if the picture shows 60 % of its rows
SLOPES = np.linspace(-0.06, 0.06, 25)  # dx/dy of a limb: bars lie along the line to within 3.4 degrees
WIDTH_RANGE_MM = (40.0, 700.0)  # chosen: width of a bar on the plane; narrower bright stripes are sparks, reflections
MOST_SLOPE_DIFFERENCE = 0.06  # chosen: between the two limbs of one bar, whose slopes a short bar leaves vague
FLOOR_LIGHT = 0.06  # chosen: pixels with less than 6 % of full-scale light are not hot
LEAST_CONTRAST = 2.0  # chosen: the median hot pixel has at least twice the light of the median other one
FULL_STEP_SHARE = 0.4  # chosen: a step of 40 % of the bar's light is a row's full vote; larger steps add nothing
LEAST_VOTE = 0.3  # chosen: a line with 30 % of the full vote is a limb
LEAST_HOT_SHARE = 0.3  # chosen: between two limbs of one bar at least 30 % is hot: half a bar, seen obliquely
LEAST_DISTANCE_MM = 15.0  # chosen: two limbs on the same side of bars are further apart


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Rough outline of a bar: its limbs as lines x(y) on the measuring plane.

    Attributes
    ----------
    left, right : ndarray of float64, shape (2,)
        Slope dx/dy and x at y = 0, mm, of the limbs at smaller and at larger x.
    """

    left: Array
    right: Array


@dataclass(frozen=True, slots=True)
class _Line:
    slope_index: int
    column: int
    vote: float


class RegionGrid:
    """Grid over the measuring region of one view.

    Parameters
    ----------
    camera : Camera
    region_y_mm : tuple of float
        Measuring region along the rolling direction.

    Raises
    ------
    ValueError
        The camera does not see the region.
    """

    def __init__(self, camera: Camera, region_y_mm: tuple[float, float]) -> None:
        rows = max(2, round((region_y_mm[1] - region_y_mm[0]) / ROW_STEP_MM) + 1)
        self.y_mm = np.linspace(*region_y_mm, rows)
        self.column_step_mm = COLUMN_STEP_PX * pixel_size_mm(camera)
        x_mm = np.arange(-REACH_ACROSS_MM, REACH_ACROSS_MM, self.column_step_mm)
        pixel = _project_plane(camera, x_mm, self.y_mm)
        width, height = camera.image_size
        inside = np.all((pixel >= 0) & (pixel <= [width - 1, height - 1]), axis=2)
        seen = np.flatnonzero(inside.mean(axis=0) > LEAST_SEEN_SHARE)
        if seen.size < 2:
            raise ValueError("the camera does not see the measuring region: is it the right rig?")
        columns = slice(seen[0], seen[-1] + 1)
        self.x_mm = x_mm[columns]
        self._pixel = np.nan_to_num(pixel[:, columns], nan=-1.0).astype(np.float32)

    def sample(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Brightest channel of the picture on the grid, code values, shape (rows, columns); 0 outside the picture."""
        grid = cv2.remap(image, self._pixel[..., 0], self._pixel[..., 1], cv2.INTER_LINEAR)
        return brightest_channel(np.asarray(grid, dtype=np.uint8))

    def bars(self, image: NDArray[np.uint8], decode: NDArray[np.float32]) -> list[Outline]:
        """Hot bars that lie across the region, left to right.

        Parameters
        ----------
        image : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        decode : ndarray of float32, shape (256,)
            Light of every code value.

        Returns
        -------
        list of Outline
            They do not overlap; empty when nothing hot has two limbs.
        """
        grid = np.asarray(cv2.blur(self.sample(image), (3, 1)), dtype=np.uint8)
        hot = _hot(grid, decode)
        if hot is None:
            return []
        light = decode[grid]
        step = np.zeros_like(light)
        step[:, 1:-1] = (light[:, 2:] - light[:, :-2]) / _median_light(grid[hot > 0], decode)
        lefts = self._lines(np.clip(step, 0.0, FULL_STEP_SHARE))
        rights = self._lines(np.clip(-step, 0.0, FULL_STEP_SHARE))
        return self._pairs(lefts, rights, hot.astype(np.float32))

    def _along_slopes(self, values: Plane, slopes: Array = SLOPES) -> Array:
        """Mean of values along lines x = column + slope * y, shape (slopes, columns)."""
        return _sheared_means(values, slopes * ROW_STEP_MM / self.column_step_mm, -self.y_mm[0] / ROW_STEP_MM)

    def _lines(self, step: Plane) -> list[_Line]:
        """Lines that enough rows vote for, each the best within `LEAST_DISTANCE_MM`."""
        votes = self._along_slopes(step) / FULL_STEP_SHARE
        best = votes.max(axis=0)
        apart = 2 * round(LEAST_DISTANCE_MM / self.column_step_mm) + 1
        peak = cv2.dilate(best[None, :], np.ones((1, apart), np.uint8))[0]
        columns = np.flatnonzero((best >= peak) & (best >= LEAST_VOTE))
        return [_Line(int(votes[:, column].argmax()), int(column), float(best[column])) for column in columns]

    def _pairs(self, lefts: list[_Line], rights: list[_Line], hot: Plane) -> list[Outline]:
        """Bars: pairs of limbs with something hot between them, the best first wherever they overlap."""
        pairs = [(left, right) for left in lefts for right in rights if self._may_be_one_bar(left, right)]
        ranked = sorted(
            (
                (share + left.vote + right.vote, left, right)
                for (left, right), share in zip(pairs, self._hot_shares(pairs, hot), strict=True)
                if share >= LEAST_HOT_SHARE
            ),
            key=lambda one: -one[0],
        )
        chosen: list[tuple[_Line, _Line]] = []
        for _, left, right in ranked:
            if all(right.column <= other.column or left.column >= end.column for other, end in chosen):
                chosen.append((left, right))
        chosen.sort(key=lambda pair: pair[0].column)
        return [Outline(self._line(left), self._line(right)) for left, right in chosen]

    def _may_be_one_bar(self, left: _Line, right: _Line) -> bool:
        """Whether two limbs lie as far apart, and as parallel, as those of one bar."""
        slopes = SLOPES[[left.slope_index, right.slope_index]]
        width_mm = (right.column - left.column) * self.column_step_mm
        parallel = abs(slopes[0] - slopes[1]) <= MOST_SLOPE_DIFFERENCE
        return bool(parallel and WIDTH_RANGE_MM[0] <= width_mm <= WIDTH_RANGE_MM[1])

    def _hot_shares(self, pairs: list[tuple[_Line, _Line]], hot: Plane) -> list[float]:
        """Share of what lies between two limbs, along their mean slope, that is hot."""
        middle = np.array([(one.slope_index + other.slope_index) // 2 for one, other in pairs], dtype=np.intp)
        wanted, row = np.unique(middle, return_inverse=True)
        filled = np.zeros((len(wanted), len(self.x_mm) + 1))
        np.cumsum(self._along_slopes(hot, SLOPES[wanted]), axis=1, out=filled[:, 1:])
        return [
            float((filled[k, right.column] - filled[k, left.column]) / (right.column - left.column))
            for k, (left, right) in zip(row.tolist(), pairs, strict=True)
        ]

    def _line(self, line: _Line) -> Array:
        return np.array([SLOPES[line.slope_index], self.x_mm[line.column]])


@njit(nogil=True, cache=True)
def _sheared_means(values, shears, middle):
    """Mean over the rows of values that lie on lines column + shear * (row - middle); 0 beside the grid."""
    rows, columns = values.shape
    means = np.zeros((shears.shape[0], columns))
    for slope in range(shears.shape[0]):
        for row in range(rows):
            shift = shears[slope] * (row - middle)
            whole = int(np.floor(shift))
            right = np.float32(shift - whole)
            left = 1 - right
            begin, end = max(0, -whole), min(columns, columns - 1 - whole)
            # slices that start at 0 let the compiler add up many columns at once
            source, total = values[row, max(0, begin + whole) :], means[slope, begin:]
            for i in range(end - begin):
                total[i] += left * source[i] + right * source[i + 1]
    return means / rows


def _project_plane(camera: Camera, x_mm: Array, y_mm: Array) -> Array:
    """Pixels of a grid on the plane z = `PLANE_HEIGHT_MM`, shape (rows, columns, 2), (x, y).

    NaN outside the part of the lens model that the picture covers, where it would fold back.
    """
    x, y = np.meshgrid(x_mm, y_mm)
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, PLANE_HEIGHT_MM)])
    seen = points @ camera.R.T + camera.t
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.hypot(seen[:, 0], seen[:, 1]) / seen[:, 2]
    pixel = camera.project(points)
    pixel[~((seen[:, 2] > 0) & (radius <= farthest_ideal_radius(camera)))] = np.nan
    return pixel.reshape(*x.shape, 2)


def _hot(grid: NDArray[np.uint8], decode: NDArray[np.float32]) -> NDArray[np.uint8] | None:
    """Mask of hot pixels: above Otsu's level and the floor, and clearly brighter than the rest; None without any."""
    level, _ = cv2.threshold(grid, 0, 1, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    mask = (grid > max(level, float(np.searchsorted(decode, FLOOR_LIGHT)))).astype(np.uint8)
    if not mask.any() or mask.all():
        return None
    if _median_light(grid[mask == 1], decode) < LEAST_CONTRAST * _median_light(grid[mask == 0], decode):
        return None
    return mask


def _median_light(codes: NDArray[np.uint8], decode: NDArray[np.float32]) -> np.float32:
    """Median light of code values: light grows with them, and they are ranked by counting."""
    middle = [(codes.size - 1) // 2, codes.size // 2]
    return decode[np.searchsorted(np.cumsum(np.bincount(codes)), middle, side="right")].mean()
