"""Writes exposures as a recording: pictures without loss, their coding, time stamps and readings."""

import json
import os
import shutil
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.black_box.picture_memory import KeptExposure, is_apart
from appliance.cameras.recording.names import SIDES
from appliance.cameras.recording.stored_coding import CODINGS_FILE, MEASURED_FOLDER, PLAIN_CODINGS, codings_document
from appliance.cameras.recording.time_stamps import STAMPS_FILE, Stamps, stamps_table
from appliance.cameras.source import FramePair
from vision.sent_picture import Coding, SentPicture

FAST_PNG = (cv2.IMWRITE_PNG_COMPRESSION, 1)  # a third of the time of level 3, for a file that is 5 % larger
PARTIAL = ".partial-"


def write_recording(place: Path, exposures: deque[KeptExposure], files: Mapping[str, bytes]) -> None:
    """Write a recording that appears under its name only when all of it is on the disk.

    Parameters
    ----------
    place : Path
        Folder to be made.
    exposures : deque of KeptExposure
        Oldest first; emptied, so that their memory is free as soon as they are written.
    files : mapping of str to bytes
        Further files, by their path in the folder.

    Raises
    ------
    OSError
        The disk is full, or the folder cannot be written.
    """
    partial = place.with_name(f"{PARTIAL}{place.name}")
    try:
        for name, content in files.items():
            _write(partial / name, content)
        _write_exposures(partial, exposures)
        partial.rename(place)
    except OSError:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def _write_exposures(folder: Path, exposures: deque[KeptExposure]) -> None:
    stamps: dict[int, Stamps] = {}
    codings: dict[str, list[Coding]] = {}
    rows: list[str] = []
    number = 0
    while exposures:
        kept = exposures.popleft()
        name = f"{number:06}"
        sides = SIDES if isinstance(kept.exposed, FramePair) else ("",)
        for side, picture in zip(sides, kept.pictures, strict=True):
            _write_picture(folder, Path(side) / f"{name}.png", picture)
        if any(picture.coding not in PLAIN_CODINGS for picture in kept.pictures):
            codings[name] = [picture.coding for picture in kept.pictures]
        if isinstance(kept.exposed, FramePair):
            stamps[number] = Stamps.of(kept.exposed)
        moment = {"sequence": kept.exposed.sequence, "exposed_utc_ms": kept.exposed.exposed_utc_ms}
        rows += [json.dumps(row | {"frame": number} | moment, allow_nan=False) for row in kept.rows()]
        number += 1
    _write(folder / "readings.jsonl", "".join(f"{row}\n" for row in rows).encode())
    if stamps:
        _write(folder / STAMPS_FILE, stamps_table(stamps))
    if codings:
        _write(folder / MEASURED_FOLDER / CODINGS_FILE, codings_document(codings))


def _write_picture(folder: Path, name: Path, picture: SentPicture) -> None:
    _write(folder / name, _png(picture.shown))
    if is_apart(picture):
        _write(folder / MEASURED_FOLDER / name, _png(picture.measured))


def _png(image: NDArray[Any]) -> bytes:
    return cv2.imencode(".png", np.ascontiguousarray(image), FAST_PNG)[1].tobytes()


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
