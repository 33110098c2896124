"""`hotgauge calibrate`: makes a rig file and a report from a folder of board pictures."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from appliance.cameras.recording.picture_file import ToldCoding, read_picture, read_told_coding
from appliance.cameras.source import CameraError
from appliance.sizing.stereo.rig_folder import REGISTRATION_POSES, find_pictures, read_board
from vision.calibration.acceptance import CalibrationError, Dropped
from vision.calibration.board_edges import board_edges
from vision.calibration.checkerboard import Board
from vision.calibration.corners import find_corners
from vision.calibration.response import MeasuredResponse, chosen_response, edge_shift_px, measure_response
from vision.calibration.rig import SIDES, Rig
from vision.calibration.stereo import Calibration, Pair, calibrate
from vision.calibration.still_marks import NO_MARKS, Marks, find_marks
from vision.geometry.camera import CAMERA_PARAMETERS
from vision.light import ResponseCurve

FRUITLESS = 3  # pictures without the board, after which another board is looked for


def calibrate_folder(
    folder: Path,
    board_overrides: Mapping[str, object] | None = None,
    region_y_mm: tuple[float, float] = (-250.0, 250.0),
    progress: Callable[[int, int], object] | None = None,
) -> Calibration:
    """Calibrate a rig from its pictures.

    Parameters
    ----------
    folder : Path
        With `calibration/left_00.png`, `right_00.png`, ... (any numbers; in the folder itself, too),
        `registration/left_low.png`, `right_low.png`, `left_high.png`, `right_high.png` and `board.json`; what
        pictures cannot say of their coding stands in `coding.json`.
        Without registration pictures the cameras are calibrated and the world frame is missing.
    board_overrides : mapping of str to object, optional
        Values that replace those in `board.json`, by key; with `squares` and `square_mm` it needs no file.
    region_y_mm : tuple of float
        Measuring region along the rolling direction, from and to.
    progress : callable, optional
        Called with the number of pictures done and of all pictures.

    Returns
    -------
    Calibration

    Raises
    ------
    CalibrationError
        A folder or `board.json` is missing or wrong, or a picture is unreadable or of another size (the message names
        it); or the pictures give no good calibration (the message gives all reasons).
    """
    board = read_board(folder / "board.json", board_overrides or {})
    pictures = find_pictures(folder)
    told = _told_coding(folder)
    finder = _Finder(board, told)
    pairs: dict[str, Pair] = {}
    for done, (name, sides) in enumerate(pictures.poses.items(), 1):
        left, right = (finder.corners(sides.get(side), name) for side in SIDES)
        pairs[name] = left, right
        if progress is not None:
            progress(done, len(pictures.poses))
    missing: Pair = (None, None)
    names = [name for name in pairs if name not in REGISTRATION_POSES]
    try:
        calibration = calibrate(
            [pairs[name] for name in names],
            pairs.get("low", missing),
            pairs.get("high", missing),
            board,
            finder.image_size,
            names=names,
            region_y_mm=region_y_mm,
            dropped=finder.dropped,
        )
    except CalibrationError as error:
        raise CalibrationError([*finder.other_board(), *error.reasons, *pictures.notes], error.dropped) from error
    paths = pictures.poses
    left, right = (_marks(paths, pairs, side, told) for side in range(len(SIDES)))
    measured = _response(calibration.rig, board, paths, pairs, told)
    chosen = chosen_response(board.response, measured)
    rig = replace(calibration.rig, marks=(left, right), response=chosen.response)
    warnings = (*calibration.warnings, *pictures.notes, *filter(None, [chosen.warning]))
    notes = tuple(filter(None, [chosen.filter]))
    return replace(calibration, rig=rig, warnings=warnings, notes=notes, measured_response=measured)


def _response(
    rig: Rig, board: Board, paths: Mapping[str, Mapping[str, Path]], pairs: Mapping[str, Pair], told: ToldCoding
) -> MeasuredResponse | None:
    """Response from the pictures in which the board was found."""
    edges = [
        (board_edges(picture, camera, corners, board), picture.coding)
        for name, pair in pairs.items()
        for side, camera, corners in zip(SIDES, (rig.left, rig.right), pair, strict=True)
        if corners is not None
        for picture in [read_picture(paths[name][side], told)]
    ]
    return measure_response(edges)


def _told_coding(folder: Path) -> ToldCoding:
    try:
        return read_told_coding(folder)
    except CameraError as error:
        raise CalibrationError([str(error)]) from error


def _marks(paths: Mapping[str, Mapping[str, Path]], pairs: Mapping[str, Pair], side: int, told: ToldCoding) -> Marks:
    """Still marks (fixed background points) of one camera; none unless it saw the board at both heights."""
    files = [paths.get(name, {}).get(SIDES[side]) for name in REGISTRATION_POSES]
    low_px, high_px = (pairs.get(name, (None, None))[side] for name in REGISTRATION_POSES)
    if files[0] is None or files[1] is None or low_px is None or high_px is None:
        return NO_MARKS
    low, high = (read_picture(path, told).shown for path in (files[0], files[1]))
    return find_marks(low, high, (low_px, high_px))


class _Finder:
    """Finds board corners picture by picture and lists the pictures without."""

    def __init__(self, board: Board, told: ToldCoding) -> None:
        self._board = board
        self._told = told
        self._found = 0
        self._first: Path | None = None
        self.image_size = (0, 0)
        self.dropped: list[Dropped] = []

    def corners(self, path: Path | None, board: str) -> np.ndarray | None:
        if path is None:
            return None
        try:
            picture = read_picture(path, self._told)
        except CameraError as error:
            raise CalibrationError([str(error)]) from error
        self._check_size(path, picture.size)
        found = find_corners(picture, self._board)
        if found.corners_px is None:
            self.dropped.append(Dropped(path.stem, found.reason, board))
            if len(self.dropped) == FRUITLESS and not self._found and (other := self.other_board()):
                raise CalibrationError(other)  # looking for what is not there takes seconds a picture
        else:
            self._found += 1
        return found.corners_px

    def other_board(self) -> list[str]:
        """A sentence when the board was found in few pictures and they show another one; else nothing."""
        if self._first is None or self._found > len(self.dropped):
            return []
        picture = read_picture(self._first, self._told)
        long, short = self._board.squares
        for squares in ((long + 1, short + 1), (long - 1, short - 1)):
            other = replace(self._board, squares=squares) if squares[0] > 4 and squares[1] > 3 else self._board
            if other is not self._board and find_corners(picture, other).corners_px is not None:
                shown = f"squares is {long} x {short}, but {self._first} shows {squares[0]} x {squares[1]} squares"
                return [f"{shown}: count squares and not inner corners"]
        return []

    def _check_size(self, path: Path, size: tuple[int, int]) -> None:
        if self._first is None:
            self._first, self.image_size = path, size
        if size != self.image_size:
            was, now = (f"{columns} x {rows}" for columns, rows in (self.image_size, size))
            sentence = f"{path}: {now} pixels where {self._first} has {was}; take all pictures with one size"
            raise CalibrationError([sentence])


def report_lines(calibration: Calibration) -> list[str]:
    """Report of a calibration for the terminal: its pictures, residuals, cameras, baseline and warnings.

    Parameters
    ----------
    calibration : Calibration

    Returns
    -------
    list of str
    """
    rig = calibration.rig
    lines = [f"{'picture':<12} residual px"]
    lines += [f"{picture.name:<12} {picture.residual_px:11.3f}" for picture in calibration.pictures]
    lines += [f"{drop.name:<12} left out: {drop.reason}" for drop in calibration.dropped]
    lines += ["", f"residual      {rig.residual_px:.3f} px, corner noise {calibration.noise_px:.3f} px"]
    lines += [line for side, name in enumerate(SIDES) for line in _camera_lines(rig, side, name)]
    baseline = f"{calibration.baseline_mm:.2f} mm, u = {calibration.baseline_u_mm:.2f} mm"
    lines += [
        f"baseline      {baseline} and {100.0 * rig.square_relative_u:.3f} % of every length for the board",
        f"world frame   {world_in_words(rig)}",
        f"response      {response_in_words(rig)}",
        f"still marks   {' and '.join(str(len(marks.patch)) for marks in rig.marks)}, to notice a camera that moves",
        *(f"note          {note}" for note in calibration.notes),
        *(f"warning       {warning}" for warning in calibration.warnings),
        f"verdict       {verdict(calibration)}",
    ]
    return lines


def verdict(calibration: Calibration) -> str:
    """Whether a calibration that was not refused can be used, in words."""
    if not calibration.rig.has_world:
        return "cameras calibrated; nothing can be measured before registration pictures of the low board are added"
    return "usable, see the warnings" if calibration.warnings else "good"


def _camera_lines(rig: Rig, side: int, name: str) -> list[str]:
    camera = (rig.left, rig.right)[side]
    u = np.sqrt(np.diag(rig.covariance))[15 * side :][:15]
    k3 = CAMERA_PARAMETERS.index("k3")
    lens = f"k1 = {camera.dist[0]:.4f}, k2 = {camera.dist[1]:.4f}"
    lens += f", k3 = {camera.dist[4]:.4f}" if u[k3] > 0.0 else ", k3 = 0, since the pictures do not call for it"
    focal = f"fx = {camera.K[0, 0]:.2f} px, u = {u[0]:.2f}; fy = {camera.K[1, 1]:.2f} px, u = {u[1]:.2f}"
    return [f"{name + ' focal':<13} {focal}", f"{name + ' lens':<13} {lens}"]


def response_in_words(rig: Rig) -> str:
    """Response, and what its doubt does to a bar's edges."""
    curve = rig.response
    if not isinstance(curve, ResponseCurve):
        return f"{curve}, as board.json tells it and the board pictures allow it"
    _, u_px = edge_shift_px(curve, curve)
    return (
        f"measured: exponent {curve.exponent:.2f}, offset {curve.offset:.3f}, shoulder {curve.shoulder:.2f}; "
        f"a bar's edges are known to {u_px:.3f} px by it"
    )


def world_in_words(rig: Rig) -> str:
    """Where the world frame comes from, and how high the cameras stand over it."""
    if not rig.has_world:
        return "missing: no pictures of the low board"
    left_mm, right_mm = rig.left.centre_mm[2], rig.right.centre_mm[2]
    return f"from the low board at {rig.low_mm:g} mm; cameras {left_mm:.0f} and {right_mm:.0f} mm above the conveyor"
