"""Where the frames of a recording are stored: pictures or videos, of one camera or of two."""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from appliance.cameras.recording.names import (
    PICTURES_IN_WORDS,
    SIDES,
    VIDEO_SUFFIXES,
    by_number,
    files_in,
    pictures_in,
    seen_in,
    side_of,
    videos_in,
)
from appliance.cameras.recording.picture_file import read_picture, read_told_coding
from appliance.cameras.recording.stored_coding import StoredCodings
from appliance.cameras.recording.video_file import VideoFile
from appliance.cameras.source import CameraError
from vision.sent_picture import SentPicture

Pictures = tuple[SentPicture, ...]


class Frames(Protocol):
    """Frames of a recording, by their position from 0."""

    @property
    def numbers(self) -> Sequence[int]:
        """Frame number of each, as pictures are named; of videos their positions."""
        ...

    def read(self, position: int) -> tuple[int, Pictures] | None:
        """Frame number and pictures, left first; None after the end; raises `CameraError`."""
        ...

    def place(self, camera: int, number: int) -> str:
        """Where a picture is stored, for sentences."""
        ...

    def close(self) -> None:
        """Let go of the files."""
        ...


def open_pair(folder: Path) -> Frames:
    """Frames of two cameras.

    Parameters
    ----------
    folder : Path
        With folders `left` and `right`, or pictures or videos that have these words in their names.

    Raises
    ------
    CameraError
        Folder missing, nothing of two cameras in it, or left and right do not fit together.
    """
    if not folder.is_dir():
        raise CameraError(f"{folder}: no such folder; give the folder of a recording")
    sides = {path.name.lower(): path for path in files_in(folder) if path.is_dir()}
    if all(side in sides for side in SIDES):
        return _PictureFrames(folder, [by_number(sides[side], pictures_in(sides[side])) for side in SIDES])
    for files, make in ((pictures_in(folder), _pictures), (videos_in(folder), _videos)):
        of_side = [[path for path in files if side_of(path) == side] for side in SIDES]
        if all(of_side):
            return make(folder, of_side)
    raise CameraError(
        f"{folder}: holds neither left/ and right/ with {PICTURES_IN_WORDS}, nor left.mp4 and right.mp4 "
        f"({seen_in(folder)}); give the folder of a recording of two cameras"
    )


def open_single(place: Path) -> Frames:
    """Frames of one camera.

    Parameters
    ----------
    place : Path
        Folder with pictures or one video in it, or a video file.

    Raises
    ------
    CameraError
        Nothing there, or nothing of one camera.
    """
    try:
        if place.is_file() and place.suffix.lower() in VIDEO_SUFFIXES:
            return _VideoFrames(place.parent, [place])
        if pictures := pictures_in(place):
            return _PictureFrames(place, [by_number(place, pictures)])
        videos = videos_in(place)
    except FileNotFoundError as error:
        raise CameraError(f"{place}: no such folder; give the folder of a recording") from error
    except OSError as error:
        raise CameraError(f"{place}: cannot be read ({error.strerror}); give a recording's folder") from error
    if len(videos) == 1:
        return _VideoFrames(place, videos)
    raise CameraError(
        f"{place}: holds no {PICTURES_IN_WORDS} and no single video ({seen_in(place)}); give the folder of a recording "
        "of one camera, with its pictures or its video directly in it"
    )


class _PictureFrames:
    """Pictures by frame number, a table for each camera."""

    def __init__(self, folder: Path, cameras: Sequence[dict[int, Path]]) -> None:
        if not all(cameras):
            raise CameraError(f"{folder}: left/ and right/ hold no {PICTURES_IN_WORDS}; record some")
        alone = {number for paths in cameras for number in paths if not all(number in other for other in cameras)}
        if alone:
            counts = " and ".join(f"{len(paths)} {side}" for side, paths in zip(SIDES, cameras, strict=True))
            raise CameraError(
                f"{folder}: {counts} pictures do not form pairs, first at frame {min(alone)}; complete or remove the "
                "pictures that stand alone"
            )
        self._cameras = cameras
        self._told = read_told_coding(folder)
        self._stored = StoredCodings(folder)
        self.numbers = list(cameras[0])

    def read(self, position: int) -> tuple[int, Pictures] | None:
        if position >= len(self.numbers):
            return None
        number = self.numbers[position]
        return number, tuple(self._picture(camera, paths[number]) for camera, paths in enumerate(self._cameras))

    def _picture(self, camera: int, path: Path) -> SentPicture:
        side = SIDES[camera] if len(self._cameras) > 1 else ""
        return self._stored.of(read_picture(path, self._told), path.stem, side, camera)

    def place(self, camera: int, number: int) -> str:
        return str(self._cameras[camera][number])

    def close(self) -> None:
        pass


class _VideoFrames:
    """A video file for each camera."""

    def __init__(self, folder: Path, videos: Sequence[Path]) -> None:
        self._videos = [VideoFile(path) for path in videos]
        self._stored = StoredCodings(folder)
        counts = [video.announced for video in self._videos]
        if len(set(counts)) > 1:
            left, right = self._videos
            raise CameraError(
                f"{folder}: {left.path.name} has {left.announced} frames and {right.path.name} {right.announced}; "
                "cut both to the same frames"
            )
        self.numbers = range(counts[0])

    def read(self, position: int) -> tuple[int, Pictures] | None:
        pictures = [video.read(position) for video in self._videos]
        there = tuple(picture for picture in pictures if picture is not None)
        if not there:
            return None
        if len(there) < len(pictures):
            short = self.place(pictures.index(None), position)
            raise CameraError(f"{short}: ends before the other video; cut both to the same frames")
        sides = SIDES if len(there) > 1 else ("",)
        name = f"{position:06}"
        return position, tuple(
            self._stored.of(picture, name, side, camera)
            for camera, (picture, side) in enumerate(zip(there, sides, strict=True))
        )

    def place(self, camera: int, number: int) -> str:
        return f"{self._videos[camera].path}, frame {number}"

    def close(self) -> None:
        for video in self._videos:
            video.close()


def _pictures(folder: Path, of_side: Sequence[Sequence[Path]]) -> Frames:
    return _PictureFrames(folder, [by_number(folder, pictures) for pictures in of_side])


def _videos(folder: Path, of_side: Sequence[Sequence[Path]]) -> Frames:
    for side, videos in zip(SIDES, of_side, strict=True):
        if len(videos) > 1:
            names = ", ".join(path.name for path in videos)
            raise CameraError(f"{folder}: more than one {side} video ({names}); remove all but one")
    return _VideoFrames(folder, [videos[0] for videos in of_side])
