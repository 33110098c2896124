"""Virtual boards: the checkerboard at any height and turn, from its pictures at a low and at a high one.

Corners are kept as ideal points (x/z, y/z) of each camera, without the lens' distortion: there, and only there, a
straight line in space is a straight line in the picture.

Both boards seen by one camera give the homographies H_low and H_high of their planes, and with equal first two columns,
which are the same directions in space, the third column of their difference is what a rise by h_high - h_low adds.
So every plane z = h + s_x x + s_y y has the homography

    H(h, s) = H_low + v [s_x, s_y, h - h_low],   v = (H_high - H_low) [0, 0, 1]' / (h_high - h_low),

from the two boards alone. `VirtualBoards.corners` is the same, corner by corner: the depths that weight both boards are
the third components of H_low and H_high, which the calibrated cameras know too.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.calibration.rig import Rig
from vision.geometry.camera import Camera

Array = NDArray[np.float64]

LEVEL = (0.0, 0.0)  # slope of a board that is parallel to those that were seen

# Corners (x, y) of the board that is projected where a registration picture is missing.
STAND_IN_MM = np.stack(np.meshgrid(np.linspace(-150.0, 150.0, 7), np.linspace(-75.0, 75.0, 4)), axis=-1).reshape(-1, 2)


@dataclass(frozen=True, slots=True, eq=False)
class BoardPair:
    """The low and the high board as one camera sees them, n corners.

    Attributes
    ----------
    low, high : ndarray of float64, shape (n, 2)
        Ideal points (x/z, y/z).
    low_depth_mm, high_depth_mm : ndarray of float64, shape (n,)
        Distance of the corners along the camera's axis.
    """

    low: Array
    high: Array
    low_depth_mm: Array
    high_depth_mm: Array

    def at(self, share: float | Array, *, projective: bool) -> Array:
        """Ideal points of the corners between the low and the high board.

        Parameters
        ----------
        share : float or ndarray of float64, shape (n,)
            Part of the way from the low to the high board, of all corners or of each; below 0 and above 1 it
            extrapolates.
        projective : bool
            See `VirtualBoards.corners`.

        Returns
        -------
        ndarray of float64, shape (n, 2)
        """
        shares = np.broadcast_to(np.asarray(share, dtype=np.float64), len(self.low))
        ones = np.ones(len(self.low))
        depths = (self.low_depth_mm, self.high_depth_mm) if projective else (ones, ones)
        return _mixed(self.low, self.high, *depths, np.ascontiguousarray(shares))


@njit(nogil=True, cache=True, error_model="numpy")
def _mixed(low, high, low_depth, high_depth, share):  # type: ignore[no-untyped-def]
    """Points between two sets, each weighted by its share of the way and its depth."""
    mixed = np.empty(low.shape)
    for corner in range(low.shape[0]):
        low_weight, high_weight = (1.0 - share[corner]) * low_depth[corner], share[corner] * high_depth[corner]
        for axis in range(2):
            total = low_weight * low[corner, axis] + high_weight * high[corner, axis]
            mixed[corner, axis] = total / (low_weight + high_weight)
    return mixed


@dataclass(frozen=True, slots=True, eq=False)
class VirtualBoards:
    """Checkerboards at any height, as both cameras would see them.

    Attributes
    ----------
    left, right : BoardPair
    low_mm, high_mm : float
        Heights of the two real boards.
    places_mm : ndarray of float64, shape (n, 2)
        x, y of the corners on the line.
    tilt_deg : float
        Of the line against the boards, see `Rig.along_line`; heights then count along the line's own z, and a level
        board is parallel to the line.
    """

    left: BoardPair
    right: BoardPair
    low_mm: float
    high_mm: float
    places_mm: Array
    tilt_deg: float = 0.0

    @classmethod
    def of_rig(cls, rig: Rig) -> Self:
        """Boards of a rig's registration pictures.

        Where a registration picture is missing, corners at the same two heights are projected by the rig's cameras
        instead, for both views, so that every calibrated rig has virtual boards.

        Parameters
        ----------
        rig : Rig
        """
        tilt_deg, rig = rig.tilt_deg, rig.along_line(0.0)
        names = ("left_low", "right_low", "left_high", "right_high")
        counts = {len(rig.boards.get(name, ())) for name in names}
        seen = rig.boards if len(counts) == 1 and counts != {0} else _projected(rig)
        left, right = (
            _pair(camera, seen[f"{side}_low"], seen[f"{side}_high"], rig)
            for side, camera in (("left", rig.left), ("right", rig.right))
        )
        return cls(left, right, rig.low_mm, rig.high_mm, _places_mm(rig.left, left), tilt_deg)

    def corners(
        self, height_mm: float, *, projective: bool = True, slope: tuple[float, float] = LEVEL
    ) -> tuple[Array, Array]:
        """Corners of the virtual board at a height, level or turned, interpolated or extrapolated.

        Parameters
        ----------
        height_mm : float
            Over the conveyor plane, at x = y = 0.
        projective : bool
            True: a corner that is raised evenly moves through the picture by the cross ratio of its heights,
            p = ((1 - s) d_low p_low + s d_high p_high) / ((1 - s) d_low + s d_high), d the depths of the two real
            corners and s = (h - h_low) / (h_high - h_low). False: eq. 4.2 with lambda = s / (1 - s), which leaves
            the depths out and so puts the corner at another height than the one asked for.
        slope : tuple of float
            Rise of the board in x and in y, mm per mm: each corner is raised to its own height.

        Returns
        -------
        tuple of two ndarray of float64, shape (n, 2)
            Ideal points (x/z, y/z) of the left and of the right camera, corner by corner.
        """
        share = self._share(height_mm, slope)
        return self.left.at(share, projective=projective), self.right.at(share, projective=projective)

    def left_corners(self, height_mm: float, *, projective: bool, slope: tuple[float, float]) -> Array:
        """Those of `corners` that the left camera would see."""
        return self.left.at(self._share(height_mm, slope), projective=projective)

    def _share(self, height_mm: float, slope: tuple[float, float]) -> Array:
        """Part of the way from the low to the high board, of each corner."""
        rise = math.tan(math.radians(self.tilt_deg))
        raised_mm = height_mm * math.hypot(1.0, rise) + self.places_mm @ (np.array(slope) + np.array([0.0, rise]))
        return (raised_mm - self.low_mm) / (self.high_mm - self.low_mm)


def _projected(rig: Rig) -> dict[str, Array]:
    return {
        f"{side}_{name}": camera.project(np.column_stack([STAND_IN_MM, np.full(len(STAND_IN_MM), height_mm)]))
        for side, camera in (("left", rig.left), ("right", rig.right))
        for name, height_mm in (("low", rig.low_mm), ("high", rig.high_mm))
    }


def _pair(camera: Camera, low_px: Array, high_px: Array, rig: Rig) -> BoardPair:
    low, high = (np.ascontiguousarray(camera.undistort(seen_px)) for seen_px in (low_px, high_px))
    return BoardPair(low, high, _depth_mm(camera, low, rig.low_mm), _depth_mm(camera, high, rig.high_mm))


def _places_mm(camera: Camera, boards: BoardPair) -> Array:
    """Where the corners of the low board lie, x and y."""
    rays = np.column_stack([boards.low, np.ones(len(boards.low))]) @ camera.R
    return (camera.centre_mm + rays * boards.low_depth_mm[:, None])[:, :2]


def _depth_mm(camera: Camera, ideal: Array, height_mm: float) -> Array:
    """Distance along the camera's axis at which rays meet the plane z = height."""
    rise = np.column_stack([ideal, np.ones(len(ideal))]) @ camera.R[:, 2]
    return (height_mm - camera.centre_mm[2]) / rise
