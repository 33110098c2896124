"""Recorded image pairs: two folders of pictures or two video files, as a camera or one after the other."""

import csv
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Generic, Protocol, Self, TypeVar

from appliance.cameras.pacing import Pacer, device_us, utc_ms
from appliance.cameras.recording.picture_file import read_picture, read_told_coding
from appliance.cameras.recording.stored_coding import StoredCodings
from appliance.cameras.recording.video_file import VideoFile
from appliance.cameras.source import CameraError, EndOfRecording, FramePair
from vision.sent_picture import SentPicture

Pictures = tuple[SentPicture, SentPicture]

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg")
VIDEO_SUFFIXES = (".mp4", ".avi", ".mkv", ".mov")
SIDES = ("left", "right")
STAMPS_FILE = "timestamps.csv"

Recorded = TypeVar("Recorded")


class Recording:
    """All image pairs of a recording in their order, without any timing.

    Parameters
    ----------
    folder : Path
        With `left/` and `right/` (pictures named by their frame number) or `left.mp4` and `right.mp4`
        (also .avi, .mkv and .mov, in letters of any case);
        what pictures cannot say of their coding stands in `coding.json`.

    Raises
    ------
    CameraError
        Folder missing or unreadable, no recording in it, names or numbers of left and right pictures differ, a video
        cannot be opened.
    """

    def __init__(self, folder: Path) -> None:
        try:
            if not folder.is_dir():
                raise CameraError(f"{folder}: no such folder; give the folder of a recording")
            self._frames = _open_frames(folder)
        except OSError as error:
            place = error.filename or folder
            raise CameraError(f"{place}: cannot be read ({error.strerror}); check its permissions") from error
        self._shape: tuple[int, int] | None = None

    def __len__(self) -> int:
        """Number of pairs; of videos as their headers announce it."""
        return self._frames.announced

    def __iter__(self) -> Iterator[tuple[int, SentPicture, SentPicture]]:
        """Frame number, left and right picture of each pair; raises `CameraError` like `read`."""
        position = 0
        while (pair := self.read(position)) is not None:
            yield pair
            position += 1

    def read(self, position: int) -> tuple[int, SentPicture, SentPicture] | None:
        """Frame number, left and right picture at a position from 0; None after the end.

        Raises
        ------
        CameraError
            A picture is truncated or unreadable, sizes differ, one video ends before the other.
        """
        pair = self._frames.read(position)
        if pair is None:
            return None
        number, pictures = pair
        for side, picture in zip(SIDES, pictures, strict=True):
            self._shape = unchanged_size(self._shape, picture, self._frames.place(side, number))
        return number, *pictures

    def close(self) -> None:
        """Let go of the files."""
        self._frames.close()


def unchanged_size(shape: tuple[int, int] | None, picture: SentPicture, place: str) -> tuple[int, int]:
    """Rows and columns of a picture; raises `CameraError` when they are not those that the recording's others have."""
    now = picture.shown.shape[0], picture.shown.shape[1]
    if shape not in {None, now}:
        was_text, now_text = (f"{columns} x {rows}" for rows, columns in (shape or now, now))
        raise CameraError(
            f"{place}: picture is {now_text} pixels where the recording's others are {was_text}; "
            "record with one unchanged size"
        )
    return now


class Laps(Generic[Recorded]):
    """A recording's frames by the number of their exposure, again and again when it loops.

    Parameters
    ----------
    folder : Path
        For the message at the end.
    length : int
        Number of frames.
    read : callable
        Frame at a position from 0; None after the end, which may come before `length`, as videos are described.
    loop : bool
        Start again at the end, else raise `EndOfRecording`.

    Attributes
    ----------
    lap : int
        Times that the recording has been started again.
    """

    def __init__(self, folder: Path, length: int, read: Callable[[int], Recorded | None], loop: bool) -> None:
        self._folder = folder
        self._length = length
        self._read = read
        self._loop = loop
        self._start = 0
        self.lap = 0

    def frame(self, sequence: int) -> Recorded:
        """Frame of an exposure, later than the last one asked for; raises `EndOfRecording`."""
        frame = self._read(sequence - self._start)
        if frame is None and self._loop:
            # frames that nobody took count: a gauge that is slow sees later frames, not always the first
            laps, position = divmod(sequence - self._start, max(1, self._length))
            position = position if laps else 0
            self.lap += max(1, laps)
            self._start = sequence - position
            frame = self._read(position)
        if frame is None:
            raise EndOfRecording(f"{self._folder}: the recording is over; play it again or let it loop")
        return frame


