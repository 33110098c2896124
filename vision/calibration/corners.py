"""Finding the board's inner corners in a picture, to a few hundredths of a pixel."""

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.checkerboard import Board
from vision.pictures import grey
from vision.sent_picture import Codes, SentPicture

# Half side of the refinement's window over a square's side, and its smoothing, found by trial on path-traced boards of
# 28 to 100 pixels a square: residual 0.032 px, against 0.057 px with a window of a tenth of one. Decoding to linear
# light first makes it 0.043 px: a crossing of four squares is symmetric about its centre under any response, and the
# noise of bright pixels grows.
WINDOW_SHARE = 0.4
SMOOTHING_PX = 1.0

IRREGULAR_SHARE = 0.15  # chosen: corners off a homography by 15 % of a square (RMS) or more are no board's
SQUARE_PATCH_PX = 16  # chosen: pixels of a square when its lightness is averaged


class Found(NamedTuple):
    """Corners of one picture, or why there are none.

    Attributes
    ----------
    corners_px : ndarray of float64, shape (n, 2), or None
        (x, y), pixels, in the order of `Board.corners_mm`.
    reason : str
        Empty where there are corners.
    """

    corners_px: NDArray[np.float64] | None
    reason: str


def find_corners(image: SentPicture | Codes, board: Board, *, quick: bool = False) -> Found:
    """Find all inner corners of the board.

    OpenCV's classic detector and its sector-based one propose grids, the quick one first, until one holds: its
    corners are regular under a homography, and its squares are light and dark in turn. The first corner is that at
    the dark square of the board's corner; among orders that the colours do not tell apart, x along the long side (or
    along a side, where they are equal) points most to the right of the picture.

    Parameters
    ----------
    image : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
        Corners are found in 8 bits and located in the code values as they were sent.
    board : Board
    quick : bool
        Give up where the first detector finds no board, as a live picture wants it.

    Returns
    -------
    Found
        Without corners where no detector finds a grid, or where no grid found is regular and light and dark in
        turn; the reason says which.

    Raises
    ------
    ValueError
        `image` is not a picture of 8 or 16 bit.
    """
    picture = SentPicture.of(image)
    pixels = grey(picture.shown)
    fine = _fine_grey(picture)
    columns, rows = board.inner_corners
    reason = f"no board of {columns} x {rows} inner corners found"
    for grid in _quick_proposals(pixels, board) if quick else _proposals(pixels, board):
        if not _is_inside(grid, pixels):
            reason = "a grid was found, but it reaches beyond the picture"
            continue
        refined = _refined(fine, _right_handed(grid, board), board)
        reason = _fault(pixels, refined, board)
        if not reason:
            return Found(_ordered(pixels, refined, board), "")
    return Found(None, reason)


def _quick_proposals(pixels: NDArray[np.uint8], board: Board) -> Iterator[NDArray[np.float64]]:
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
    found, corners = cv2.findChessboardCorners(pixels, board.inner_corners, flags=flags)
    if found:
        yield corners.reshape(-1, 2).astype(np.float64)


def _proposals(pixels: NDArray[np.uint8], board: Board) -> Iterator[NDArray[np.float64]]:
    size = board.inner_corners
    for flags in (cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE, 0):
        found, corners = cv2.findChessboardCorners(pixels, size, flags=flags)
        if found:
            yield corners.reshape(-1, 2).astype(np.float64)
    for flags in (cv2.CALIB_CB_NORMALIZE_IMAGE, cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY):
        found, corners = cv2.findChessboardCornersSB(pixels, size, flags=flags)
        if found:
            yield corners.reshape(-1, 2).astype(np.float64)


def _is_inside(corners: NDArray[np.float64], pixels: NDArray[np.uint8]) -> bool:
    """Whether all corners of a proposal lie in the picture, no two at one place."""
    inside = (corners >= 0.0) & (corners <= np.array(pixels.shape[::-1]) - 1.0)
    return bool(inside.all()) and len(np.unique(corners, axis=0)) == len(corners)


def _right_handed(corners: NDArray[np.float64], board: Board) -> NDArray[np.float64]:
    """Reverse each row of a mirrored grid, so that the board's face looks at the camera."""
    columns, rows = board.inner_corners
    grid = corners.reshape(rows, columns, 2)
    along, down = grid[:, -1] - grid[:, 0], grid[-1] - grid[0]
    x, y = along.mean(axis=0), down.mean(axis=0)
    mirrored = x[0] * y[1] - x[1] * y[0] < 0.0
    return (grid[:, ::-1] if mirrored else grid).reshape(-1, 2)


