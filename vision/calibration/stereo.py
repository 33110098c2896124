"""Calibration of a rig from the corners that both cameras saw.

Zhang's method per camera and the pose most boards agree on give a first guess; then all corners of all pictures are
adjusted at once, pictures that do not fit are left out, and the covariance of the adjustment becomes the rig's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.acceptance import (
    NOT_OF_ONE_MOMENT,
    CalibrationError,
    Dropped,
    check_height,
    check_moments,
    check_pairs,
    limits,
    mounting_warnings,
)
from vision.calibration.bundle_adjustment import (
    K3,
    N_BOARD,
    N_CAMERA,
    N_RIG,
    POSE,
    Adjusted,
    Problem,
    Scene,
    Sights,
    adjust,
)
from vision.calibration.checkerboard import Assumption, Board
from vision.calibration.initial_guess import HIGH, LOW, Guess, Pose, View, guess, residual_alone_px
from vision.calibration.response import MeasuredResponse
from vision.calibration.rig import BOARD_NAMES, SIDES, Rig
from vision.geometry.camera import rotation
from vision.light import UNKNOWN_RESPONSE

STAND_IN_RISE_MM = 200.0  # from the low board to the high one where no picture and no text tells it

# Corners of one board in the left and in the right picture, each of shape (n, 2), pixels; None where not found.
Pair = tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """One picture that the calibration uses.

    Attributes
    ----------
    side : int
        0 left camera, 1 right camera.
    board : str
        Pose of the board that it shows: "00", "01", ..., "low", "high".
    corners_px : ndarray of float64, shape (n, 2)
        (x, y), pixels.
    errors_px : ndarray of float64, shape (n, 2)
        Residuals: corners minus where the calibration puts them.
    """

    side: int
    board: str
    corners_px: NDArray[np.float64]
    errors_px: NDArray[np.float64]

    @property
    def name(self) -> str:
        """As its file is named: `left_00`, `right_low`, ..."""
        return f"{SIDES[self.side]}_{self.board}"

    @property
    def residual_px(self) -> float:
        """Root mean square of its corners' residuals, per coordinate."""
        return rms(self.errors_px)


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """An accepted rig (camera calibration), and the pictures that it was computed from.

    Attributes
    ----------
    rig : Rig
    pictures : tuple of Picture
        Pictures used.
    dropped : tuple of Dropped
        Pictures not used, and why.
    noise_px : float
        Standard deviation of a corner's coordinate, from the residuals.
    baseline_mm, baseline_u_mm : float
        Distance of the cameras and its standard uncertainty, without the board's scale.
    warnings : tuple of str
        What is doubtful.
    notes : tuple of str
        What is good to know of the pictures, and no doubt.
    measured_response : MeasuredResponse or None
        What the pictures say of the camera's response, whether the rig uses it or a standard; None where too few do.
    """

    rig: Rig
    pictures: tuple[Picture, ...]
    dropped: tuple[Dropped, ...]
    noise_px: float
    baseline_mm: float
    baseline_u_mm: float
    warnings: tuple[str, ...]
    notes: tuple[str, ...] = ()
    measured_response: MeasuredResponse | None = None