class RecordingSource:
    """A recording as a camera; see `PairSource`.

    Parameters
    ----------
    folder : Path
        As for `Recording`; with `timestamps.csv` (`frame,left_us,right_us`) for the device time stamps, which
        are otherwise those of a steady clock.
    rate_hz : float
        Pairs per second in real time; 0 delivers every pair as fast as it is asked for.
    loop : bool
        Start again at the end, else raise `EndOfRecording`.
    """

    simulated = True

    def __init__(self, folder: Path, rate_hz: float, loop: bool) -> None:
        self._folder = folder
        self._rate_hz = rate_hz
        self._loop = loop

    def __enter__(self) -> Self:
        """Open the recording; raises `CameraError` like `Recording`, and for a `timestamps.csv` that is wrong."""
        self._recording = Recording(self._folder)
        self._laps = Laps(self._folder, len(self._recording), self._recording.read, self._loop)
        self._last: int | None = None
        self._stamps = _Stamps(self._folder, self._rate_hz)
        self._pacer = Pacer(self._rate_hz)
        return self

    def __exit__(self, *_: object) -> None:
        """Close the files."""
        self._recording.close()

    def next(self, timeout_s: float) -> FramePair | None:
        """Newest pair that is due; None when none is due in time.

        Raises
        ------
        EndOfRecording
            All pairs were played and `loop` is off.
        CameraError
            As in `Recording.read`; the time stamp of a frame is missing.
        """
        due = self._pacer.next_due(timeout_s)
        if due is None:
            return None
        sequence, moment_s = due
        number, left, right = self._laps.frame(sequence)
        left_us, right_us = self._stamps.of(number, sequence, self._laps.lap)
        repeated, self._last = number == self._last, number
        return FramePair(
            left.shown,
            right.shown,
            sent=(left, right),
            sequence=sequence,
            left_us=left_us,
            right_us=right_us,
            exposed_monotonic_s=moment_s,
            exposed_utc_ms=utc_ms(moment_s),
            dropped=self._pacer.dropped,
            repeated=repeated,
        )


class _Stamps:
    """Device time stamps: those of `timestamps.csv`, moved on by each lap, or those of a steady clock."""

    def __init__(self, folder: Path, rate_hz: float) -> None:
        self._path = folder / STAMPS_FILE
        self._rate_hz = rate_hz
        self._table = read_stamps(folder) if self._path.is_file() else None

    def of(self, number: int, sequence: int, lap: int) -> tuple[int, int]:
        """Time stamps of both exposures of a frame, µs."""
        if self._table is None:
            steady_us = device_us(sequence, self._rate_hz)
            return steady_us, steady_us
        if number not in self._table:
            raise CameraError(f"{self._path}: no row for frame {number}; complete the file or remove it")
        moved_us = lap * _lap_us(self._table)
        left_us, right_us = self._table[number]
        return left_us + moved_us, right_us + moved_us


def _lap_us(table: dict[int, tuple[int, int]]) -> int:
    """Time from the first frame of a lap to that of the next, one mean period after the last frame."""
    stamps = [left_us for left_us, _ in table.values()]
    span_us = max(stamps) - min(stamps)
    return span_us + span_us // max(1, len(stamps) - 1)


def read_stamps(folder: Path) -> dict[int, tuple[int, int]]:
    """Time stamps of both cameras by frame, µs, of a recording's `timestamps.csv`; none without that file.

    Raises
    ------
    CameraError
        The file is no table of whole numbers, or one is too large.
    """
    path = folder / STAMPS_FILE
    if not path.is_file():
        return {}
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
        return {int(row["frame"]): (int(row["left_us"]), int(row["right_us"])) for row in rows}
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as error:
        raise CameraError(
            f"{path}: not a table of whole numbers with the columns frame,left_us,right_us ({error!r}); "
            "correct the file or remove it"
        ) from error


