"""First guess of a rig: each camera by Zhang's method, then the pose between them that most boards agree on."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from vision.calibration.checkerboard import Board
from vision.calibration.rig import SIDES
from vision.geometry.camera import Camera, rotation

QUARTER_TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # of `Board.turned`
LOW, HIGH = "low", "high"
# chosen, radians and parts of the distance: poses of one board by each camera alone agree to a few hundredths
APART_MOST = 0.2
LENGTH_DECIMALS = 3  # chosen: pixels and mm; OpenCV's threads change the ninth, the adjustment finds all of them
RATIO_DECIMALS = 6  # chosen: radians and distortion; the same, of the eleventh


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One picture of the board.

    Attributes
    ----------
    side : int
        0 left camera, 1 right camera.
    board : str
        Name of the board's pose, common to both cameras: "00", "01", ..., "low", "high".
    corners_px : ndarray of float64, shape (n, 2)
        (x, y), pixels, in the order of `Board.corners_mm`.
    """

    side: int
    board: str
    corners_px: NDArray[np.float64]

    @property
    def name(self) -> str:
        """Name of the picture, as its file is named."""
        return f"{SIDES[self.side]}_{self.board}"

    def turned(self, quarter_turns: int, board: Board) -> "View":
        """Return the view of the same board after quarter turns about its normal.

        Parameters
        ----------
        quarter_turns : int
            Of `Board.grid_turns`.
        board : Board
        """
        return replace(self, corners_px=board.turned(self.corners_px, quarter_turns))


class Pose(NamedTuple):
    """x_to = R x_from + t, mm."""

    R: NDArray[np.float64]
    t: NDArray[np.float64]

    def after(self, first: "Pose") -> "Pose":
        """Pose that does `first`, then this one."""
        return Pose(self.R @ first.R, self.R @ first.t + self.t)

    def inverse(self) -> "Pose":
        """Pose back."""
        return Pose(self.R.T, -self.R.T @ self.t)

    def turned(self, quarter_turns: int) -> "Pose":
        """Pose of the same board after quarter turns about its normal."""
        return Pose(self.R @ np.linalg.matrix_power(QUARTER_TURN, quarter_turns % 4), self.t)


class OneCamera(NamedTuple):
    """Calibration from one camera's pictures alone: the camera at the origin, and each board's pose before it."""

    camera: Camera
    poses: dict[str, Pose]
    misfits: list[View]


class Relative(NamedTuple):
    """Right camera as the left one sees it.

    Attributes
    ----------
    pose : Pose
        Left camera to right camera.
    turned : dict of str to int
        Quarter turns by which a board's corners are ordered otherwise in the right picture.
    apart : list of str
        Boards that both saw and that give another pose, by more than `APART_MOST`.
    """

    pose: Pose
    turned: dict[str, int]
    apart: list[str]


@dataclass(frozen=True, slots=True, eq=False)
class Guess:
    """A first guess of everything, in the world frame of `guess`.

    Attributes
    ----------
    cameras : tuple of Camera
        Left, right.
    boards : dict of str to Pose
        Board to world.
    views : list of View
        The views that the guess uses, their corners in orders that fit together.
    misfits : list of View
        The views left out.
    apart : list of str
        Boards that did not stand still between their two pictures, or were not of one moment.
    """

    cameras: tuple[Camera, Camera]
    boards: dict[str, Pose]
    views: list[View]
    misfits: list[View]
    apart: list[str]


def guess(views: Sequence[View], board: Board, image_size: tuple[int, int]) -> Guess:
    """Guess cameras and boards in the world frame.

    The low board is the world's frame: its centre, projected to z = 0, the origin; x along its long side, to the
    right in the left picture; z towards the cameras. Without a low board the world is the left camera's frame.

    Parameters
    ----------
    views : sequence of View
        Of both cameras; some boards in common.
    board : Board
    image_size : tuple of int
        (columns, rows).

    Returns
    -------
    Guess
    """
    left, right = (calibrate_one([v for v in views if v.side == side], board, image_size) for side in (0, 1))
    misfits = left.misfits + right.misfits
    to_right, turned, apart = relative_pose(left.poses, right.poses, board.hidden_turns)

    from_right = to_right.inverse()
    boards = {name: from_right.after(pose.turned(turned.get(name, 0))) for name, pose in right.poses.items()}
    boards |= left.poses
    straight = _straightened(boards, board)
    boards |= {name: boards[name].turned(turn) for name, turn in straight.items()}
    kept = [
        view.turned((straight.get(view.board, 0) + (turned.get(view.board, 0) if view.side else 0)) % 4, board)
        for view in views
        if view not in misfits
    ]

    to_left = Pose(np.eye(3), np.zeros(3))
    if LOW in boards:
        to_left = boards[LOW].after(Pose(np.eye(3), np.array([0.0, 0.0, -(board.low_mm or 0.0)])))
    to_right = to_right.after(to_left)
    return Guess(
        cameras=(
            replace(left.camera, R=to_left.R, t=to_left.t),
            replace(right.camera, R=to_right.R, t=to_right.t),
        ),
        boards={name: to_left.inverse().after(pose) for name, pose in boards.items()},
        views=kept,
        misfits=misfits,
        apart=apart,
    )