def calibrate(
    poses: Sequence[Pair],
    low: Pair,
    high: Pair,
    board: Board,
    image_size: tuple[int, int],
    *,
    names: Sequence[str] = (),
    region_y_mm: tuple[float, float] = (-250.0, 250.0),
    dropped: Sequence[Dropped] = (),
) -> Calibration:
    """Calibrate two cameras, with the world frame of the low board.

    The low board lies flat at `board.low_mm`: its centre projected to z = 0 is the origin, x runs along its long
    side to the right of the left picture, z towards the cameras. The high board lies parallel to it, anywhere, at
    `board.high_mm` within the standard uncertainty of both heights, or at a height that is measured. k3 of a camera
    is adjusted only when that lowers Schwarz's information criterion, else it is 0.

    Parameters
    ----------
    poses : sequence of pair of ndarray of float64, shape (n, 2), or None
        Corners (x, y), pixels, in the left and the right picture of each pose, in the order of
        `Board.corners_mm` (a turn is allowed where the board's colours do not show it); None where there are none.
    low, high : pair of the same
        The registration boards. Without a low one the world is the left camera's frame and `has_world` is false.
    board : Board
    image_size : tuple of int
        (columns, rows) of all pictures.
    names : sequence of str
        Names of the poses; their places, "00", "01", ..., unless given.
    region_y_mm : tuple of float
        Measuring region for the rig.
    dropped : sequence of Dropped
        Pictures in which no board was found, for the report and for the verdict.

    Returns
    -------
    Calibration

    Raises
    ------
    CalibrationError
        Not good enough; names all reasons and the pictures left out.
    ValueError
        Corners of another shape than the board has, or not finite.
    """
    views = _views(dict(zip(names or map("{:02d}".format, range(len(poses))), poses, strict=True)), low, high, board)
    check_pairs(views, dropped)
    if board.low_mm is None and any(view.board == LOW for view in views):
        sentence = "low_mm is not given: the pictures of the low board need the height of its face over the conveyor"
        raise CalibrationError([sentence], dropped)
    try:
        first = guess(views, board, image_size)
    except cv2.error as error:
        raise CalibrationError(["no camera explains the pictures: check board.json"], dropped) from error
    both = {view.board for view in first.views if view.side == 0} & {view.board for view in first.views if view.side}
    check_moments(sorted(both), first.apart)
    gone = [*dropped, *(_dropped(view, "does not fit the lens: a false grid") for view in first.misfits)]
    first, loose, fell = _without_misfits(first, board, gone)
    gone += fell
    has_high = LOW in first.boards and any(view.board == HIGH for view in first.views)
    if has_high and board.high_mm is not None:
        _check_high(loose, first, board, board.high_mm)
    k3 = _k3_pays(loose, first)
    final = adjust(
        _without_k3(loose.scene, k3), _problem(first, board, k3, high_mm=board.high_mm if has_high else None)
    )
    board = _with_heights(board, float(final.scene.t[list(first.boards).index(HIGH), 2]) if has_high else None)
    return _judged(_rig(final, first, board, region_y_mm), final, first, gone, board, has_high=has_high)


def _views(poses: Mapping[str, Pair], low: Pair, high: Pair, board: Board) -> list[View]:
    named = {**poses, LOW: low, HIGH: high}
    views = [
        View(side, name, corners)
        for name, pair in named.items()
        for side, corners in enumerate(pair)
        if corners is not None
    ]
    for view in views:
        if view.corners_px.shape != (len(board.corners_mm), 2) or not np.isfinite(view.corners_px).all():
            raise ValueError(f"{view.name}: {len(board.corners_mm)} finite corners are needed")
    return views


def _problem(first: Guess, board: Board, k3: tuple[bool, bool], *, high_mm: float | None) -> Problem:
    names = list(first.boards)
    has_world = LOW in first.boards
    free = np.ones(N_RIG + N_BOARD * len(names), dtype=bool)
    free[[K3, N_CAMERA + K3]] = k3
    if not has_world:
        free[POSE] = False
    seen = {view.board for view in first.views}
    for index, name in enumerate(names):
        own = free[N_RIG + N_BOARD * index :][:N_BOARD]
        own[:] = name in seen
        if has_world and name == LOW:
            own[:] = False
        elif has_world and name == HIGH:
            own[:2] = False
    sights = [
        Sights(
            np.array([names.index(view.board) for view in first.views if view.side == side], dtype=np.intp),
            np.array([view.corners_px for view in first.views if view.side == side]),
        )
        for side in (0, 1)
    ]
    u_mm = max(np.sqrt(2.0) * board.height_u_mm, 1e-3)
    known = None if high_mm is None else (names.index(HIGH), high_mm, u_mm)
    return Problem(board.corners_mm, (sights[0], sights[1]), free, known)


