"""Pictures of checkerboards on the line, through the true lens, for `hotgauge calibrate`."""

import math
from collections.abc import Iterator

import cv2
import numpy as np
from numba import njit

from appliance.simulation.bars.line_scene import Picture, Scene, View
from appliance.simulation.boards.boards import Board, Pose, high_pose, low_pose, random_poses
from appliance.simulation.sensor import Blur, Light, NoiseStock
from appliance.simulation.true_rig import Points, TrueRig

CELLS = 4  # per pixel's side: the lens blurs these, the pixel then collects them
APERTURE_VARIANCE_PX2 = 1 / 12  # of the square pixel
BORDER_PX = 24
WHITE = 0.42
BLACK = 0.03
LAMP_FALL_PER_SQUARE = 0.02
BACKGROUND_GAIN = 3.0  # boards are taken with a longer exposure than hot bars


def rig_folder_pictures(
    scene: Scene, rig: TrueRig, rng: np.random.Generator, board: Board, poses: int
) -> Iterator[tuple[str, Picture, Picture]]:
    """Pictures of a rig folder, grey: (path with a place for the side, left picture, right picture).

    Raises
    ------
    ValueError
        The board does not fit into both pictures of this rig.
    """
    places = {
        f"calibration/{{side}}_{number:02}.png": pose
        for number, pose in enumerate(random_poses(rig, rng, board, poses))
    }
    places["registration/{side}_low.png"] = low_pose(board)
    places["registration/{side}_high.png"] = high_pose(board)
    for path, pose in places.items():
        starts = rng.integers(NoiseStock.EXTRA, size=2)
        left, right = (
            view.grey_picture(board_light(view, board, pose), int(start))
            for view, start in zip((scene.left, scene.right), starts, strict=True)
        )
        yield path, left, right


def board_light(view: View, board: Board, pose: Pose) -> Light:
    """Linear light of a board in front of the still background, before noise, shape (rows, columns)."""
    light = np.float32(BACKGROUND_GAIN) * view.background[1]
    part = _around(view.camera.project(pose.in_world(board.sheet_mm())), light.shape)
    on_board = _board_coordinates(view.camera.centre_mm, view.rays[part].astype(np.float64), pose)
    sheet, print_light = (_collected(cells, view.blur) for cells in _print_cells(on_board, board))
    light[part] = light[part] * (1 - sheet) + print_light
    return light


def _around(pixels: Points, shape: tuple[int, ...]) -> tuple[slice, slice]:
    low = np.maximum(np.floor(pixels.min(axis=0)).astype(int) - BORDER_PX, 0)
    high = np.minimum(np.ceil(pixels.max(axis=0)).astype(int) + BORDER_PX, shape[::-1])
    return slice(low[1], high[1]), slice(low[0], high[0])


def _board_coordinates(centre_mm: Points, rays: Points, pose: Pose) -> Points:
    """Where rays meet the board's plane, on the board, shape (2, rows, columns), mm."""
    normal = np.cross(pose.axes[0], pose.axes[1])
    depth = ((pose.centre_mm - centre_mm) @ normal) / (rays @ normal)
    points = centre_mm + rays * depth[..., None]
    return np.moveaxis((points - pose.centre_mm) @ pose.axes.T, -1, 0)


def _print_cells(on_board: Points, board: Board) -> tuple[Light, Light]:
    """Part of each cell that the sheet covers, and the sheet's light in it.

    Inside a pixel, board coordinates are linear in the picture to better than a thousandth of a pixel.
    """
    columns, rows = board.squares
    x = _with_slopes(on_board[0] / board.true_square_mm + columns / 2)
    y = _with_slopes(rows / 2 - on_board[1] / board.true_square_mm)
    sheet = np.empty((CELLS * x.shape[1], CELLS * x.shape[2]), np.float32)
    light = np.empty_like(sheet)
    _print(x, y, board.squares, sheet, light)
    return sheet, light


def _with_slopes(coordinate: Points) -> Light:
    """A board coordinate, in squares, and its slopes down and to the right, shape (3, rows, columns)."""
    centre = coordinate.astype(np.float32)
    return np.stack([centre, *np.gradient(centre)]).astype(np.float32)


# Compiled loops: cell after cell, without a temporary picture of cells.


@njit(nogil=True, cache=True)
def _print(x: Light, y: Light, squares: tuple[int, int], sheet: Light, light: Light) -> None:
    columns, rows = squares
    for i in range(x.shape[1]):
        for j in range(x.shape[2]):
            x_width = np.hypot(x[1, i, j], x[2, i, j]) / CELLS
            y_width = np.hypot(y[1, i, j], y[2, i, j]) / CELLS
            for row in range(CELLS):
                down = (row + 0.5) / CELLS - 0.5
                for column in range(CELLS):
                    right = (column + 0.5) / CELLS - 0.5
                    u = x[0, i, j] + x[1, i, j] * down + x[2, i, j] * right
                    v = y[0, i, j] + y[1, i, j] * down + y[2, i, j] * right
                    paper = _between(u, x_width, -1, columns + 1) * _between(v, y_width, -1, rows + 1)
                    black = _between(u, x_width, 0, columns) * _between(v, y_width, 0, rows)
                    black *= (1 + _alternating(u, x_width, columns) * _alternating(v, y_width, rows)) / 2
                    lamp = 1 + LAMP_FALL_PER_SQUARE * (u + v)
                    sheet[CELLS * i + row, CELLS * j + column] = paper
                    light[CELLS * i + row, CELLS * j + column] = lamp * (BLACK * black + WHITE * (paper - black))


@njit(nogil=True, cache=True)
def _between(x: float, width: float, low: float, high: float) -> float:
    """Part of a cell that lies between two lines of the print."""
    return min(max((x - low) / width + 0.5, 0.0), 1.0) * min(max((high - x) / width + 0.5, 0.0), 1.0)


@njit(nogil=True, cache=True)
def _alternating(x: float, width: float, squares: int) -> float:
    """1 in the first, -1 in the second square and so on, and between them where a line crosses a cell.

    The pattern's outer lines are left to `_between`; the first square is black, a margin of one square is white.
    """
    line = min(max(round(x), 1), squares - 1)
    side = -1.0 if line % 2 else 1.0
    return side * min(max(2 * (x - line) / width, -1.0), 1.0)


def _collected(cells: Light, blur: Blur) -> Light:
    """Light of pixels whose cells are seen through the lens."""
    core_px = math.sqrt(blur.core_px**2 - APERTURE_VARIANCE_PX2)
    size = (cells.shape[1] // CELLS, cells.shape[0] // CELLS)
    core = cv2.resize(cv2.GaussianBlur(cells, (0, 0), CELLS * core_px), size, interpolation=cv2.INTER_AREA)
    halo = cv2.GaussianBlur(core, (0, 0), blur.halo_px)
    return np.asarray(core + blur.halo_part * (halo - core), np.float32)
