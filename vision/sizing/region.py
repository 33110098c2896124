"""The measuring region seen from above, and the hot bar in it, roughly.

Each view is sampled on a grid on a horizontal plane: rows run across the line, columns along it, so that a bar
stands nearly upright in it however obliquely it crosses the picture. The grid only says where the edges are to
within a few millimetres; they are located on raw pixels afterwards.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.rig import Camera

Array = NDArray[np.float64]

PLANE_HEIGHT_MM = 100.0  # between the axis heights of the smallest and of the largest bar
ROW_STEP_MM = 5.0
COLUMN_STEP_PX = 2.0
REACH_MM = 1500.0  # across the line, either side
LEAST_WIDTH_MM = 40.0  # narrower bright stripes are sparks, rails, reflections
LEAST_COVER = 0.6  # share of the region's rows that a bar must cross
CLOSING_MM = 20.0  # gaps that oxide patches may leave
FLOOR = 0.06  # of full scale, in light: a bar that glows is brighter than that
CONTRAST = 2.0  # a bar is that many times brighter than the rest


@dataclass(frozen=True, slots=True, eq=False)
class Stripe:
    """A bright stripe across the region: one candidate for the bar.

    Attributes
    ----------
    y_mm : ndarray of float64, shape (n,)
        Rows of the grid that it crosses.
    left_mm, right_mm : ndarray of float64, shape (n,)
        Its two sides (x), on the grid's plane.
    """

    y_mm: Array
    left_mm: Array
    right_mm: Array


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
        self.column_step_mm = COLUMN_STEP_PX * _pixel_size_mm(camera)
        x_mm = np.arange(-REACH_MM, REACH_MM, self.column_step_mm)
        pixel = project_plane(camera, x_mm, self.y_mm)
        width, height = camera.image_size
        inside = np.all((pixel >= 0) & (pixel <= [width - 1, height - 1]), axis=2)
        seen = np.flatnonzero(inside.mean(axis=0) > LEAST_COVER)
        if seen.size < 2:
            raise ValueError("the camera does not see the measuring region: is it the right rig?")
        columns = slice(seen[0], seen[-1] + 1)
        self.x_mm = x_mm[columns]
        self._pixel = np.nan_to_num(pixel[:, columns], nan=-1.0).astype(np.float32)

    def sample(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Brightest channel of the picture on the grid, code values, shape (rows, columns); 0 outside the picture."""
        grid = cv2.remap(image, self._pixel[..., 0], self._pixel[..., 1], cv2.INTER_LINEAR)
        return np.asarray(grid if grid.ndim == 2 else grid.max(axis=2), dtype=np.uint8)

    def stripes(self, image: NDArray[np.uint8], decode: NDArray[np.float32]) -> list[Stripe]:
        """Bright stripes that cross the region, left to right.

        Parameters
        ----------
        image : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        decode : ndarray of float32, shape (256,)
            Light of every code value.

        Returns
        -------
        list of Stripe
        """
        grid = np.asarray(cv2.blur(self.sample(image), (3, 3)), dtype=np.uint8)
        mask = _hot(grid, decode)
        gap = round(CLOSING_MM / ROW_STEP_MM), round(CLOSING_MM / self.column_step_mm)
        closing = cv2.getStructuringElement(cv2.MORPH_RECT, (2 * (gap[1] // 2) + 1, 2 * (gap[0] // 2) + 1))
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, closing)
        count, label, statistics, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
        found = [
            self._stripe(label == index)
            for index in range(1, count)
            if statistics[index, cv2.CC_STAT_HEIGHT] >= LEAST_COVER * self.y_mm.size
        ]
        wide = [one for one in found if np.median(one.right_mm - one.left_mm) >= LEAST_WIDTH_MM]
        return sorted(wide, key=lambda one: float(np.median(one.left_mm)))

    def _stripe(self, mask: NDArray[np.bool_]) -> Stripe:
        rows = np.flatnonzero(mask.any(axis=1))
        first = mask[rows].argmax(axis=1)
        last = mask.shape[1] - 1 - mask[rows, ::-1].argmax(axis=1)
        half = 0.5 * self.column_step_mm
        return Stripe(self.y_mm[rows], self.x_mm[first] - half, self.x_mm[last] + half)


def project_plane(camera: Camera, x_mm: Array, y_mm: Array) -> Array:
    """Pixels of a grid on the plane z = `PLANE_HEIGHT_MM`, shape (rows, columns, 2), (x, y).

    NaN outside the part of the lens model that the picture covers, where it would fold back.
    """
    x, y = np.meshgrid(x_mm, y_mm)
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, PLANE_HEIGHT_MM)])
    width, height = camera.image_size
    border = np.array([[0, 0], [width, 0], [0, height], [width, height]], dtype=np.float64)
    farthest = np.nanmax(np.linalg.norm(camera.undistort(border), axis=1))
    seen = points @ camera.R.T + camera.t
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.hypot(seen[:, 0], seen[:, 1]) / seen[:, 2]
    pixel = camera.project(points)
    pixel[~((seen[:, 2] > 0) & (radius <= 1.05 * farthest))] = np.nan
    return pixel.reshape(*x.shape, 2)


def _pixel_size_mm(camera: Camera) -> float:
    distance = abs(camera.R[2] @ np.array([0.0, 0.0, PLANE_HEIGHT_MM]) + camera.t[2])
    return float(distance / camera.K[0, 0])


def _hot(grid: NDArray[np.uint8], decode: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Mask of what is hot: over Otsu's level, over the floor and well brighter than the rest."""
    level, mask = cv2.threshold(grid, 0, 1, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    level = max(level, float(np.searchsorted(decode, FLOOR)))
    mask = (grid > level).astype(np.uint8)
    if not mask.any() or mask.all():
        return np.zeros_like(mask)
    light = decode[grid]
    if np.median(light[mask == 1]) < CONTRAST * np.median(light[mask == 0]):
        return np.zeros_like(mask)
    return mask
