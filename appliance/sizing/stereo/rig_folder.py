"""Finds what a rig folder holds: board pictures by pose and side, and the board's description."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from appliance.cameras.recording.names import PICTURE_SUFFIXES
from appliance.errors import reading_advice
from vision.calibration.acceptance import CalibrationError, some_names
from vision.calibration.checkerboard import Board
from vision.calibration.rig import SIDES

REGISTRATION_POSES = ("low", "high")


class RigPictures(NamedTuple):
    """Board pictures of a rig folder.

    Attributes
    ----------
    poses : dict of str to dict of str to Path
        File by pose ("00", "01", ..., "low", "high") and side; a pose may lack a side.
    notes : tuple of str
        What a person should know: pictures without their partner, and pictures that are not used.
    """

    poses: dict[str, dict[str, Path]]
    notes: tuple[str, ...]


def find_pictures(folder: Path) -> RigPictures:
    """Find the board pictures of a rig folder.

    Parameters
    ----------
    folder : Path
        With pictures in `calibration/`, or in itself, and in `registration/`; named `left_7.png`, `right_07.jpg`,
        `Left12.png` and so on: side and number count.

    Raises
    ------
    CalibrationError
        A folder cannot be read, there is no picture of one side, or two pictures are of one pose and side.
    """
    place = folder / "calibration" if (folder / "calibration").is_dir() else folder
    poses, others = _named(place, r"\d+")
    for side in SIDES:
        if not any(side in sides for sides in poses.values()):
            missing = f"no pictures {side}_00.png, {side}_01.png, ..."
            advice = "give the folder above it, with pictures of both cameras"
            raise CalibrationError([f"{folder / 'calibration'}: {missing}; {advice}"])
    registration, more = _named(folder / "registration", "|".join(REGISTRATION_POSES))
    return RigPictures(poses | registration, (*_alone(poses | registration), *_unused([*others, *more])))


def _named(folder: Path, names: str) -> tuple[dict[str, dict[str, Path]], list[Path]]:
    """Pictures of a folder by pose and side, and those whose names say neither."""
    found: dict[str, dict[str, Path]] = {}
    others: list[Path] = []
    for path in _files(folder):
        match = re.fullmatch(rf"(left|right)[ _-]?({names})", path.stem, re.IGNORECASE | re.ASCII)
        if match is None:
            others.append(path)
            continue
        side, name = match[1].lower(), match[2].lower()
        pose = f"{int(name):02d}" if name.isdecimal() else name
        sides = found.setdefault(pose, {})
        if side in sides:
            raise CalibrationError([f"{path}: a second {side} picture of pose {pose}, as {sides[side]}; remove one"])
        sides[side] = path
    return dict(sorted(found.items(), key=lambda pose: (len(pose[0]), pose[0]))), others


def _files(folder: Path) -> list[Path]:
    """Pictures of a folder, without hidden files; none where there is no folder."""
    try:
        files = sorted(folder.iterdir()) if folder.is_dir() else []
    except OSError as error:
        raise CalibrationError([f"{folder}: cannot be read ({error.strerror}); check its permissions"]) from error
    return [path for path in files if path.suffix.lower() in PICTURE_SUFFIXES and not path.name.startswith(".")]


def _alone(poses: Mapping[str, Mapping[str, Path]]) -> list[str]:
    names = [next(iter(sides.values())).name for sides in poses.values() if len(sides) == 1]
    return (
        [f"{some_names(names)}: no picture of the other camera has this number; they help their own alone"]
        if names
        else []
    )


def _unused(files: list[Path]) -> list[str]:
    names = [path.name for path in files]
    return [f"{some_names(names)}: not used, since the name is not a side and a number as in left_00"] if names else []


def read_board(path: Path, overrides: Mapping[str, object]) -> Board:
    """Read the description of the board.

    Parameters
    ----------
    path : Path
        `board.json`; may be missing where `overrides` has all that is needed.
    overrides : mapping of str to object
        Values that replace those of the file, by key.

    Raises
    ------
    CalibrationError
        The file cannot be read, or a value is missing or wrong.
    """
    try:
        values: dict[str, Any] = {**json.loads(path.read_text(encoding="utf-8-sig"))}
    except FileNotFoundError:
        values = {}
        if "squares" not in overrides or "square_mm" not in overrides:
            advice = "describe the board in it, or give --squares and --square-mm"
            if (path.parent.parent / path.name).is_file():
                advice = f"give the folder above it, {path.parent.parent}"
            sentence = f"{path}: no such file; {advice}"
            raise CalibrationError([sentence]) from None
    except NotADirectoryError:
        raise CalibrationError([f"{path.parent}: is a file; give the rig folder, with pictures of the board"]) from None
    except OSError as error:
        raise CalibrationError(
            [f"{path}: cannot be read ({error.strerror}); {reading_advice(error, 'describe the board in it')}"]
        ) from error
    except (ValueError, TypeError, RecursionError) as error:
        raise CalibrationError([f"{path}: not a readable JSON object ({error}); correct it"]) from error
    try:
        return Board.from_json(json.dumps({**values, **overrides}))
    except ValueError as error:
        raise CalibrationError([f"{path}: {error}"]) from error