def _scene(first: Guess) -> Scene:
    boards = dict(first.boards)
    if LOW in boards and HIGH in boards:
        boards[HIGH] = _flat(boards[HIGH])
    return Scene(
        first.cameras,
        np.array([pose.R for pose in boards.values()]),
        np.array([pose.t for pose in boards.values()]),
    )


def _flat(pose: Pose) -> Pose:
    yaw = np.arctan2(pose.R[1, 0] - pose.R[0, 1], pose.R[0, 0] + pose.R[1, 1])
    return Pose(rotation(np.array([0.0, 0.0, yaw])), pose.t)


def _without_misfits(first: Guess, board: Board, gone: Sequence[Dropped]) -> tuple[Guess, Adjusted, list[Dropped]]:
    """Adjust, and leave out the worst picture as long as it does not fit the others."""
    fell = list[Dropped]()
    while True:
        check_pairs(first.views, [*gone, *fell])
        adjusted = adjust(_scene(first), _problem(first, board, (True, True), high_mm=None))
        bad = _worst(first, adjusted, board)
        if not bad:
            return first, adjusted, fell
        fell += bad.values()
        first = replace(first, views=[view for view in first.views if view not in bad])


def _dropped(view: View, reason: str, *, other_moment: bool = False) -> Dropped:
    return Dropped(view.name, reason, view.board, other_moment)


def _worst(first: Guess, adjusted: Adjusted, board: Board) -> dict[View, Dropped]:
    """Pictures to leave out, with reasons: the worst one, or both of its pair when each alone is right."""
    residuals = {view: rms(errors) for view, errors in _errors_px(first, adjusted).items()}
    limit = max(0.1, 3.0 * float(np.median(list(residuals.values()))))
    worst = max(residuals, key=lambda view: residuals[view])
    if residuals[worst] <= limit:
        return {}
    pair = [view for view in first.views if view.board == worst.board]
    # cameras as their own pictures have them: wrong pairs bend those that were adjusted together
    cameras = (first.cameras, adjusted.scene.cameras)
    alone = {view: min(residual_alone_px(view, both[view.side], board) for both in cameras) for view in pair}
    wrong = {view: _dropped(view, f"no regular grid, residual {px:.2f} px") for view, px in alone.items() if px > limit}
    if wrong:
        return wrong
    if worst.board == HIGH and LOW in first.boards:
        tilted = f"the high board does not lie parallel to the low one, {residuals[worst]:.2f} px"
        return {view: _dropped(view, tilted) for view in pair}
    reason = f"{NOT_OF_ONE_MOMENT}, {residuals[worst]:.2f} px: not of one moment, or the board moved"
    return {view: _dropped(view, reason, other_moment=True) for view in pair}


def _errors_px(first: Guess, adjusted: Adjusted) -> dict[View, NDArray[np.float64]]:
    """Residuals of each picture, shape (corners, 2)."""
    ordered = [view for side in (0, 1) for view in first.views if view.side == side]
    return dict(zip(ordered, [errors for side in adjusted.errors_px for errors in side], strict=True))


def rms(errors_px: NDArray[np.float64]) -> float:
    """Root mean square of residuals, per coordinate."""
    return float(np.sqrt(np.mean(errors_px**2)))


def _with_heights(board: Board, measured_mm: float | None) -> Board:
    """Board with both heights: as told, as the pictures show them, or stand-ins where there are no such pictures."""
    low_mm, high_mm, assumptions = board.low_mm, board.high_mm, board.assumptions
    if low_mm is None:
        low_mm = 0.0 if high_mm is None else high_mm - STAND_IN_RISE_MM
    if high_mm is None and measured_mm is not None:
        if measured_mm <= low_mm:
            below = f"the high board appears {low_mm - measured_mm:.0f} mm below the low one"
            raise CalibrationError([f"{below}: check that the pictures {LOW} and {HIGH} are not swapped"])
        high_mm = measured_mm
        shown = f"high_mm is not given: {high_mm:.1f} mm is what the pictures show"
        assumptions = (*assumptions, Assumption(f"{shown}, so that the heights are not checked"))
    high_mm = low_mm + STAND_IN_RISE_MM if high_mm is None else high_mm
    return replace(board, low_mm=low_mm, high_mm=high_mm, assumptions=assumptions)


