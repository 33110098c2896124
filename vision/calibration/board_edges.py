"""Pixels along the edges between a board's squares: how far each lies from its edge, towards the white side."""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.checkerboard import Board
from vision.geometry.camera import Camera
from vision.sent_picture import Codes, SentPicture

Array = NDArray[np.float64]
Index = NDArray[np.int64]

REACH_PX = 5.5  # to either side of an edge
REACH_OF_SQUARE = 0.45  # at most: the middle of a square belongs to no edge
END_OF_SQUARE = 0.12  # next to the corners pixels are left out
BORDER_PX = 2
INSIDE_PX = 4.0  # from a square's edges: behind the blur
REACH_OF_NOISE_PX = 5


class Noise(NamedTuple):
    """Second differences of code values inside squares, in which nothing smooth is left, but noise.

    Attributes
    ----------
    triples : float
        Of pixels in a row or column.
    next_to_square, apart_square : float
        Sums of squares of c(x - d) - 2 c(x) + c(x + d), d being 1 and 2 pixels, over those triples.
    """

    triples: float
    next_to_square: float
    apart_square: float


NO_NOISE = Noise(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class BoardEdges:
    """Pixels near the inner edges of one board picture, n of them.

    Attributes
    ----------
    code : ndarray of int64, shape (n,)
        Code value as it was sent.
    distance_px : ndarray of float64, shape (n,)
        From the edge, positive on the white square.
    segment : ndarray of int64, shape (n,)
        Number of the edge between two squares.
    upright : ndarray of bool, shape (n,)
        Whether the edge runs along the board's short side.
    px_per_mm : ndarray of float64, shape (n,)
        Across the edge, on the board.
    noise : Noise
        Inside the squares.
    """

    code: Index
    distance_px: Array
    segment: Index
    upright: NDArray[np.bool_]
    px_per_mm: Array
    noise: Noise = NO_NOISE


def board_edges(picture: SentPicture, camera: Camera, corners_px: Array, board: Board) -> BoardEdges:
    """Pixels near the edges between the squares of a board.

    The corners place all edges at once, through the lens: four squares that meet are symmetric about their corner
    under any response, so what the response does to an edge does not move them.

    Parameters
    ----------
    picture : SentPicture
        Of the board; grey and luma as they are, green of colours and of mosaics.
    camera : Camera
        Calibrated.
    corners_px : ndarray of float64, shape (n, 2)
        Inner corners (x, y) in the order of `Board.corners_mm`.
    board : Board

    Returns
    -------
    BoardEdges
    """
    columns, rows = board.inner_corners
    first = np.maximum(np.floor(corners_px.min(axis=0)).astype(int) - BORDER_PX, 0)
    last = np.minimum(np.ceil(corners_px.max(axis=0)).astype(int) + BORDER_PX + 1, picture.size)
    x, y = np.meshgrid(np.arange(first[0], last[0]), np.arange(first[1], last[1]))
    on_board = _in_squares(np.stack([x, y], axis=-1), camera, corners_px, board)
    code = _one_channel(picture)[first[1] : last[1], first[0] : last[0]].astype(np.int64)
    counts = _counting(picture, x, y)
    upright, lying = (
        _of_one_direction(across, along, counts, size)
        for across, along, size in ((*on_board, (columns, rows)), (*on_board[::-1], (rows, columns)))
    )
    away_px, px_per_square = (np.concatenate([upright[k], lying[k]]).astype(np.float64) for k in (1, 3))
    at, segment = (np.concatenate([upright[k], lying[k]]).astype(np.int64) for k in (0, 2))
    code = code.ravel()[at]
    white_side = float(np.sign((code - code.mean()) @ away_px)) if len(code) else 1.0
    return BoardEdges(
        code=code,
        distance_px=white_side * away_px,
        segment=segment + np.repeat([0, columns * rows], [len(upright[0]), len(lying[0])]),
        upright=np.repeat([True, False], [len(upright[0]), len(lying[0])]),
        px_per_mm=px_per_square / board.square_mm,
        noise=_noise_of(picture, first, last, on_board),
    )


def _one_channel(picture: SentPicture) -> Codes:
    """Grey, luma, the mosaic, or green."""
    return picture.measured[:, :, picture.measured.shape[2] // 2]


def _counting(picture: SentPicture, x: Index, y: Index) -> NDArray[np.bool_]:
    """Pixels that are of the one channel: all, or a mosaic's green sites."""
    if picture.coding.mosaic is None:
        return np.ones(x.shape, dtype=bool)
    green = [site for site, colour in enumerate(picture.coding.mosaic) if colour == "G"]
    return np.isin(2 * (y % 2) + x % 2, green)


def _noise_of(picture: SentPicture, first: Index, last: Index, on_board: Array) -> Noise:
    """Noise inside the squares; none of a mosaic, whose neighbours have other colours."""
    if picture.coding.mosaic is not None or min(on_board.shape[1:]) < REACH_OF_NOISE_PX:
        return NO_NOISE
    code = _one_channel(picture)[first[1] : last[1], first[0] : last[0]].astype(np.float64)
    from_edge_px = [(0.5 - np.abs(one - np.floor(one) - 0.5)) / np.hypot(*np.gradient(one)) for one in on_board]
    inside = np.minimum(*from_edge_px) > INSIDE_PX
    total = np.zeros(len(NO_NOISE))
    for values, there in ((code, inside), (code.T, inside.T)):
        middle = values[2:-2]
        next_to, apart = values[1:-3] - 2 * middle + values[3:-1], values[:-4] - 2 * middle + values[4:]
        within = there[:-4] & there[2:-2] & there[4:]
        total += [np.count_nonzero(within), np.sum(next_to[within] ** 2), np.sum(apart[within] ** 2)]
    return Noise(*total.tolist())


def _in_squares(pixel: Index, camera: Camera, corners_px: Array, board: Board) -> Array:
    """Where pixels lie on the board, in squares from the first corner along both sides, shape (2, rows, columns)."""
    columns, rows = board.inner_corners
    to_board, _ = cv2.findHomography(camera.undistort(corners_px), board.corners_mm[:, :2])
    ideal = camera.undistort(pixel.reshape(-1, 2).astype(np.float64))
    at = np.column_stack([ideal, np.ones(len(ideal))]) @ np.asarray(to_board, dtype=np.float64).T
    mm = (at[:, :2] / at[:, 2:]).T.reshape(2, *pixel.shape[:2])
    return np.stack([(columns - 1) / 2 + mm[0] / board.square_mm, (rows - 1) / 2 - mm[1] / board.square_mm])


def _of_one_direction(
    across: Array, along: Array, counts: NDArray[np.bool_], corners: tuple[int, int]
) -> tuple[Index, Array, Index, Array]:
    """Pixels near all lines of one direction: their number, distance, segment and the pixels in a square there.

    Distances are positive towards the squares of one colour.
    """
    down, right = np.gradient(across)
    squares_per_px = np.hypot(down, right)
    line, cell = np.clip(np.rint(across), 0, corners[0] - 1), np.floor(along)
    away_px = (across - line) / squares_per_px
    inside = (cell >= 0) & (cell < corners[1] - 1) & (np.abs(along - cell - 0.5) < 0.5 - END_OF_SQUARE)
    near = np.abs(away_px) < np.minimum(REACH_PX, REACH_OF_SQUARE / squares_per_px)
    at = np.flatnonzero(inside & near & counts)
    side = np.where((line + cell) % 2 == 0, 1.0, -1.0)
    of = (values.ravel()[at] for values in (side * away_px, line * corners[1] + cell, 1 / squares_per_px))
    away, segment, px_per_square = of
    return at, away, segment.astype(np.int64), px_per_square
