"""Whether a picture of the board is good for a calibration, and what the poses so far still lack.

For people who take pictures: a pose is refused before it is stored, and what is missing is said while the board is
still in their hands. What decides whether a calibration is good stays with `acceptance`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.acceptance import covered_share
from vision.calibration.checkerboard import Board
from vision.calibration.corners import find_corners
from vision.light import CLIPPED_CODE
from vision.pictures import grey
from vision.sent_picture import SentPicture

Array = NDArray[np.float64]

# All chosen. A lens that is in focus gives edges 1.7 to 2.4 px wide (simulated mill and path-traced boards).
EDGE_WIDTH_MOST_PX = 4.0
CLIPPED_MOST_SHARE = 0.02  # of the white squares: a clipped white moves the edges of the black ones
CONTRAST_LEAST = 0.15  # of full scale, between white and black squares
STILL_PX = 0.3  # mean way of the corners from one picture to the next
NEW_SQUARES = 0.5  # mean way of the corners from any earlier pose, in squares: closer ones teach little
PROFILE_REACH = 0.4  # of a square, to either side of an edge
PROFILE_STEP_PX = 0.25
FOCAL_RANGE = (0.3, 20.0)  # of the picture's width: a guess of the focal length beyond it is none
USUAL_FOCAL = 1.2  # of the picture's width, where the poses give no guess
PARTS = 3  # the picture's corners are its outer thirds


class BoardPicture(NamedTuple):
    """The board in one picture.

    Attributes
    ----------
    corners_px : ndarray of float64, shape (n, 2), or None
        (x, y), pixels, in the order of `Board.corners_mm`; None where no board was found.
    trouble : str
        Why the picture is not good; empty where it is.
    edge_width_px : float
        Contrast over steepest slope across the squares' edges, in the direction that is blurred more; NaN without
        a board.
    """

    corners_px: Array | None
    trouble: str
    edge_width_px: float


def judge_board(picture: SentPicture, board: Board) -> BoardPicture:
    """Find the board in a picture, quickly, and judge sharpness and exposure.

    Parameters
    ----------
    picture : SentPicture
    board : Board

    Returns
    -------
    BoardPicture
    """
    found = find_corners(picture, board, quick=True)
    if found.corners_px is None:
        return BoardPicture(None, found.reason, math.nan)
    pixels = grey(picture.shown)
    light, dark = _squares(pixels, found.corners_px, board)
    width_px = _edge_width_px(pixels, found.corners_px, board)
    clipped = float(np.mean(light >= CLIPPED_CODE))
    contrast = float(np.median(light) - np.median(dark)) / 255
    trouble = ""
    if clipped > CLIPPED_MOST_SHARE:
        trouble = f"overexposed, {100 * clipped:.0f} % of the white squares: expose for a shorter time"
    elif contrast < CONTRAST_LEAST:
        trouble = (
            f"white and black differ by {100 * contrast:.0f} % of full light only: more light, or a longer exposure"
        )
    elif not width_px <= EDGE_WIDTH_MOST_PX:
        trouble = f"blurred, edges {width_px:.1f} px wide: focus, and hold the board still"
    return BoardPicture(found.corners_px, trouble, width_px)


def mean_way_px(corners_px: Array, before_px: Array) -> float:
    """Mean distance of the corners of two pictures of one camera, pixels.

    Parameters
    ----------
    corners_px, before_px : ndarray of float64, shape (n, 2)
    """
    return float(np.mean(np.linalg.norm(corners_px - before_px, axis=1)))


def is_new(corners_px: Array, poses: Sequence[Array]) -> bool:
    """Whether a pose differs from all earlier ones of this camera.

    Parameters
    ----------
    corners_px : ndarray of float64, shape (n, 2)
    poses : sequence of ndarray
        Corners of the earlier ones.
    """
    least_px = NEW_SQUARES * float(np.linalg.norm(corners_px[1] - corners_px[0]))
    return all(mean_way_px(corners_px, before_px) >= least_px for before_px in poses)


@dataclass(frozen=True, slots=True)
class Seen:
    """What the poses of one camera show so far.

    Attributes
    ----------
    covered_share : float
        Part of the picture inside the convex hull of all corners.
    tilt_deg : float
        Largest angle between two boards, with a guess of the focal length.
    missing : tuple of str
        Corners of the picture in which no board was.
    """

    covered_share: float
    tilt_deg: float
    missing: tuple[str, ...]


def seen_so_far(poses: Sequence[Array], image_size: tuple[int, int], board: Board) -> Seen:
    """What the poses of one camera show so far.

    Parameters
    ----------
    poses : sequence of ndarray of float64, shape (n, 2)
        Corners of each pose.
    image_size : tuple of int
        (columns, rows), pixels.
    board : Board
    """
    if not poses:
        return Seen(0.0, 0.0, tuple(_CORNERS))
    points = np.concatenate(poses)
    return Seen(covered_share(points, image_size), _tilt_deg(poses, image_size, board), _missing(points, image_size))


_CORNERS = {"upper left": (0, 0), "upper right": (1, 0), "lower left": (0, 1), "lower right": (1, 1)}


def _missing(points: Array, image_size: tuple[int, int]) -> tuple[str, ...]:
    thirds = np.floor(PARTS * points / image_size)
    last = PARTS - 1
    return tuple(
        name
        for name, (right, lower) in _CORNERS.items()
        if not np.any((thirds[:, 0] == last * right) & (thirds[:, 1] == last * lower))
    )


def _tilt_deg(poses: Sequence[Array], image_size: tuple[int, int], board: Board) -> float:
    matrix = _camera_matrix(poses, image_size, board)
    normals: list[Array] = []
    for corners_px in poses:
        solved, turn, _ = cv2.solvePnP(board.corners_mm, corners_px, matrix, np.zeros(5))
        if solved:
            normals.append(np.asarray(cv2.Rodrigues(turn)[0], np.float64)[:, 2])
    if not normals:
        return 0.0
    directions = np.array(normals)
    return float(np.degrees(np.arccos(np.clip((directions @ directions.T).min(), -1.0, 1.0))))


def _camera_matrix(poses: Sequence[Array], image_size: tuple[int, int], board: Board) -> Array:
    """Camera matrix by Zhang's closed form, or that of a usual lens where the poses do not give it."""
    points = board.corners_mm.astype(np.float32)
    matrix = np.asarray(
        cv2.initCameraMatrix2D([points] * len(poses), [pose.astype(np.float32) for pose in poses], image_size),
        np.float64,
    )
    least, most = (share * image_size[0] for share in FOCAL_RANGE)
    if least < matrix[0, 0] < most:
        return matrix
    focal_px = USUAL_FOCAL * image_size[0]
    middle = (np.array(image_size) - 1) / 2
    return np.array([[focal_px, 0.0, middle[0]], [0.0, focal_px, middle[1]], [0.0, 0.0, 1.0]])


