"""Still marks (fixed background points): strong corners that both registration pictures show at one place.

Their places in a later picture show whether the camera has moved since its calibration, which the bar's edges cannot
show. A mark that the bar hides, or lights differently, is not found again and does not count.
"""

import base64
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.calibration.json_fields import Fields
from vision.pictures import grey

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

MOST_MARKS = 20  # chosen: marks kept per camera, the strongest
PATCH_HALF_PX = 15  # chosen: half side of a mark's patch
PATCH_SIDE_PX = 2 * PATCH_HALF_PX + 1
SMOOTHING_PX = 1.5  # chosen: standard deviation of the Gaussian that removes noise, most of what dark pictures show
SEARCH_PX = 8  # chosen: a mark is searched up to this far around its place
FAR_SEARCH_PX = 128  # chosen: and up to this far, in pictures of half the size, when too few are found there
STILL_SHIFT_PX = 0.3  # chosen: a corner is a still mark if both registration pictures show it within 0.3 px
LEAST_CORRELATION = 0.7  # chosen: a mark is found again where its patch correlates with the picture by at least 0.7
BOARD_MARGIN_FACTOR = 1.5  # chosen: corners within 1.5 times the board's hull may be its sheet or its shadow
LEAST_MARKS = 6  # chosen: fewer marks found again say nothing of a moved camera
NOISE_SIGMAS = 3.0  # chosen: a motion of up to 3 standard deviations of its noise counts as none
MOST_MIXED = 0.99  # chosen: of the mixed derivative of a peak over the root of the product of the other two
AGREEMENT_PX = 0.5  # chosen: a mark further than this from the fitted motion is something else


@dataclass(frozen=True, slots=True, eq=False)
class MarksMotion:
    """How far marks have moved since the calibration.

    Attributes
    ----------
    moved_px : float
        Root mean square of the fitted motion over the marks, pixels, less what noise alone would give; NaN when too few
        marks agree on one.
    place_px : ndarray of float64, shape (m, 2)
        Places of the marks that agree, (x, y).
    curvature : ndarray of float64, shape (m, 2, 2)
    slope : ndarray of float64, shape (m, 2)
        A mark has moved by s where curvature s = slope, both of its correlation. Along an edge the curvature is small,
        since an edge says little of a shift that way.
    """

    moved_px: float
    place_px: Array
    curvature: Array
    slope: Array


NO_MOTION = MarksMotion(np.nan, np.empty((0, 2)), np.empty((0, 2, 2)), np.empty((0, 2)))