def _fine_grey(picture: SentPicture) -> NDArray[np.float32]:
    """Code values as they were sent, grey; colours and mosaics as they are shown unless they have more than 8 bits."""
    codes = picture.measured
    if codes.shape[2] == 1 and picture.coding.mosaic is None:
        return codes[:, :, 0].astype(np.float32)
    if codes.shape[2] == 3 and picture.coding.bits > 8:
        return np.asarray(cv2.cvtColor(codes, cv2.COLOR_BGR2GRAY), np.float32)
    return grey(picture.shown).astype(np.float32)


def _refined(pixels: NDArray[np.float32], corners: NDArray[np.float64], board: Board) -> NDArray[np.float64]:
    half = max(2, round(WINDOW_SHARE * _square_px(corners, board)))
    smooth = cv2.GaussianBlur(pixels, (0, 0), SMOOTHING_PX)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-4)
    start = corners.astype(np.float32).reshape(-1, 1, 2)
    return cv2.cornerSubPix(smooth, start, (half, half), (-1, -1), criteria).reshape(-1, 2).astype(np.float64)


def _square_px(corners: NDArray[np.float64], board: Board) -> float:
    """Shortest side of a square in the picture."""
    columns, rows = board.inner_corners
    grid = corners.reshape(rows, columns, 2)
    along, down = np.diff(grid, axis=1), np.diff(grid, axis=0)
    return float(min(np.linalg.norm(along, axis=2).min(), np.linalg.norm(down, axis=2).min()))


def _fault(pixels: NDArray[np.uint8], corners: NDArray[np.float64], board: Board) -> str:
    """Say why a grid is false; empty where it is not."""
    to_picture = _homography(corners, board)
    if to_picture is None:
        return "a grid was found, but its corners lie on one line"
    mapped = cv2.perspectiveTransform(board.corners_mm[:, None, :2], to_picture).reshape(-1, 2)
    residual = float(np.sqrt(np.mean(np.sum((mapped - corners) ** 2, axis=1)))) / _square_px(corners, board)
    if not residual < IRREGULAR_SHARE:
        return f"a grid was found, but it is not regular ({100.0 * residual:.0f} % of a square)"
    if not _alternates(_lightness(pixels, to_picture, board)):
        return "a grid was found, but its squares are not light and dark in turn"
    return ""


def _lightness(pixels: NDArray[np.uint8], to_picture: NDArray[np.float64], board: Board) -> NDArray[np.float64]:
    """Mean pixel value of the middle of each square between the corners, shape (rows, columns)."""
    columns, rows = (count - 1 for count in board.inner_corners)
    scale = board.square_mm / SQUARE_PATCH_PX
    first = board.corners_mm[0]
    from_patch = np.array(
        [[scale, 0.0, first[0] + scale / 2.0], [0.0, -scale, first[1] - scale / 2.0], [0.0, 0.0, 1.0]]
    )
    patch = cv2.warpPerspective(
        pixels,
        to_picture @ from_patch,
        (columns * SQUARE_PATCH_PX, rows * SQUARE_PATCH_PX),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
    )
    middle = slice(SQUARE_PATCH_PX // 4, -SQUARE_PATCH_PX // 4)
    return patch.reshape(rows, SQUARE_PATCH_PX, columns, SQUARE_PATCH_PX)[:, middle, :, middle].mean(axis=(1, 3))


def _alternates(light: NDArray[np.float64]) -> bool:
    """Whether each square is lighter than all its neighbours or darker than all of them, in turn."""
    rows, columns = light.shape
    sign = (-1.0) ** np.add.outer(np.arange(rows), np.arange(columns))
    along, down = np.diff(light, axis=1) * sign[:, 1:], np.diff(light, axis=0) * sign[1:]
    steps = np.concatenate([along.ravel(), down.ravel()])
    return bool((steps > 0.0).all() or (steps < 0.0).all())


def _ordered(pixels: NDArray[np.uint8], corners: NDArray[np.float64], board: Board) -> NDArray[np.float64]:
    orders = [board.turned(corners, turn) for turn in board.grid_turns]
    if board.hidden_turns != board.grid_turns:
        orders = [order for order in orders if _begins_dark(pixels, order, board)] or orders
    return max(orders, key=lambda order: _to_the_right(order, board))


def _begins_dark(pixels: NDArray[np.uint8], corners: NDArray[np.float64], board: Board) -> bool:
    to_picture = _homography(corners, board)
    if to_picture is None:
        return False
    light = _lightness(pixels, to_picture, board)
    return bool(light[0, 0] < light[0, 1])


def _to_the_right(corners: NDArray[np.float64], board: Board) -> float:
    """Cosine between the board's x and the picture's."""
    along = corners[board.inner_corners[0] - 1] - corners[0]
    return float(along[0] / np.linalg.norm(along))


def _homography(corners: NDArray[np.float64], board: Board) -> NDArray[np.float64] | None:
    matrix, _ = cv2.findHomography(board.corners_mm[:, :2], corners)
    return None if matrix is None else np.asarray(matrix, dtype=np.float64)
