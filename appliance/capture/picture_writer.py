"""Writes pictures as they were sent: code values in PNG, and what a PNG cannot say in `coding.json`."""

import json
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.cameras.recording.picture_file import CODING_FILE
from appliance.capture.error import CaptureError
from appliance.files.atomic_file import whole_place
from vision.sent_picture import Codes, Coding, SentPicture

PNG_OPTIONS = [cv2.IMWRITE_PNG_COMPRESSION, 1]  # the quickest; pictures become 5 to 10 % larger
TALLEST_CODE = 65535


def write_picture(path: Path, picture: SentPicture) -> None:
    """Write a PNG that reads as the same light: luma of limited range is stretched to 16 bits over the full range.

    Parameters
    ----------
    path : Path
        Ends in `.png`; its folder is made.
    picture : SentPicture

    Raises
    ------
    CaptureError
        It cannot be written.
    """
    write_whole(path, cv2.imencode(".png", _codes(picture), PNG_OPTIONS)[1].tobytes())


def write_whole(path: Path, data: bytes) -> None:
    """Write a file whole or not at all, and its folder.

    Parameters
    ----------
    path : Path
    data : bytes

    Raises
    ------
    CaptureError
        It cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_place(path) as place:
            place.write_bytes(data)
    except OSError as error:
        raise CaptureError(
            f"{path}: cannot be written ({error.strerror}); give a place in a writable folder"
        ) from error


def write_document(path: Path, document: dict[str, object]) -> None:
    """Write a JSON file whole or not at all; raises `CaptureError`.

    Parameters
    ----------
    path : Path
    document : dict
    """
    write_whole(path, (json.dumps(document, indent=1) + "\n").encode())


def keep_coding(folder: Path, coding: Coding) -> None:
    """Write `coding.json` where the pictures need one.

    Parameters
    ----------
    folder : Path
    coding : Coding
        Of all pictures in it.

    Raises
    ------
    CaptureError
        It cannot be written, or the folder's says something else: its pictures are another camera's.
    """
    told: dict[str, object] = {}
    if coding.bits not in {8, 16} and coding.full_range:
        told["bits"] = coding.bits
    if coding.mosaic is not None:
        told["mosaic"] = coding.mosaic
    path = folder / CODING_FILE
    if path.is_file():
        if json.loads(path.read_text(encoding="utf-8")) != told:
            raise CaptureError(f"{path}: the pictures there are coded otherwise than this camera's; give a new folder")
    elif told:
        write_document(path, told)


def _codes(picture: SentPicture) -> Codes:
    codes = picture.measured if picture.measured.shape[2] == 3 else picture.measured[:, :, 0]
    return codes if picture.coding.full_range else _stretched(codes, picture.coding)


def _stretched(codes: Codes, coding: Coding) -> NDArray[np.uint16]:
    light = (codes.astype(np.float64) - coding.black) / (coding.white - coding.black)
    return np.round(np.clip(light, 0, 1) * TALLEST_CODE).astype(np.uint16)
