"""Learned references on the disk, beside the commissioned ones and never over them.

In the folder of the references, `learned/000001/` holds `top.png`, `bottom.png` and `learned.json`, which says where
the pair comes from; `learned/current.json` holds the number of the pair in use. 0 is the commissioned pair.
`learned/confirmed.npz` holds the ends that were confirmed last, `tops` and `bottoms`, oldest first, so that those of
one recording, or of one start of the station, count in the next: an operator's recording shows ends of one kind.
"""

import json
import operator
import zipfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.cameras.recording.picture_file import read_picture
from appliance.cameras.source import CameraError
from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_file, whole_place
from vision.ingot.classifiers.similarity import SIZE

Picture = NDArray[np.uint8]
Pair = tuple[Picture, Picture]
Ends = tuple[list[Picture], list[Picture]]

FOLDER, CURRENT, CONFIRMED = "learned", "current.json", "confirmed.npz"
CONFIRMED_KINDS = ("tops", "bottoms")
NAMES = ("top.png", "bottom.png")
COMMISSIONED = 0  # number of the pair that nobody learned


class LearnedReferencesError(HotgaugeError):
    """The history of references cannot be read or written; the message says what, where and what to do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Learned:
    """Where a pair comes from.

    Attributes
    ----------
    kind : {"top", "bottom"}
        Which reference is new.
    confirmed_by : {"agreement", "operator"}
    frame : int
        Picture of the ingot that became the reference.
    utc_ms : int
        Moment, ms since 1970 UTC.
    before : int
        Number of the pair that was in use.
    """

    kind: Literal["top", "bottom"]
    confirmed_by: Literal["agreement", "operator"]
    frame: int
    utc_ms: int
    before: int


def current_number(references: Path) -> int:
    """Number of the pair in use; 0 where none was learned.

    Raises
    ------
    LearnedReferencesError
        `current.json` is no file of ours.
    """
    if references.exists() and not references.is_dir():
        raise LearnedReferencesError(f"{references}: is a file; give the folder with top.png and bottom.png")
    file = references / FOLDER / CURRENT
    try:
        return operator.index(json.loads(file.read_text(encoding="utf-8"))["number"])
    except FileNotFoundError:
        return COMMISSIONED
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise LearnedReferencesError(
            f"{file}: no number of references in it; delete the file to use the commissioned ones"
        ) from error


def pair(references: Path, number: int) -> Pair:
    """A pair of the history; 0 is the commissioned one.

    Parameters
    ----------
    references : Path
    number : int

    Raises
    ------
    LearnedReferencesError
        There is no such pair, or a picture cannot be read.
    """
    folder = references / FOLDER / f"{number:06d}" if number else references
    try:
        top, bottom = (read_picture(folder / name).shown for name in NAMES)
    except CameraError as error:
        if number and number not in history(references):
            learned = ", ".join(map(str, history(references))) or "none"
            raise LearnedReferencesError(
                f"{references / FOLDER}: there is no pair {number}; learned are {learned}, 0 is the commissioned one"
            ) from error
        raise LearnedReferencesError(str(error)) from error
    return top, bottom


def history(references: Path) -> list[int]:
    """Numbers of all learned pairs, oldest first."""
    return sorted(int(folder.name) for folder in (references / FOLDER).glob("[0-9]*") if folder.name.isdecimal())


def use(references: Path, number: int) -> None:
    """Use a pair of the history from now on.

    Parameters
    ----------
    references : Path
    number : int
        0 for the commissioned pair.

    Raises
    ------
    LearnedReferencesError
        There is no such pair.
    OSError
        The folder cannot be written.
    """
    pair(references, number)
    (references / FOLDER).mkdir(exist_ok=True)
    with whole_file(references / FOLDER / CURRENT) as file:
        json.dump({"number": number}, file)


def keep(references: Path, pictures: Pair, learned: Learned) -> int:
    """Write a new pair to the history and use it.

    Parameters
    ----------
    references : Path
    pictures : tuple of ndarray of uint8
        Top and bottom.
    learned : Learned

    Returns
    -------
    int
        Its number.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    number = max(history(references), default=COMMISSIONED) + 1
    folder = references / FOLDER / f"{number:06d}"
    folder.mkdir(parents=True)
    for name, picture in zip(NAMES, pictures, strict=True):
        with whole_place(folder / name) as place:
            place.write_bytes(cv2.imencode(".png", picture)[1].tobytes())
    with whole_file(folder / "learned.json") as file:
        json.dump(asdict(learned), file)
    use(references, number)
    return number


def read_confirmed(references: Path) -> Ends:
    """Tops and bottoms; none where none was confirmed.

    Raises
    ------
    LearnedReferencesError
        The file is no file of ours.
    """
    file = references / FOLDER / CONFIRMED
    try:
        with np.load(file, allow_pickle=False) as stored:
            tops, bottoms = (np.asarray(stored[kind]) for kind in CONFIRMED_KINDS)
    except FileNotFoundError:
        return [], []
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise _damaged(file) from error
    if any(ends.shape[1:] != (SIZE, SIZE) or ends.dtype != np.uint8 for ends in (tops, bottoms)):
        raise _damaged(file)
    return list(tops), list(bottoms)


def _damaged(file: Path) -> LearnedReferencesError:
    return LearnedReferencesError(f"{file}: no confirmed ends in it; delete the file to confirm others")


def keep_confirmed(references: Path, ends: Ends) -> None:
    """Write tops and bottoms.

    Parameters
    ----------
    references : Path
    ends : tuple of list of ndarray of uint8, shape (64, 64)

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    (references / FOLDER).mkdir(exist_ok=True)
    arrays = {
        kind: np.array(of, np.uint8).reshape(-1, SIZE, SIZE) for kind, of in zip(CONFIRMED_KINDS, ends, strict=True)
    }
    with whole_place(references / FOLDER / CONFIRMED) as place, place.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def forget_confirmed(references: Path) -> None:
    """Forget them, as after a way back, or they would bring back what was learned from them; raises `OSError`."""
    (references / FOLDER / CONFIRMED).unlink(missing_ok=True)