def _check_high(loose: Adjusted, first: Guess, board: Board, high_mm: float) -> None:
    index = list(first.boards).index(HIGH)
    u_pictures_mm = np.sqrt(loose.covariance[N_RIG + N_BOARD * index + 5, N_RIG + N_BOARD * index + 5])
    u_scale_mm = board.square_relative_u * (high_mm - (board.low_mm or 0.0))
    u_mm = float(np.sqrt(u_pictures_mm**2 + u_scale_mm**2 + 2.0 * board.height_u_mm**2))
    check_height(float(loose.scene.t[index, 2]), u_mm, high_mm)


def _k3_pays(loose: Adjusted, first: Guess) -> tuple[bool, bool]:
    """Schwarz's criterion for one parameter: chi square must fall by more than ln n."""
    ln_n = np.log(2.0 * sum(len(view.corners_px) for view in first.views))
    indices = (K3, N_CAMERA + K3)
    left, right = (
        bool(camera.dist[4] ** 2 > ln_n * loose.covariance[index, index])
        for camera, index in zip(loose.scene.cameras, indices, strict=True)
    )
    return left, right


def _without_k3(scene: Scene, k3: tuple[bool, bool]) -> Scene:
    left, right = (
        camera if pays else replace(camera, dist=camera.dist * [1.0, 1.0, 1.0, 1.0, 0.0])
        for camera, pays in zip(scene.cameras, k3, strict=True)
    )
    return replace(scene, cameras=(left, right))


def _rig(final: Adjusted, first: Guess, board: Board, region_y_mm: tuple[float, float]) -> Rig:
    corners = {view.name: view.corners_px for view in first.views}
    return Rig(
        left=final.scene.cameras[0],
        right=final.scene.cameras[1],
        covariance=final.covariance[:N_RIG, :N_RIG],
        response=board.response or UNKNOWN_RESPONSE,
        region_y_mm=region_y_mm,
        square_relative_u=board.square_relative_u,
        low_mm=board.low_mm or 0.0,
        high_mm=board.high_mm or 0.0,
        height_u_mm=board.height_u_mm,
        boards={name: corners.get(name, np.empty((0, 2))) for name in BOARD_NAMES},
        residual_px=final.residual_px,
        has_world=LOW in first.boards,
    )


def _judged(
    rig: Rig, final: Adjusted, first: Guess, gone: Sequence[Dropped], board: Board, *, has_high: bool
) -> Calibration:
    scene = final.scene
    seen = {view.board for view in first.views}
    boards = [Pose(R, t) for name, R, t in zip(first.boards, scene.R, scene.t, strict=True) if name in seen]
    judged = limits(rig, first.views, boards)
    reasons = [limit.text for limit in judged if limit.broken]
    if reasons:
        raise CalibrationError(reasons, gone)
    warnings = [limit.text for limit in judged if limit.close] + mounting_warnings(rig)
    warnings += [one.text for one in board.assumptions if rig.has_world or not one.of_world]
    if not rig.has_world:
        warnings.append("the world frame is missing: no picture of the low board; the gauge cannot measure with this")
    elif not has_high:
        warnings.append("no picture of the high board: the heights are not checked")
    return Calibration(
        rig=rig,
        pictures=tuple(
            Picture(view.side, view.board, view.corners_px, errors) for view, errors in _errors_px(first, final).items()
        ),
        dropped=tuple(gone),
        noise_px=final.noise_px,
        baseline_mm=rig.baseline_mm,
        baseline_u_mm=rig.standard_uncertainty(lambda rig: rig.baseline_mm),
        warnings=tuple(warnings),
    )