def _straightened(boards: Mapping[str, Pose], board: Board) -> dict[str, int]:
    """Quarter turns after which x of the low board points most to the right, and x of the high board with it."""
    straight: dict[str, int] = {}
    x = np.array([1.0, 0.0, 0.0])
    for name in (LOW, HIGH):
        if name in boards:
            straight[name] = max(board.grid_turns, key=lambda turn: float(boards[name].turned(turn).R[:, 0] @ x))
            x = boards[name].turned(straight[name]).R[:, 0]
    return straight


def calibrate_one(views: Sequence[View], board: Board, image_size: tuple[int, int]) -> OneCamera:
    """Calibrate one camera (Zhang 2000, doi:10.1109/34.888718), leaving out pictures that cannot be of the board.

    Parameters
    ----------
    views : sequence of View
        All of one camera.
    board : Board
    image_size : tuple of int
        (columns, rows).

    Returns
    -------
    OneCamera
        `misfits` holds the views left out: residual above 1 px and above twice the median.

    Raises
    ------
    cv2.error
        The pictures allow no solution at all.
    """
    kept, misfits = list(views), list[View]()
    while True:
        _, K, dist, omegas, translations, _, _, errors = cv2.calibrateCameraExtended(
            [board.corners_mm.astype(np.float32)] * len(kept),
            [view.corners_px.astype(np.float32) for view in kept],
            image_size,
            np.eye(3),
            np.zeros(5),
            flags=cv2.CALIB_FIX_K3,
            criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 12, 1e-5),  # the adjustment refines it
        )
        worst = int(np.argmax(errors))
        if len(kept) <= 3 or errors[worst, 0] <= max(1.0, 2.0 * float(np.median(errors))):
            break
        misfits.append(kept.pop(worst))
    poses = {
        view.board: Pose(rotation(_rounded(omega, RATIO_DECIMALS)), _rounded(t, LENGTH_DECIMALS))
        for view, omega, t in zip(kept, omegas, translations, strict=True)
    }
    K = _rounded(K, LENGTH_DECIMALS).reshape(3, 3)
    camera = Camera(K, _rounded(dist, RATIO_DECIMALS)[:5], np.eye(3), np.zeros(3), image_size)
    return OneCamera(camera, poses, misfits)


def _rounded(found: ArrayLike, decimals: int) -> NDArray[np.float64]:
    """Numbers of OpenCV's, which adds its threads' sums in any order: rounded, the same pictures give the same rig."""
    return np.round(np.asarray(found, dtype=np.float64).ravel(), decimals)


def relative_pose(left: Mapping[str, Pose], right: Mapping[str, Pose], hidden_turns: Sequence[int]) -> Relative:
    """Find the pose from left to right camera that agrees best with all boards seen by both.

    Of all candidates (one per board and hidden turn) it is the one with the least median distance to the nearest
    candidate of each board, so single wrong pairs have no say.

    Parameters
    ----------
    left, right : mapping of str to Pose
        Board to camera; at least one board in common.
    hidden_turns : sequence of int
        Quarter turns of the board that its colours do not show.

    Returns
    -------
    Relative
    """
    names = [name for name in left if name in right]
    candidates = [[right[name].turned(turn).after(left[name].inverse()) for name in names] for turn in hidden_turns]
    distances = np.array(
        [
            [[_distance(pose, other) for other in row] for row in candidates]
            for pose in (pose for row in candidates for pose in row)
        ]
    )
    best = int(np.argmin(np.median(distances.min(axis=1), axis=1)))
    turned = {
        name: hidden_turns[int(row.argmin())]
        for name, row in zip(names, distances[best].T, strict=True)
        if row.argmin()
    }
    apart = [name for name, row in zip(names, distances[best].T, strict=True) if row.min() > APART_MOST]
    return Relative(candidates[best // len(names)][best % len(names)], turned, apart)


def _distance(one: Pose, other: Pose) -> float:
    """Angle of the rotation between two poses, radians, plus the relative difference of their translations."""
    cosine = (np.trace(one.R @ other.R.T) - 1.0) / 2.0
    length = max(float(np.linalg.norm(one.t)), float(np.linalg.norm(other.t)), 1e-9)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)) + np.linalg.norm(one.t - other.t) / length)


def residual_alone_px(view: View, camera: Camera, board: Board) -> float:
    """Root mean square residual, per coordinate, of a picture whose board may be anywhere before the camera.

    Parameters
    ----------
    view : View
    camera : Camera
    board : Board

    Returns
    -------
    float
        Pixels; infinite when no pose is found.
    """
    found, omega, t = cv2.solvePnP(board.corners_mm, view.corners_px, camera.K, camera.dist)
    if not found:
        return float("inf")
    projected, _ = cv2.projectPoints(board.corners_mm, omega, t, camera.K, camera.dist)
    return float(np.sqrt(np.mean((projected.reshape(-1, 2) - view.corners_px) ** 2)))
