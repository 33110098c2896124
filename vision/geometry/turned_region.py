"""The measuring region, resampled: undistorted, mapped to the measuring plane, its rows across the bar.

Bars run obliquely through real pictures, and eq. 3.14, which compares two points of one row, is a diameter only where
rows cross the bar at a right angle. A turned region is therefore sampled on the horizontal plane
z = `PLANE_HEIGHT_MM` with rows along the bar's section and columns along its axis. `picture_region` has the
dissertation's rows, those of the undistorted picture, to show what the turn is worth (docs/studies/virtual_board.json).
"""

from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.geometry.camera import Camera
from vision.geometry.measuring_plane import PLANE_HEIGHT_MM, farthest_ideal_radius
from vision.light_planes import LightPlane, bilinear_light
from vision.sent_picture import Codes, SentPicture

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
Maps = tuple[NDArray[np.int16], NDArray[np.uint16]]

TURN_STEP_RAD = 0.0025  # half a step turns a width of 300 mm by less than 0.001 mm
BLOCK_COLUMNS = 64  # columns come in whole blocks, so that the map of a bar that has moved a little is used again
KEPT_MAPS = 4  # maps kept per camera


@dataclass(frozen=True, eq=False)
class Region:
    """One view, resampled where someone looks at it: edges need strips of it, overlays and fusion the whole picture.

    Attributes
    ----------
    maps : tuple of two ndarray, or None
        Place of each pixel in the raw picture, see `fixed_point_map`; None: the raw picture's pixels are the region's.
    to_ideal : ndarray of float64, shape (3, 3)
        Homography from (column, row) to the camera's ideal points (x/z, y/z).
    from_world : ndarray of float64, shape (2, 3)
        For a turned region, column and row of (x, y, 1), a point of the plane, mm; NaN for rows of the picture.
    raw : Picture
        The picture that was resampled, with its coding.
    camera : Camera
    """

    maps: Maps | None
    to_ideal: Array
    from_world: Array
    raw: SentPicture
    camera: Camera

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        rows, columns = (self.raw.shown if self.maps is None else self.maps[1]).shape[:2]
        return rows, columns

    @cached_property
    def picture(self) -> Picture:
        """The whole picture as shown, shape (rows, columns) or (rows, columns, 3); 0 where the camera sees nothing."""
        return self.part(slice(None))

    def part(self, columns: slice) -> Picture:
        """Some columns of `picture`."""
        if self.maps is None:
            return self.raw.shown[:, columns]
        whole, part = (each[:, columns] for each in self.maps)
        return np.asarray(cv2.remap(self.raw.shown, whole, part, cv2.INTER_LINEAR), dtype=np.uint8)

    def at(self, columns: NDArray[np.int64]) -> Picture:
        """`picture` at k columns of each row.

        Parameters
        ----------
        columns : ndarray of int64, shape (rows, k)

        Returns
        -------
        ndarray of uint8, shape (rows, k) or (rows, k, 3)
        """
        if self.maps is None:
            return self.raw.shown[np.arange(len(columns))[:, None], columns]
        whole, part = _picked(*self.maps, columns)
        if columns.shape[1] == 1:  # OpenCV is seven times as fast along a row
            whole, part = whole.reshape(1, -1, 2), part.reshape(1, -1)
        found = np.asarray(cv2.remap(self.raw.shown, whole, part, cv2.INTER_LINEAR), dtype=np.uint8)
        return found.reshape(*columns.shape, *self.raw.shown.shape[2:])

    def light(self, rows: NDArray[np.int64], columns: Array, plane: LightPlane) -> Array:
        """Linear light of the raw picture at places of the region, bilinear between raw pixels.

        Code values that were mixed first and decoded afterwards are too dark at an edge, which then lies about
        0.05 px inwards; so edges are located on this and not on `picture`.

        Parameters
        ----------
        rows : ndarray of int64, shape (n,)
        columns : ndarray of float64, shape (n, m)
            Columns of m places in each of those rows of the region.
        plane : LightPlane
            Which of the raw code values count, and their light.

        Returns
        -------
        ndarray of float64, shape (n, m)
            NaN outside the raw picture.
        """
        lens = self.to_ideal, self.camera.dist, self.camera.K
        return _light(lens, rows, columns, self.raw.measured, plane.compiled)

    def seen_on(self, other: "Region", to_other: Array) -> Picture:
        """Raw picture resampled on another region's pixels, and that region's own where this camera sees nothing.

        Parameters
        ----------
        other : Region
        to_other : ndarray of float64, shape (3, 3)
            Homography from this region's (column, row) to the other's.

        Returns
        -------
        ndarray of uint8, shape of `other.picture`
        """
        aligned = other.picture.copy()
        maps = self._maps_on(other, to_other)
        cv2.remap(self.raw.shown, *maps, cv2.INTER_LINEAR, dst=aligned, borderMode=cv2.BORDER_TRANSPARENT)
        return aligned

    def seen_pixels(self, other: "Region", to_other: Array) -> NDArray[np.bool_]:
        """Pixels of another region that this camera sees whole, with all neighbours that `seen_on` mixes.

        Parameters
        ----------
        other : Region
        to_other : ndarray of float64, shape (3, 3)
            See `seen_on`.

        Returns
        -------
        ndarray of bool, shape (rows, columns)
        """
        white = np.full(self.raw.shown.shape[:2], 255, dtype=np.uint8)
        return np.asarray(cv2.remap(white, *self._maps_on(other, to_other), cv2.INTER_LINEAR)) == 255

    def _maps_on(self, other: "Region", to_other: Array) -> Maps:
        to_ideal = self.to_ideal @ np.linalg.inv(to_other)
        # a homography is known up to its sign; the depths that it gives must be positive
        middle = np.array([other.shape[1] / 2, other.shape[0] / 2, 1.0])
        to_ideal *= np.sign(to_ideal[2] @ middle)
        return fixed_point_map(self.camera, to_ideal, other.shape, farthest_ideal_radius(self.camera))