class _Frames(Protocol):
    """Where the pairs of a recording are stored."""

    announced: int

    def read(self, position: int) -> tuple[int, Pictures] | None: ...

    def place(self, side: str, number: int) -> str: ...

    def close(self) -> None: ...


def _open_frames(folder: Path) -> _Frames:
    if all((folder / side).is_dir() for side in SIDES):
        return _PictureFrames(folder)
    left, right = (_video_named(folder, side) for side in SIDES)
    if left is not None and right is not None:
        return _VideoFrames(left, right)
    raise CameraError(
        f"{folder}: holds neither left/ and right/ with pictures nor left.mp4 and right.mp4; "
        "give the folder of a recording of two cameras"
    )


def _video_named(folder: Path, side: str) -> Path | None:
    """Video of one side, in letters of any case; the first by name if there are several."""
    videos = (path for path in sorted(folder.iterdir()) if path.suffix.lower() in VIDEO_SUFFIXES)
    return next((path for path in videos if path.stem.lower() == side), None)


class _PictureFrames:
    """Pictures named by frame number in `left/` and `right/`."""

    def __init__(self, folder: Path) -> None:
        left, right = (numbered_pictures(folder / side) for side in SIDES)
        if left.keys() != right.keys():
            alone = min(left.keys() ^ right.keys())
            raise CameraError(
                f"{folder}: {len(left)} left and {len(right)} right pictures do not form pairs, first at frame "
                f"{alone}; complete or remove the pictures that stand alone"
            )
        if not left:
            raise CameraError(f"{folder}: left/ and right/ hold no PNG or JPEG pictures; record some")
        self._paths = {number: (left[number], right[number]) for number in sorted(left)}
        self._numbers = list(self._paths)
        self._told = read_told_coding(folder)
        self._stored = StoredCodings(folder)
        self.announced = len(self._numbers)

    def read(self, position: int) -> tuple[int, Pictures] | None:
        if position >= self.announced:
            return None
        number = self._numbers[position]
        left, right = (
            self._stored.of(read_picture(path, self._told), path.stem, side, index)
            for index, (side, path) in enumerate(zip(SIDES, self._paths[number], strict=True))
        )
        return number, (left, right)

    def place(self, side: str, number: int) -> str:
        return str(self._paths[number][SIDES.index(side)])

    def close(self) -> None:
        pass


def numbered_pictures(folder: Path) -> dict[int, Path]:
    """Pictures of a folder by frame number; raises `CameraError` for names without a number and numbers twice.

    Hidden files, such as the `._000000.png` that a Macintosh leaves beside a picture, are passed over.
    """
    shown = (path for path in folder.iterdir() if not path.name.startswith("."))
    paths = [path for path in shown if path.suffix.lower() in PICTURE_SUFFIXES]
    numbered: dict[int, Path] = {}
    for path in sorted(paths):
        if not path.stem.isdecimal():
            raise CameraError(f"{path}: the name is not a frame number; name pictures 000000, 000001 and so on")
        if int(path.stem) in numbered:
            raise CameraError(f"{path}: a second picture of frame {int(path.stem)}; remove one of them")
        numbered[int(path.stem)] = path
    return numbered


class _VideoFrames:
    """Two video files."""

    def __init__(self, left: Path, right: Path) -> None:
        self._videos = VideoFile(left), VideoFile(right)
        self.announced, announced_right = (video.announced for video in self._videos)
        if self.announced != announced_right:
            raise CameraError(
                f"{left.parent}: {left.name} has {self.announced} frames and {right.name} {announced_right}; "
                "cut both to the same frames"
            )

    def read(self, position: int) -> tuple[int, Pictures] | None:
        left, right = (video.read(position) for video in self._videos)
        if left is None and right is None:
            return None
        if left is None or right is None:
            short = self.place("left" if left is None else "right", position)
            raise CameraError(f"{short}: ends before the other video; cut both to the same frames")
        return position, (left, right)

    def place(self, side: str, number: int) -> str:
        return f"{self._videos[SIDES.index(side)].path}, frame {number}"

    def close(self) -> None:
        for video in self._videos:
            video.close()
