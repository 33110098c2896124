"""Reads and writes rig files, the calibration of two cameras from `hotgauge calibrate`."""

from pathlib import Path

from appliance.errors import reading_advice
from appliance.files.atomic_file import whole_file
from appliance.sizing.method import ScaleError
from vision.calibration.rig import Rig


class RigError(ScaleError):
    """A calibration file cannot be read, written or used; the message says which, why and what to do."""

    fault = "rig_unusable"


def load_rig(path: Path) -> Rig:
    """Read a rig.

    Parameters
    ----------
    path : Path
        JSON file that `save_rig` wrote.

    Returns
    -------
    Rig

    Raises
    ------
    RigError
        File missing, unreadable, or malformed in any way; the message names file and key.
    """
    try:
        return Rig.from_json(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        advice = reading_advice(error, "make it with `hotgauge calibrate`")
        raise RigError(f"{path}: cannot be read ({error.strerror}); {advice}") from error
    except ValueError as error:
        raise RigError(f"{path}: no usable rig file: {error}; make it with `hotgauge calibrate`") from error


def save_rig(rig: Rig, path: Path) -> None:
    """Write a rig file whole or not at all; an older one stays until the new one is complete on disk.

    Parameters
    ----------
    rig : Rig
    path : Path
        JSON file to write or replace.

    Raises
    ------
    RigError
        Folder missing or not writable, or disk full.
    """
    text = rig.to_json()
    try:
        with whole_file(path) as file:
            file.write(text)
    except OSError as error:
        raise RigError(f"{path}: cannot be written ({error.strerror}); give a file in a writable folder") from error