class RegionSampler:
    """Samples turned regions of one camera's pictures.

    Parameters
    ----------
    camera : Camera
    region_y_mm : tuple of float
        Measuring region along the rolling direction.
    step_mm : float
        Size of a pixel of the region.
    """

    def __init__(self, camera: Camera, region_y_mm: tuple[float, float], step_mm: float) -> None:
        self._camera = camera
        self._first_mm = region_y_mm[0]
        self._step_mm = step_mm
        self._rows = max(2, round((region_y_mm[1] - region_y_mm[0]) / step_mm) + 1)
        self._radius = farthest_ideal_radius(camera)
        self._maps: OrderedDict[tuple[int, int, int], Maps] = OrderedDict()

    def turned(self, image: SentPicture | Codes, slope: float, across_mm: tuple[float, float]) -> Region:
        """Region whose rows cross a bar at a right angle.

        Parameters
        ----------
        image : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
        slope : float
            dx/dy of the bar.
        across_mm : tuple of float
            Least and greatest distance across the bar that the region covers, from the line along the bar through the
            origin.

        Returns
        -------
        Region
        """
        turn = round(np.arctan(slope) / TURN_STEP_RAD)
        block_mm = BLOCK_COLUMNS * self._step_mm
        first, last = int(np.floor(across_mm[0] / block_mm)), int(np.ceil(across_mm[1] / block_mm))
        to_world = self._to_world(turn * TURN_STEP_RAD, first * block_mm)
        R, t = self._camera.R, self._camera.t
        to_ideal = np.column_stack([R[:, 0], R[:, 1], R[:, 2] * PLANE_HEIGHT_MM + t]) @ to_world
        columns = (max(last, first + 1) - first) * BLOCK_COLUMNS
        maps = self._map((turn, first, columns), to_ideal)
        from_world = np.asarray(np.linalg.inv(to_world), dtype=np.float64)[:2]
        return Region(maps, to_ideal, from_world, SentPicture.of(image), self._camera)

    def _to_world(self, turn: float, first_mm: float) -> Array:
        """Homography from (column, row) to (x, y), mm, on the plane."""
        c, s, step = np.cos(turn), np.sin(turn), self._step_mm
        turned = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return turned @ np.array([[step, 0.0, first_mm], [0.0, step, self._first_mm], [0.0, 0.0, 1.0]])

    def _map(self, key: tuple[int, int, int], to_ideal: Array) -> Maps:
        if key not in self._maps:
            self._maps[key] = fixed_point_map(self._camera, to_ideal, (self._rows, key[2]), self._radius)
            if len(self._maps) > KEPT_MAPS:
                self._maps.popitem(last=False)
        self._maps.move_to_end(key)
        return self._maps[key]


def picture_region(camera: Camera, image: SentPicture | Codes, region_y_mm: tuple[float, float]) -> Region:
    """Rows of the undistorted picture that show the measuring region, whole width.

    Parameters
    ----------
    camera : Camera
    image : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
    region_y_mm : tuple of float
        Measuring region along the rolling direction, as seen at x = 0 on the plane.

    Returns
    -------
    Region
    """
    ends = np.array([[0.0, y_mm, PLANE_HEIGHT_MM] for y_mm in region_y_mm])
    width, height = camera.image_size
    low, high = np.sort(np.clip(camera.project(ends)[:, 1], 0, height - 1))
    rows = max(2, round(high - low) + 1)
    moved = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, low], [0.0, 0.0, 1.0]])
    to_ideal = np.asarray(np.linalg.solve(camera.K, moved), dtype=np.float64)
    maps = fixed_point_map(camera, to_ideal, (rows, width), farthest_ideal_radius(camera))
    return Region(maps, to_ideal, np.full((2, 3), np.nan), SentPicture.of(image), camera)


def whole_picture(camera: Camera, image: SentPicture | Codes) -> Region:
    """Return the undistorted picture as a region, its pixels those of the camera without its lens.

    Parameters
    ----------
    camera : Camera
    image : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)

    Returns
    -------
    Region
    """
    raw = SentPicture.of(image)
    to_ideal = np.asarray(np.linalg.inv(camera.K), dtype=np.float64)
    maps = fixed_point_map(camera, to_ideal, raw.shown.shape[:2], farthest_ideal_radius(camera))
    return Region(maps, to_ideal, np.full((2, 3), np.nan), raw, camera)


