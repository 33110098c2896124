"""Checkerboards held before the cameras, the fast way: true corners projected, detector noise added."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from appliance.simulation.response import Response
from appliance.simulation.true_rig import Points, TrueRig

Corners = tuple[Points, Points]

MARGIN_PX = 12.0
TRIES = 5_000
TILT_DEG = 35.0
TURN_DEG = 25.0
LEAST_SQUARE_PX = 9.0
PLACE_MM = ((-400.0, 400.0), (-500.0, 500.0), (0.0, 400.0))


@dataclass(frozen=True, slots=True)
class Board:
    """A checkerboard, and how it is put on the line for the world frame.

    Attributes
    ----------
    squares : tuple of int
        Squares along the long and the short side.
    square_mm, low_mm, high_mm : float
        Nominal side of a square, and heights of the registration boards: what the user writes into `board.json`.
    square_u_mm, height_u_mm : float
        Their standard uncertainties.
    square_error_mm, low_error_mm, high_error_mm : float
        What nobody knows: true value minus nominal value.
    """

    squares: tuple[int, int] = (8, 5)
    square_mm: float = 50.0
    low_mm: float = 0.0
    high_mm: float = 200.0
    square_u_mm: float = 0.01
    height_u_mm: float = 0.1
    square_error_mm: float = 0.0
    low_error_mm: float = 0.0
    high_error_mm: float = 0.0

    @classmethod
    def with_errors(cls, rng: np.random.Generator, square_u_mm: float = 0.01, height_u_mm: float = 0.1) -> Self:
        """Board whose errors are drawn from its uncertainties."""
        square, low, high = rng.normal(0, (square_u_mm, height_u_mm, height_u_mm))
        return cls(
            square_u_mm=square_u_mm,
            height_u_mm=height_u_mm,
            square_error_mm=square,
            low_error_mm=low,
            high_error_mm=high,
        )

    @property
    def true_square_mm(self) -> float:
        """Side of a square as printed, mm."""
        return self.square_mm + self.square_error_mm

    def corners_mm(self) -> Points:
        """Inner corners on the board, origin at its centre, shape (n, 2), mm.

        Row by row along the long side (x), first corner at -x +y, next rows towards -y.
        """
        columns, rows = self.squares[0] - 1, self.squares[1] - 1
        row, column = np.mgrid[:rows, :columns].reshape(2, -1)
        in_squares = np.stack([column - (columns - 1) / 2, (rows - 1) / 2 - row], axis=1)
        return in_squares * self.true_square_mm

    def sheet_mm(self) -> Points:
        """Corners of the printed sheet, a margin of one square around the pattern, shape (4, 2), mm."""
        x, y = ((count / 2 + 1) * self.true_square_mm for count in self.squares)
        return np.array([(-x, y), (x, y), (x, -y), (-x, -y)])


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where a board is: world = centre + x e_x + y e_y.

    Attributes
    ----------
    centre_mm : ndarray of float64, shape (3,)
    axes : ndarray of float64, shape (2, 3)
        Unit vectors along the board's long and short side.
    """

    centre_mm: Points
    axes: Points

    def in_world(self, on_board_mm: Points) -> Points:
        """Board points, shape (..., 2), in the world frame, shape (..., 3), mm."""
        return self.centre_mm + on_board_mm @ self.axes


@dataclass(frozen=True, slots=True, eq=False)
class BoardCorners:
    """What a corner detector found on the boards, in pixels (x, y), arrays of shape (n, 2), left and right.

    Attributes
    ----------
    calibration : list of tuple of ndarray
        One pair per pose.
    low, high : tuple of ndarray
        Registration boards.
    """

    calibration: list[Corners]
    low: Corners
    high: Corners


