"""Finds the recordings in an archive."""

import os
from pathlib import Path

from appliance.cameras.recording.names import PICTURE_SUFFIXES, SIDES, VIDEO_SUFFIXES
from appliance.errors import HotgaugeError


class ArchiveError(HotgaugeError):
    """An archive cannot be measured; the message says what, where and what to do."""


def find_recordings(archive: Path) -> list[Path]:
    """Folders in an archive that are recordings, at any depth, in the order of their paths.

    Parameters
    ----------
    archive : Path

    Raises
    ------
    ArchiveError
        There is no such folder, or no recording in it.
    """
    found: list[Path] = []
    for folder, inside, files in os.walk(archive, followlinks=True):
        inside.sort()
        if _is_recording(inside, files):
            found.append(Path(folder))
            inside.clear()  # what lies in a recording belongs to it
    if not found:
        raise ArchiveError(f"{archive}: no recordings in it; give a folder with folders of pictures or videos in it")
    return sorted(found)


def _is_recording(folders: list[str], files: list[str]) -> bool:
    """Whether a folder holds `left` and `right`, a video, or pictures that have a number in their names."""
    numbered = {Path(name).suffix.lower() for name in files if any(letter.isdecimal() for letter in Path(name).stem)}
    videos = {Path(name).suffix.lower() for name in files} & set(VIDEO_SUFFIXES)
    pairs = set(SIDES) <= {name.lower() for name in folders}
    return pairs or bool(videos) or not numbered.isdisjoint(PICTURE_SUFFIXES)