def resampled_region(picture: SentPicture | Picture, region: Region) -> Region:
    """Wrap an already resampled picture as a Region whose raw picture it is itself (identity camera).

    Parameters
    ----------
    picture : SentPicture, or ndarray of uint8, shape of `region.picture`
        Has the pixels of `region`.
    region : Region

    Returns
    -------
    Region
    """
    sent = SentPicture.of(picture)
    camera = Camera(np.eye(3), np.zeros(5), np.eye(3), np.zeros(3), sent.size)
    return Region(None, np.eye(3), region.from_world, sent, camera)


def luma_region(region: Region) -> Region:
    """Region of the luma that its camera sent, in 8 bits of full range.

    Parameters
    ----------
    region : Region
        Of a picture whose luma is measured.

    Returns
    -------
    Region
        Grey.
    """
    raw = region.raw
    scale = 255 / (raw.coding.white - raw.coding.black)
    above = np.maximum(raw.measured[:, :, 0], raw.coding.black) - raw.coding.black
    luma = np.rint(np.minimum(above * scale, 255)).astype(np.uint8)
    return replace(region, raw=replace(raw, shown=luma))


def fixed_point_map(camera: Camera, to_ideal: Array, shape: tuple[int, int], radius: float) -> Maps:
    """Place of each pixel of a region in the raw picture, in the fixed-point form of `cv2.remap`.

    Parameters
    ----------
    camera : Camera
    to_ideal : ndarray of float64, shape (3, 3)
        See `Region`.
    shape : tuple of int
        (rows, columns).
    radius : float
        Ideal points further from the axis lie outside the picture.

    Returns
    -------
    tuple of ndarray of int16, shape (rows, columns, 2), and of uint16, shape (rows, columns)
        Whole pixels, and 1/32 of them.
    """
    whole, part = np.empty((*shape, 2), dtype=np.int16), np.empty(shape, dtype=np.uint16)
    _fill_map(to_ideal, camera.dist, camera.K, radius**2, whole, part)
    return whole, part


@njit(nogil=True, cache=True)
def _raw_pixel(H, dist, K, c, r):  # type: ignore[no-untyped-def]
    """Pixel (x, y) of the raw picture at a place of a region, and its squared ideal radius; infinite behind it."""
    w = H[2, 0] * c + H[2, 1] * r + H[2, 2]
    if w <= 0.0:
        return 0.0, 0.0, np.inf
    x = (H[0, 0] * c + H[0, 1] * r + H[0, 2]) / w
    y = (H[1, 0] * c + H[1, 1] * r + H[1, 2]) / w
    r2 = x * x + y * y
    radial = 1.0 + r2 * (dist[0] + r2 * (dist[1] + r2 * dist[4]))
    u = x * radial + 2.0 * dist[2] * x * y + dist[3] * (r2 + 2.0 * x * x)
    v = y * radial + dist[2] * (r2 + 2.0 * y * y) + 2.0 * dist[3] * x * y
    return K[0, 0] * u + K[0, 2], K[1, 1] * v + K[1, 2], r2


@njit(nogil=True, cache=True)
def _fill_map(H, dist, K, radius2, whole, part):  # noqa: PLR0917  # type: ignore[no-untyped-def]
    rows, columns = part.shape
    for r in range(rows):
        for c in range(columns):
            x, y, r2 = _raw_pixel(H, dist, K, c, r)
            if r2 > radius2:
                whole[r, c, 0] = whole[r, c, 1] = -2
                part[r, c] = 0
                continue
            px, py = int(np.floor(32.0 * x + 0.5)), int(np.floor(32.0 * y + 0.5))
            whole[r, c, 0] = min(max(px >> 5, -2), 32000)
            whole[r, c, 1] = min(max(py >> 5, -2), 32000)
            part[r, c] = (py & 31) * 32 + (px & 31)


@njit(nogil=True, cache=True)
def _picked(whole, part, columns):  # type: ignore[no-untyped-def]
    """A map at some columns of each row."""
    some, parts = np.empty((*columns.shape, 2), dtype=np.int16), np.empty(columns.shape, dtype=np.uint16)
    for r in range(columns.shape[0]):
        for k in range(columns.shape[1]):
            c = columns[r, k]
            some[r, k, 0], some[r, k, 1], parts[r, k] = whole[r, c, 0], whole[r, c, 1], part[r, c]
    return some, parts


@njit(nogil=True, cache=True)
def _light(lens, rows, columns, raw, plane):  # type: ignore[no-untyped-def]
    H, dist, K = lens
    height, width = raw.shape[:2]
    light = np.full(columns.shape, np.nan)
    for r in range(columns.shape[0]):
        for k in range(columns.shape[1]):
            x, y, r2 = _raw_pixel(H, dist, K, columns[r, k], rows[r])
            if r2 < np.inf and 0.0 <= x < width - 1 and 0.0 <= y < height - 1:
                light[r, k] = bilinear_light(raw, plane, x, y)
    return light