def observe(
    rig: TrueRig, rng: np.random.Generator, board: Board, poses: int = 15, noise_px: float = 0.04
) -> BoardCorners:
    """Corners of boards at random poses and of both registration boards, with detector noise.

    Parameters
    ----------
    rig : TrueRig
    rng : numpy.random.Generator
    board : Board
    poses : int
        Number of poses for the calibration of the cameras.
    noise_px : float
        Standard deviation of each corner coordinate.

    Raises
    ------
    ValueError
        The board does not fit into both pictures of this rig.
    """

    def seen(pose: Pose) -> Corners:
        corners_mm = pose.in_world(board.corners_mm())
        left, right = (camera.project(corners_mm) for camera in rig.cameras)
        return left + rng.normal(0, noise_px, left.shape), right + rng.normal(0, noise_px, right.shape)

    return BoardCorners(
        calibration=[seen(pose) for pose in random_poses(rig, rng, board, poses)],
        low=seen(low_pose(board)),
        high=seen(high_pose(board)),
    )


def low_pose(board: Board) -> Pose:
    """Pose of the low registration board, flat over the origin."""
    return _flat(board.low_mm + board.low_error_mm)


def high_pose(board: Board) -> Pose:
    """Pose of the high registration board."""
    return _flat(board.high_mm + board.high_error_mm)


def random_poses(rig: TrueRig, rng: np.random.Generator, board: Board, count: int) -> list[Pose]:
    """Poses at various places and tilts at which both cameras see the whole sheet.

    Raises
    ------
    ValueError
        The board does not fit into both pictures of this rig.
    """
    poses: list[Pose] = []
    for _ in range(TRIES):
        if len(poses) == count:
            return poses
        pose = _random_pose(rig, rng)
        sheet_mm = pose.in_world(board.sheet_mm())
        if all(_is_seen(camera.project(sheet_mm), camera.image_size, board) for camera in rig.cameras):
            poses.append(pose)
    long, short = board.squares
    raise ValueError(
        f"board: {long} x {short} squares of {board.square_mm:g} mm do not fit into both pictures of the rig"
    )


def _flat(height_mm: float) -> Pose:
    return Pose(np.array([0.0, 0.0, height_mm]), np.array([[1.0, 0, 0], [0, 1.0, 0]]))


def _random_pose(rig: TrueRig, rng: np.random.Generator) -> Pose:
    """A board that faces a point between the cameras, tilted and turned."""
    centre = np.array([rng.uniform(*span) for span in PLACE_MM])
    between = rng.uniform(0.2, 0.8)
    facing = _unit(between * rig.left.centre_mm + (1 - between) * rig.right.centre_mm - centre)
    tilt = np.tan(np.deg2rad(rng.uniform(5, TILT_DEG)))
    normal = _unit(facing + tilt * _perpendicular(facing, rng.uniform(0, 2 * np.pi)))
    long_side = _perpendicular(normal, np.deg2rad(rng.uniform(-TURN_DEG, TURN_DEG)))
    return Pose(centre, np.stack([long_side, np.cross(normal, long_side)]))


def _unit(vector: Points) -> Points:
    return vector / np.linalg.norm(vector)


def _perpendicular(normal: Points, turn: float) -> Points:
    """Unit vector in the plane of `normal`, turned from the world's x axis."""
    x = _unit(np.array([1.0, 0, 0]) - normal[0] * normal)
    return np.cos(turn) * x + np.sin(turn) * np.cross(normal, x)


def _is_seen(sheet_px: Points, image_size: tuple[int, int], board: Board) -> bool:
    """Whether the sheet is inside the picture and its squares are not too small to be detected."""
    inside = (sheet_px >= MARGIN_PX) & (sheet_px <= np.array(image_size) - 1 - MARGIN_PX)
    sides_px = np.linalg.norm(np.roll(sheet_px, -1, axis=0) - sheet_px, axis=1)
    squares = np.tile(np.array(board.squares) + 2, 2)
    return bool(inside.all()) and bool((sides_px / squares > LEAST_SQUARE_PX).all())


def board_document(board: Board, response: Response) -> dict[str, object]:
    """Contents of `board.json`: what the user knows, none of the errors."""
    return {
        "squares": list(board.squares),
        "square_mm": board.square_mm,
        "square_u_mm": board.square_u_mm,
        "low_mm": board.low_mm,
        "high_mm": board.high_mm,
        "height_u_mm": board.height_u_mm,
        "response": response,
    }
