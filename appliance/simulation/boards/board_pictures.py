"""Pictures of checkerboards on the line, through the true lens, for `hotgauge calibrate`."""

import math
from collections.abc import Iterator

import cv2
import numpy as np

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
    x, x_width = _cells(on_board[0] / board.true_square_mm + columns / 2)
    y, y_width = _cells(rows / 2 - on_board[1] / board.true_square_mm)
    sheet = _between(x, x_width, -1, columns + 1) * _between(y, y_width, -1, rows + 1)
    pattern = _between(x, x_width, 0, columns) * _between(y, y_width, 0, rows)
    black = pattern * (1 + _alternating(x, x_width, columns) * _alternating(y, y_width, rows)) / 2
    light = (1 + LAMP_FALL_PER_SQUARE * (x + y)) * (BLACK * black + WHITE * (sheet - black))
    return sheet.astype(np.float32), light.astype(np.float32)


def _cells(coordinate: Points) -> tuple[Light, Light]:
    """A board coordinate, in squares, at the middle of each cell, and by how much it changes over a cell."""
    centre = coordinate.astype(np.float32)
    down, right = (np.asarray(slope, np.float32) for slope in np.gradient(centre))
    steps = (np.arange(CELLS, dtype=np.float32) + np.float32(0.5)) / CELLS - np.float32(0.5)
    inside = down[:, None, :, None] * steps[:, None, None] + right[:, None, :, None] * steps
    size = (CELLS * centre.shape[0], CELLS * centre.shape[1])
    width = (np.hypot(down, right) / CELLS).repeat(CELLS, axis=0).repeat(CELLS, axis=1)
    return np.asarray(centre[:, None, :, None] + inside, np.float32).reshape(size), np.asarray(width, np.float32)


def _between(x: Light, width: Light, low: float, high: float) -> Light:
    """Part of each cell that lies between two lines of the print."""
    covered = np.clip((x - low) / width + 0.5, 0, 1) * np.clip((high - x) / width + 0.5, 0, 1)
    return covered.astype(np.float32, copy=False)


def _alternating(x: Light, width: Light, squares: int) -> Light:
    """1 in the first, -1 in the second square and so on, and between them where a line crosses a cell.

    The pattern's outer lines are left to `_between`; the first square is black, a margin of one square is white.
    """
    line = np.clip(np.rint(x), 1, squares - 1)
    return (1 - 2 * (line % 2)) * np.clip(2 * (x - line) / width, -1, 1)


def _collected(cells: Light, blur: Blur) -> Light:
    """Light of pixels whose cells are seen through the lens."""
    core_px = math.sqrt(blur.core_px**2 - APERTURE_VARIANCE_PX2)
    size = (cells.shape[1] // CELLS, cells.shape[0] // CELLS)
    core = cv2.resize(cv2.GaussianBlur(cells, (0, 0), CELLS * core_px), size, interpolation=cv2.INTER_AREA)
    halo = cv2.GaussianBlur(core, (0, 0), blur.halo_px)
    return np.asarray(core + blur.halo_part * (halo - core), np.float32)
