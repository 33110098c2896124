"""`hotgauge calibrate`: makes a rig file and a report from a folder of board pictures."""

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from appliance.cameras.recording.pairs import PICTURE_SUFFIXES
from appliance.cameras.recording.picture_file import ToldCoding, read_picture, read_told_coding
from appliance.cameras.source import CameraError
from vision.calibration.acceptance import CalibrationError, Dropped
from vision.calibration.board_edges import board_edges
from vision.calibration.checkerboard import Board
from vision.calibration.corners import find_corners
from vision.calibration.response import ChosenResponse, chosen_response, edge_shift_px, measure_response
from vision.calibration.rig import SIDES, Rig
from vision.calibration.stereo import Calibration, Pair, calibrate
from vision.calibration.still_marks import NO_MARKS, Marks, find_marks
from vision.geometry.camera import CAMERA_PARAMETERS
from vision.light import ResponseCurve

REGISTRATION_POSES = ("low", "high")


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
        With `calibration/left_00.png`, `right_00.png`, ... (any numbers, PNG or JPEG),
        `registration/left_low.png`, `right_low.png`, `left_high.png`, `right_high.png` and `board.json`; what
        pictures cannot say of their coding stands in `coding.json`.
        Without registration pictures the cameras are calibrated and the world frame is missing.
    board_overrides : mapping of str to object, optional
        Values that replace those in `board.json`, by key.
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
    board = _read_board(folder / "board.json", board_overrides or {})
    paths = _pictures(folder)
    told = _told_coding(folder)
    finder = _Finder(board, told)
    pairs: dict[str, Pair] = {}
    for done, (name, sides) in enumerate(paths.items(), 1):
        left, right = (finder.corners(sides.get(side)) for side in SIDES)
        pairs[name] = left, right
        if progress is not None:
            progress(done, len(paths))
    missing: Pair = (None, None)
    numbers = [int(name) for name in pairs if name not in REGISTRATION_POSES]
    calibration = calibrate(
        [pairs.get(f"{number:02d}", missing) for number in range(max(numbers, default=-1) + 1)],
        pairs.get("low", missing),
        pairs.get("high", missing),
        board,
        finder.image_size,
        region_y_mm=region_y_mm,
        dropped=finder.dropped,
    )
    left, right = (_marks(paths, pairs, side, told) for side in range(len(SIDES)))
    chosen = _response(calibration.rig, board, finder.found, told)
    rig = replace(calibration.rig, marks=(left, right), response=chosen.response)
    warnings = (*calibration.warnings, *filter(None, [chosen.warning]))
    return replace(calibration, rig=rig, warnings=warnings, notes=tuple(filter(None, [chosen.filter])))


def _response(rig: Rig, board: Board, found: Mapping[Path, np.ndarray], told: ToldCoding) -> ChosenResponse:
    """Response from the pictures in which the board was found, against what `board.json` tells."""
    edges = [
        (board_edges(picture, rig.left if path.stem.startswith("left") else rig.right, corners, board), picture.coding)
        for path, corners in found.items()
        for picture in [read_picture(path, told)]
    ]
    return chosen_response(board.response, measure_response(edges))


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
        self.found: dict[Path, np.ndarray] = {}
        self._first: Path | None = None
        self.image_size = (0, 0)
        self.dropped: list[Dropped] = []

    def corners(self, path: Path | None) -> np.ndarray | None:
        if path is None:
            return None
        try:
            picture = read_picture(path, self._told)
        except CameraError as error:
            raise CalibrationError([str(error)]) from error
        self._check_size(path, picture.size)
        found = find_corners(picture, self._board)
        if found.corners_px is None:
            self.dropped.append(Dropped(path.stem, found.reason))
        else:
            self.found[path] = found.corners_px
        return found.corners_px

    def _check_size(self, path: Path, size: tuple[int, int]) -> None:
        if self._first is None:
            self._first, self.image_size = path, size
        if size != self.image_size:
            was, now = (f"{columns} x {rows}" for columns, rows in (self.image_size, size))
            sentence = f"{path}: {now} pixels where {self._first} has {was}; take all pictures with one size"
            raise CalibrationError([sentence])


def _read_board(path: Path, overrides: Mapping[str, object]) -> Board:
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        return Board.from_json(json.dumps({**values, **overrides}))
    except OSError as error:
        raise CalibrationError([f"{path}: cannot be read ({error.strerror}); describe the board in it"]) from error
    except (ValueError, TypeError) as error:
        raise CalibrationError([f"{path}: {error}"]) from error


def _pictures(folder: Path) -> dict[str, dict[str, Path]]:
    """Picture files by pose ("00", "01", ..., "low", "high") and side."""
    poses = _named(folder / "calibration", r"\d+")
    if not poses:
        sentence = f"{folder / 'calibration'}: no pictures left_00.png, right_00.png, ...; give the folder above it"
        raise CalibrationError([sentence])
    numbered = {f"{int(name):02d}": sides for name, sides in poses.items()}
    return numbered | _named(folder / "registration", "|".join(REGISTRATION_POSES))


def _named(folder: Path, names: str) -> dict[str, dict[str, Path]]:
    found: dict[str, dict[str, Path]] = {}
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        match = re.fullmatch(rf"(left|right)_({names})", path.stem)
        if match is None or path.suffix.lower() not in PICTURE_SUFFIXES:
            continue
        sides = found.setdefault(match[2], {})
        if match[1] in sides:
            raise CalibrationError([f"{path}: a second picture {path.stem}; remove one of them"])
        sides[match[1]] = path
    return found


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
        f"world frame   {_world(rig)}",
        f"response      {_response_line(rig)}",
        f"still marks   {' and '.join(str(len(marks.patch)) for marks in rig.marks)}, to notice a camera that moves",
        *(f"note          {note}" for note in calibration.notes),
        *(f"warning       {warning}" for warning in calibration.warnings),
        f"verdict       {'good' if not calibration.warnings else 'usable, see the warnings'}",
    ]
    return lines


def _camera_lines(rig: Rig, side: int, name: str) -> list[str]:
    camera = (rig.left, rig.right)[side]
    u = np.sqrt(np.diag(rig.covariance))[15 * side :][:15]
    k3 = CAMERA_PARAMETERS.index("k3")
    lens = f"k1 = {camera.dist[0]:.4f}, k2 = {camera.dist[1]:.4f}"
    lens += f", k3 = {camera.dist[4]:.4f}" if u[k3] > 0.0 else ", k3 = 0, since the pictures do not call for it"
    focal = f"fx = {camera.K[0, 0]:.2f} px, u = {u[0]:.2f}; fy = {camera.K[1, 1]:.2f} px, u = {u[1]:.2f}"
    return [f"{name + ' focal':<13} {focal}", f"{name + ' lens':<13} {lens}"]


def _response_line(rig: Rig) -> str:
    """Response, and what its doubt does to a bar's edges."""
    curve = rig.response
    if not isinstance(curve, ResponseCurve):
        return f"{curve}, as board.json tells it and the board pictures allow it"
    _, u_px = edge_shift_px(curve, curve)
    return (
        f"measured: exponent {curve.exponent:.2f}, offset {curve.offset:.3f}, shoulder {curve.shoulder:.2f}; "
        f"a bar's edges are known to {u_px:.3f} px by it"
    )


def _world(rig: Rig) -> str:
    if not rig.has_world:
        return "missing: no pictures of the low board"
    left_mm, right_mm = rig.left.centre_mm[2], rig.right.centre_mm[2]
    return f"from the low board at {rig.low_mm:g} mm; cameras {left_mm:.0f} and {right_mm:.0f} mm above the conveyor"