def _grid(corners_px: Array, board: Board) -> Array:
    columns, rows = board.inner_corners
    return corners_px.reshape(rows, columns, 2)


def _squares(pixels: NDArray[np.uint8], corners_px: Array, board: Board) -> tuple[Array, Array]:
    """Pixel values in the middle of the light squares, and of the dark ones."""
    grid = _grid(corners_px, board)
    middles = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4
    half = max(1, int(np.linalg.norm(np.diff(grid, axis=1), axis=2).min() / 6))
    size = (2 * half + 1, 2 * half + 1)
    patches = np.array(
        [cv2.getRectSubPix(pixels, size, (float(x), float(y))) for x, y in middles.reshape(-1, 2)], np.float64
    )
    even = np.add.outer(np.arange(middles.shape[0]), np.arange(middles.shape[1])).ravel() % 2 == 0
    first, second = patches[even].ravel(), patches[~even].ravel()
    return (first, second) if np.median(first) > np.median(second) else (second, first)


def _edge_width_px(pixels: NDArray[np.uint8], corners_px: Array, board: Board) -> float:
    """Contrast over steepest slope across the edges of the squares, in the direction that is blurred more."""
    grid = _grid(corners_px, board)
    return max(_width_across_px(pixels, grid), _width_across_px(pixels, grid.transpose(1, 0, 2)))


def _width_across_px(pixels: NDArray[np.uint8], grid: Array) -> float:
    """Median over the edges between neighbours in a row of the grid."""
    edges = np.diff(grid, axis=1)
    middles = (grid[:, 1:] + grid[:, :-1]) / 2
    lengths = np.linalg.norm(edges, axis=2)
    reach_px = PROFILE_REACH * float(lengths.min())
    across = np.stack([-edges[..., 1], edges[..., 0]], axis=2) / lengths[..., None]
    steps = np.arange(-reach_px, reach_px, PROFILE_STEP_PX)
    places = (middles[:, :, None] + across[:, :, None] * steps[:, None]).reshape(-1, len(steps), 2).astype(np.float32)
    profiles = cv2.remap(pixels.astype(np.float32), places[..., 0], places[..., 1], cv2.INTER_LINEAR)
    # over one pixel: shorter differences would take noise for slope
    span = round(1 / PROFILE_STEP_PX)
    slopes = np.abs(profiles[:, span:] - profiles[:, :-span]).max(axis=1)
    contrast = np.abs(profiles[:, :span].mean(axis=1) - profiles[:, -span:].mean(axis=1))
    return float(np.median(contrast / np.maximum(slopes, 1e-9)))