@dataclass(frozen=True, slots=True, eq=False)
class Marks:
    """Marks of one camera, n of them.

    Attributes
    ----------
    place_px : ndarray of int64, shape (n, 2)
        (x, y) of the middle pixels of the patches.
    patch : ndarray of float32, shape (n, 31, 31)
        Grey picture around them at calibration.
    """

    place_px: NDArray[np.int64]
    patch: NDArray[np.float32]

    def to_values(self) -> dict[str, object]:
        """Write them as JSON values: the patches as half-precision numbers in base 64."""
        return {
            "place_px": self.place_px.tolist(),
            "patch": base64.b64encode(self.patch.astype("<f2").tobytes()).decode("ascii"),
        }

    @classmethod
    def from_fields(cls, fields: Fields) -> "Marks":
        """Read what `to_values` wrote; `ValueError` names the key."""
        place = fields.array("place_px", (None, 2)).astype(np.int64)
        try:
            patch = np.frombuffer(base64.b64decode(str(fields.value("patch")), validate=True), "<f2")
            return cls(place, patch.astype(np.float32).reshape(len(place), PATCH_SIDE_PX, PATCH_SIDE_PX))
        except ValueError:
            fields.refuse("patch", f"this is not a patch of {PATCH_SIDE_PX} x {PATCH_SIDE_PX} pixels for every mark")

    def moved_px(self, picture: Picture) -> float:
        """Distance that the picture has moved since the calibration, px; see `motion`.

        Parameters
        ----------
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)

        Returns
        -------
        float
            NaN when too few marks agree on one.
        """
        return self.motion(picture).moved_px

    def motion(self, picture: Picture) -> "MarksMotion":
        """How the picture has moved since the calibration.

        A shift and a turn are fitted robustly to the marks that are found again.

        Parameters
        ----------
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)

        Returns
        -------
        MarksMotion
            Without marks when too few agree on one.
        """
        near = _motion_within(self, picture, SEARCH_PX)
        if np.isfinite(near.moved_px) or len(self.patch) < LEAST_MARKS:
            return near
        smooth = _smooth_grey(picture)
        half = cv2.resize(smooth, (smooth.shape[1] // 2, smooth.shape[0] // 2), interpolation=cv2.INTER_AREA)
        far = _motion_within(self._halved(), np.asarray(half, np.float32), FAR_SEARCH_PX // 2)
        return MarksMotion(2 * far.moved_px, 2 * far.place_px, far.curvature / 4, far.slope / 2)

    def _halved(self) -> "Marks":
        """Marks for pictures of half the size, each of whose pixels is four."""
        size = PATCH_SIDE_PX // 2
        begins = 1 - self.place_px % 2
        patch = [
            cv2.resize(one[y : y + 2 * size, x : x + 2 * size], (size, size), interpolation=cv2.INTER_AREA)
            for one, (x, y) in zip(self.patch, begins, strict=True)
        ]
        return Marks(self.place_px // 2, np.array(patch, np.float32))


NO_MARKS = Marks(np.empty((0, 2), np.int64), np.empty((0, PATCH_SIDE_PX, PATCH_SIDE_PX), np.float32))


def find_marks(low: Picture, high: Picture, boards_px: tuple[Array, Array]) -> Marks:
    """Marks of one camera from its two registration pictures.

    Parameters
    ----------
    low, high : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Pictures of the board at both heights.
    boards_px : tuple of ndarray of float64, shape (corners, 2)
        The board's corners in each, (x, y); no mark is searched around them.

    Returns
    -------
    Marks
        At most `MOST_MARKS`, the strongest.
    """
    smooth = _smooth_grey(low)
    free = np.full(smooth.shape, 255, np.uint8)
    border = PATCH_HALF_PX + SEARCH_PX + 1
    free[:border], free[-border:], free[:, :border], free[:, -border:] = 0, 0, 0, 0
    for corners in boards_px:
        middle = corners.mean(axis=0)
        hull = cv2.convexHull((middle + BOARD_MARGIN_FACTOR * (corners - middle)).astype(np.float32))
        cv2.fillConvexPoly(free, np.rint(hull).astype(np.int32), 0)
    corners = cv2.goodFeaturesToTrack(smooth, 4 * MOST_MARKS, 0.005, float(PATCH_HALF_PX), mask=free)
    if corners is None:
        return NO_MARKS
    place = np.rint(np.asarray(corners).reshape(-1, 2)).astype(np.int64)
    patch = np.array([_around(smooth, at, PATCH_HALF_PX) for at in place])
    found = [_found(one, high, at) for one, at in zip(patch, place, strict=True)]
    still = [one is not None and bool(np.hypot(*one.shift_px) < STILL_SHIFT_PX) for one in found]
    return Marks(place[still][:MOST_MARKS], patch[still][:MOST_MARKS])


def _smooth_grey(picture: Picture) -> NDArray[np.float32]:
    """Grey picture without most of its noise."""
    return np.asarray(cv2.GaussianBlur(grey(picture).astype(np.float32), (0, 0), SMOOTHING_PX), np.float32)


def _around(picture: NDArray[Any], place: NDArray[np.int64], half: int) -> NDArray[Any]:
    """What a square around a place shows, less where it leaves the picture."""
    x, y = place.tolist()
    return picture[max(y - half, 0) : max(y + half + 1, 0), max(x - half, 0) : max(x + half + 1, 0)]


def _motion_within(marks: Marks, picture: Picture | NDArray[np.float32], search_px: int) -> MarksMotion:
    both = zip(marks.patch, marks.place_px, strict=True)
    found = [(place, one) for patch, place in both if (one := _found(patch, picture, place, search_px)) is not None]
    if len(found) < LEAST_MARKS:
        return NO_MOTION
    return _agreed_motion(np.array([place for place, _ in found], np.float64), [one for _, one in found])


class _Found(NamedTuple):
    """A mark that is found again: how far it has moved along x and along y, each by itself; see `MarksMotion`."""

    shift_px: Array
    curvature: Array
    slope: Array


def _found(
    patch: NDArray[np.float32],
    picture: Picture | NDArray[np.float32],
    place: NDArray[np.int64],
    search_px: int = SEARCH_PX,
) -> _Found | None:
    """Where a patch is found again; None when it is not."""
    half_px = len(patch) // 2
    part = _around(picture, place, half_px + search_px)
    if min(part.shape[:2]) <= len(patch) + 1:  # at the border of the picture, or beyond it
        return None
    around = part if part.dtype == np.float32 else _smooth_grey(np.ascontiguousarray(part))  # without noise already
    alike = cv2.matchTemplate(around, patch, cv2.TM_CCOEFF_NORMED)
    _, best, _, (column, row) = cv2.minMaxLoc(alike)
    rows, columns = alike.shape
    if not (LEAST_CORRELATION <= best <= 1.001 and 0 < column < columns - 1 and 0 < row < rows - 1):
        return None
    left, top = (min(at - half_px, search_px) for at in place.tolist())  # of the search, before the patch's own place
    near = alike[row - 1 : row + 2, column - 1 : column + 2].astype(np.float64)
    return _Found(*_peak(near, float(column - left), float(row - top)))


@njit(nogil=True, cache=True, error_model="numpy")
def _peak(values, whole_x, whole_y):  # type: ignore[no-untyped-def]
    """A mark's shift, curvature and slope, from 3 x 3 correlations whose middle lies `whole` pixels from its own place.

    Parabolas through the middle along x and along y; without the mixed second derivative a shift along x is taken for
    one along y too on a corner whose lines lean the same way.
    """
    middle, left, right, up, down = values[1, 1], values[1, 0], values[1, 2], values[0, 1], values[2, 1]
    xx, yy = -min(left - 2 * middle + right, -1e-9), -min(up - 2 * middle + down, -1e-9)
    most = MOST_MIXED * np.sqrt(xx * yy)
    xy = min(max((values[0, 2] + values[2, 0] - values[0, 0] - values[2, 2]) / 4, -most), most)
    away_x, away_y = 0.5 * (right - left) / xx, 0.5 * (down - up) / yy
    slope_x = xx * away_x + (xx * whole_x + xy * whole_y)
    slope_y = yy * away_y + (xy * whole_x + yy * whole_y)
    shift = np.array([whole_x + away_x, whole_y + away_y])
    return shift, np.array([[xx, xy], [xy, yy]]), np.array([slope_x, slope_y])


def _agreed_motion(place: Array, found: list[_Found]) -> MarksMotion:
    """The shift and turn that most marks agree on; no motion when they do not."""
    shift, curvature, slope = (np.array(part) for part in zip(*found, strict=True))
    moved_px, agrees = _moved_px(place, shift)
    return NO_MOTION if np.isnan(moved_px) else MarksMotion(moved_px, place[agrees], curvature[agrees], slope[agrees])


@njit(nogil=True, cache=True, error_model="numpy")
def _moved_px(place, shift):  # type: ignore[no-untyped-def]
    """Fitted motion less its noise, NaN where too few marks agree on one; and which do."""
    count = len(place)
    x, y = place[:, 0] - place[:, 0].mean(), place[:, 1] - place[:, 1].mean()
    across, down, turn = np.median(shift[:, 0]), np.median(shift[:, 1]), 0.0
    agrees = np.ones(count, np.bool_)
    for _ in range(4):
        off = np.hypot(shift[:, 0] - (across - turn * y), shift[:, 1] - (down + turn * x))
        agrees = off <= max(AGREEMENT_PX, np.median(off))
        across, down, turn = _fitted(x[agrees], y[agrees], shift[agrees])  # at least half of the marks, which lie apart
    moved_x, moved_y = (across - turn * y)[agrees], (down + turn * x)[agrees]
    off_x, off_y = shift[agrees, 0] - moved_x, shift[agrees, 1] - moved_y
    if np.count_nonzero(np.hypot(off_x, off_y) <= AGREEMENT_PX) < max(LEAST_MARKS, count // 2):
        return np.nan, agrees
    kept = len(off_x)
    # three fitted numbers bring the noise of three coordinates, over the number of marks
    by_noise = 3 * (off_x**2 + off_y**2).sum() / max(2 * kept - 3, 1) / kept
    return np.sqrt(max((moved_x**2 + moved_y**2).mean() - NOISE_SIGMAS**2 * by_noise, 0.0)), agrees


@njit(nogil=True, cache=True, error_model="numpy")
def _fitted(x, y, shift):  # type: ignore[no-untyped-def]
    """Shift along x and y, and turn, by least squares."""
    count, sum_x, sum_y = len(x), x.sum(), y.sum()
    across, down = shift[:, 0].sum(), shift[:, 1].sum()
    turned = (x * shift[:, 1] - y * shift[:, 0]).sum() + (sum_y * across - sum_x * down) / count
    turn = turned / ((x * x + y * y).sum() - (sum_x**2 + sum_y**2) / count)
    return (across + turn * sum_y) / count, (down - turn * sum_x) / count, turn
