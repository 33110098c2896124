"""A pair of views aligned by one virtual board, and the widths of the bar on the board's plane."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.alignment.height_search import Height
from vision.alignment.quality import BarOutline
from vision.alignment.view_alignment import Alignment
from vision.geometry.homography import transformed
from vision.sizing.virtual_board.parameters import Parameters
from vision.sizing.virtual_board.random_regression import random_regression
from vision.sizing.virtual_board.view_edges import ViewEdges

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class AlignedPair:
    """Both views on the chosen board.

    Attributes
    ----------
    alignment : Alignment
    height : Height
        Of the board.
    edges : list of ViewEdges
        Of the left and of the right view.
    outline : BarOutline
        Of the left view.
    """

    alignment: Alignment
    height: Height
    edges: list[ViewEdges]
    outline: BarOutline

    def to_plane(self, view: int) -> Array:
        """Homography from a view's region to (x, y), mm, on the board's plane, as the left camera sees it."""
        left = self.alignment.to_plane(self.height.height_mm)
        return left if view == 0 else left @ self.alignment.right_to_left(self.height.height_mm)

    def sampled_widths_mm(self, view: int, parameters: Parameters, rng: np.random.Generator) -> Array:
        """Width of the bar on the plane, eq. 3.14, mean over the rows of each window.

        Parameters
        ----------
        view : int
            0 left, 1 right.
        parameters : Parameters
            S and T of the random regression.
        rng : numpy.random.Generator
            Draws the points of the random regression.

        Returns
        -------
        ndarray of float64, shape (windows, T)
            mm; NaN where an edge has too few points in the window.
        """
        first, second = self.edges[view].sides
        windows, to_plane = len(first.row), self.to_plane(view)
        window_rows = (self.alignment.left, self.alignment.right)[view].shape[0] // windows
        rows = np.arange(windows * window_rows, dtype=np.float64).reshape(windows, window_rows)
        lines = [
            random_regression(side, parameters.sample_points, parameters.sample_count, rng) for side in (first, second)
        ]
        return _mean_widths(
            np.ascontiguousarray(to_plane), (lines[0].slope, lines[0].start), (lines[1].slope, lines[1].start), rows
        )

    def section_frame(self) -> tuple[Array, float]:
        """Cameras in the bar's section plane, shape (2, 2), and the place of the outline's middle across it, mm."""
        to_plane = self.alignment.to_plane(self.height.height_mm)
        first, second = (transformed(to_plane, edge[[0, -1]]) for edge in (self.outline.first, self.outline.second))
        middle = 0.5 * (first + second)
        along = (middle[1] - middle[0]) / np.linalg.norm(middle[1] - middle[0])
        along = along if along[1] > 0 else -along
        across = np.array([along[1], -along[0]])
        rig = self.alignment.rig
        centres = np.array([rig.left.centre_mm, rig.right.centre_mm])
        return np.column_stack([centres[:, :2] @ across, centres[:, 2]]), float(middle[0] @ across)


@njit(nogil=True, cache=True)
def _mean_widths(to_plane, first, second, rows):  # type: ignore[no-untyped-def]
    """Mean distance on a plane of the two lines' points in the rows of each window, (windows, T)."""
    windows, times = first[0].shape
    width = np.empty((windows, times))
    for window in range(windows):
        for time in range(times):
            total = 0.0
            for row in rows[window]:
                x, y = _moved(to_plane, first[0][window, time] * row + first[1][window, time], row)
                other_x, other_y = _moved(to_plane, second[0][window, time] * row + second[1][window, time], row)
                total += np.hypot(other_x - x, other_y - y)
            width[window, time] = total / rows.shape[1]
    return width


@njit(nogil=True, cache=True, error_model="numpy")
def _moved(homography, x, y):  # type: ignore[no-untyped-def]
    """`vision.geometry.homography.transformed` of one point."""
    away = homography[2, 0] * x + homography[2, 1] * y + homography[2, 2]
    moved_x = homography[0, 0] * x + homography[0, 1] * y + homography[0, 2]
    moved_y = homography[1, 0] * x + homography[1, 1] * y + homography[1, 2]
    return moved_x / away, moved_y / away
