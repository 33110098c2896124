"""Alignment of the right view to the left one by virtual boards, and the height at which the bar's outlines agree.

Algorithms 11, 12 and 13 of the dissertation. T_RL maps the right view's board corners to the left view's; whatever lies
in the board's plane then coincides. Q_R measures how far the two outlines of the bar coincide. The board is raised or
lowered virtually until they do, by the dissertation's search over n boards or by a loop that starts from the last
frame's height.
"""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.alignment.quality import BarOutline, Quality, alignment_quality
from vision.alignment.virtual_boards import LEVEL, VirtualBoards
from vision.calibration.rig import Rig
from vision.geometry.homography import plane_to_ideal, solved, transformed
from vision.geometry.turned_region import Picture, Region

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """Both views of one pair, and the boards that align them.

    Attributes
    ----------
    rig : Rig
    boards : VirtualBoards
    left, right : Region
    projective : bool
        How boards are interpolated; see `VirtualBoards.corners`.
    slope : tuple of float
        Of every virtual board; see `VirtualBoards.corners`.
    """

    rig: Rig
    boards: VirtualBoards
    left: Region
    right: Region
    projective: bool
    slope: tuple[float, float] = LEVEL
    _known: dict[float, Array] = field(init=False, repr=False, default_factory=dict[float, Array])

    def right_to_left(self, height_mm: float) -> Array:
        """T_RL of algorithm 11 for the virtual board at a height: homography from the right to the left region."""
        if height_mm not in self._known:
            self._known[height_mm] = self._right_to_left(height_mm)
        return self._known[height_mm]

    def _right_to_left(self, height_mm: float) -> Array:
        to, of = self.boards.corners(height_mm, projective=self.projective, slope=self.slope)
        T, _ = cv2.findHomography(of, to, 0)
        return solved(self.left.to_ideal, np.asarray(T, dtype=np.float64) @ self.right.to_ideal)

    def right_on_left(self, height_mm: float) -> Picture:
        """Right view as it looks on the left region's pixels by the virtual board at a height, shape of `left.picture`.

        What lies in the board's plane then coincides with the left picture, which also fills what the right camera does
        not see.
        """
        return self.right.seen_on(self.left, self.right_to_left(height_mm))

    def seen_by_both(self, height_mm: float) -> NDArray[np.bool_]:
        """Pixels of the left region that both cameras see on the virtual board at a height, shape (rows, columns)."""
        own = self.left.seen_pixels(self.left, np.eye(3))
        return own & self.right.seen_pixels(self.left, self.right_to_left(height_mm))

    def parallax(self, height_mm: float) -> Array:
        """Change of `right_to_left` per mm of height, as the rig's cameras have it, at one height."""
        up, down = (self._by_cameras(height_mm + step) for step in (0.5, -0.5))
        return up / up[2, 2] - down / down[2, 2]

    def _by_cameras(self, height_mm: float) -> Array:
        left, right = (plane_to_ideal(camera, height_mm) for camera in (self.rig.left, self.rig.right))
        return solved(self.left.to_ideal, left @ solved(right, self.right.to_ideal))

    def to_plane(self, height_mm: float) -> Array:
        """Homography from the left region to (x, y), mm, on the plane z = height: eq. 3.13 read as a plane's."""
        return solved(plane_to_ideal(self.rig.left, height_mm), self.left.to_ideal)

    def test_rows(self, height_mm: float) -> Array:
        """Rows of the left region within P_re of the board's middle, P_re a quarter of the region (algorithm 12)."""
        corners = self.boards.left_corners(height_mm, projective=self.projective, slope=self.slope)
        middle = float(transformed(solved(self.left.to_ideal, np.eye(3)), corners)[:, 1].mean())
        rows = self.left.shape[0]
        middle = min(max(middle, rows / 4), 3 * rows / 4)
        return np.arange(math.ceil(middle - rows / 4), math.floor(middle + rows / 4) + 1, dtype=np.float64)

    def quality(self, left: BarOutline, right: BarOutline, height_mm: float) -> Quality:
        """Q_R and the offset of the outlines' centroids for the virtual board at a height (algorithm 12).

        Parameters
        ----------
        left, right : BarOutline
            In the pixels of the left and of the right region.
        height_mm : float
            Of the board over the conveyor plane.
        """
        return alignment_quality(left, right.moved(self.right_to_left(height_mm)), self.test_rows(height_mm))
