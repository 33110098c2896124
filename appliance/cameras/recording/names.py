"""Which files of a folder are pictures or videos, and which frame a picture's name says it is."""

import itertools
import re
import statistics
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path

from appliance.cameras.source import CameraError

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm")
PICTURES_IN_WORDS = "pictures (PNG, JPEG, TIFF, BMP, PGM)"
VIDEO_SUFFIXES = (".mp4", ".avi", ".mkv", ".mov")
SIDES = ("left", "right")
NAMES_SHOWN = 3  # of what was seen, in sentences
JUMP_STEPS = 10  # chosen: a step this many times the usual one shows another stretch of time
DATE_DIGITS = 14  # of year, month, day, hour, minute and second
SIDE_WORDS = re.compile(r"left|right|(?<![a-z])[lr](?![a-z])", re.IGNORECASE)


def files_in(folder: Path) -> list[Path]:
    """Entries of a folder in the order of their names, without hidden ones.

    A Macintosh leaves a hidden `._000000.png` beside each picture.
    """
    return [path for path in sorted(folder.iterdir()) if not path.name.startswith(".")]


def pictures_in(folder: Path) -> list[Path]:
    """Picture files of a folder by their suffix, in letters of any case."""
    return [path for path in files_in(folder) if path.suffix.lower() in PICTURE_SUFFIXES]


def videos_in(folder: Path) -> list[Path]:
    """Video files of a folder by their suffix, in letters of any case."""
    return [path for path in files_in(folder) if path.suffix.lower() in VIDEO_SUFFIXES]


def seen_in(folder: Path) -> str:
    """Some names of a folder's entries, for a sentence that refuses it."""
    names = [path.name for path in files_in(folder)]
    more = f" and {len(names) - NAMES_SHOWN} more" if len(names) > NAMES_SHOWN else ""
    return f"seen: {', '.join(names[:NAMES_SHOWN])}{more}" if names else "it is empty"


def side_of(path: Path) -> str | None:
    """Camera that a name tells by `left`, `right`, `L` or `R`; None where it tells none or both."""
    sides = {SIDES["r" in word.lower()[:1]] for word in SIDE_WORDS.findall(path.stem)}
    return sides.pop() if len(sides) == 1 else None


def by_number(folder: Path, pictures: Sequence[Path]) -> dict[int, Path]:
    """Pictures by the one number that changes from name to name, or by the date and time in their names.

    Parameters
    ----------
    folder : Path
        For sentences.
    pictures : sequence of Path

    Raises
    ------
    CameraError
        A name has no number, names are built differently, several numbers change, or two are of one frame.
    """
    numbered: dict[int, Path] = {}
    for path, number in zip(pictures, _numbers(folder, pictures), strict=True):
        if number in numbered:
            raise CameraError(f"{path}: a second picture of frame {number}, as {numbered[number].name}; remove one")
        numbered[number] = path
    return dict(sorted(numbered.items()))


def _numbers(folder: Path, pictures: Sequence[Path]) -> list[int]:
    wanted = "name pictures by one number that counts the frames, as 000000 or frame_000000"
    fields = [re.findall(r"[0-9]+", SIDE_WORDS.sub("", path.stem)) for path in pictures]
    frames = [re.sub(r"[0-9]+", "#", SIDE_WORDS.sub("", path.stem)).lower() for path in pictures]
    for path, frame, numbers in zip(pictures, frames, fields, strict=True):
        if not numbers:
            raise CameraError(f"{path}: the name is not a frame number; {wanted}")
        if frame != frames[0]:
            names = f"{pictures[0].name} and {path.name}"
            raise CameraError(f"{folder}: {names} are not named after one pattern; {wanted}")
    places = [place for place, texts in enumerate(zip(*fields, strict=True)) if len(set(map(int, texts))) > 1]
    if len(places) > 1:
        moments = [_moment_us("".join(numbers)) for numbers in fields]
        if None not in moments:
            return [moment for moment in moments if moment is not None]
        names = f"{pictures[0].name} and {pictures[-1].name}"
        raise CameraError(f"{folder}: {len(places)} numbers change between {names}; {wanted}")
    place = places[0] if places else -1
    return [int(numbers[place]) for numbers in fields]


def _moment_us(digits: str) -> int | None:
    """Date and time as 20261129081307 and perhaps a fraction, in µs since 1970; None where it is none."""
    try:
        moment = datetime.strptime(digits[:DATE_DIGITS], "%Y%m%d%H%M%S").replace(tzinfo=UTC)
    except ValueError:
        return None
    fraction = digits[DATE_DIGITS:].ljust(6, "0")[:6]
    return int(moment.timestamp()) * 1_000_000 + int(fraction)


def stretch_starts(moments: Iterable[int]) -> list[int]:
    """Positions at which another stretch of time begins: a step back, or one of JUMP_STEPS usual steps.

    Parameters
    ----------
    moments : iterable of int
        Of a recording's frames in their order: numbers, or time stamps.
    """
    known = list(moments)
    steps = [later - earlier for earlier, later in itertools.pairwise(known)]
    if not steps:
        return []
    usual = statistics.median(steps)
    return [place for place, step in enumerate(steps, 1) if step < 0 or step >= JUMP_STEPS * max(usual, 1)]
