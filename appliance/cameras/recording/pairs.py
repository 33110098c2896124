"""Recorded image pairs: two folders of pictures or two video files, as a camera or one after the other."""

import bisect
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Generic, Self, TypeVar

from appliance.cameras.pacing import Pacer, device_us, utc_ms
from appliance.cameras.recording.frames import open_pair
from appliance.cameras.recording.names import stretch_starts
from appliance.cameras.recording.time_stamps import STAMPS_FILE, Stamps, read_stamps
from appliance.cameras.source import CameraError, EndOfRecording, FramePair
from vision.sent_picture import SentPicture

Recorded = TypeVar("Recorded")


class Recording:
    """All image pairs of a recording in their order, without any timing.

    Parameters
    ----------
    folder : Path
        With `left/` and `right/` (pictures named by their frame number), or pictures or videos whose names say left
        and right (see `names`); what pictures cannot say of their coding stands in `coding.json`.

    Attributes
    ----------
    numbers : sequence of int
        Frame number of each pair; of videos as their headers announce them.

    Raises
    ------
    CameraError
        Folder missing or unreadable, no recording in it, names or numbers of left and right pictures differ, a video
        cannot be opened.
    """

    def __init__(self, folder: Path) -> None:
        try:
            self._frames = open_pair(folder)
        except OSError as error:
            place = error.filename or folder
            raise CameraError(f"{place}: cannot be read ({error.strerror}); check its permissions") from error
        self.numbers = self._frames.numbers
        self._shape: tuple[int, int] | None = None

    def __len__(self) -> int:
        """Number of pairs; of videos as their headers announce it."""
        return len(self.numbers)

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
        number, (left, right) = pair
        for side, picture in enumerate((left, right)):
            self._shape = unchanged_size(self._shape, picture, self._frames.place(side, number))
        return number, left, right

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
    starts : iterable of int
        Positions at which the recording jumps to another time.

    Attributes
    ----------
    lap : int
        Times that the recording has been started again.
    stretch : int
        Number of the stretch without a break: each lap and each start in it begins another.
    """

    def __init__(
        self, folder: Path, length: int, read: Callable[[int], Recorded | None], loop: bool, starts: Iterable[int] = ()
    ) -> None:
        self._folder = folder
        self._length = length
        self._starts = sorted(starts)
        self._read = read
        self._loop = loop
        self._start = 0
        self.lap = self.stretch = 0

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
        begun = bisect.bisect(self._starts, sequence - self._start)
        self.stretch = self.lap * (len(self._starts) + 1) + begun
        return frame


class RecordingSource:
    """A recording as a camera; see `PairSource`.

    Parameters
    ----------
    folder : Path
        As for `Recording`; with a `timestamps.csv` for the device time stamps, which are otherwise those of a
        steady clock.
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
        self._last: int | None = None
        self._stamps = _Stamps(self._folder, self._rate_hz)
        numbers = self._recording.numbers
        starts = stretch_starts(self._stamps.moments(numbers))
        self._laps = Laps(self._folder, len(numbers), self._recording.read, self._loop, starts)
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
        stamps = self._stamps.of(number, sequence, self._laps.lap)
        repeated, self._last = number == self._last, number
        return FramePair(
            left.shown,
            right.shown,
            sent=(left, right),
            sequence=sequence,
            left_us=stamps.left_us,
            right_us=stamps.right_us,
            exposed_monotonic_s=moment_s,
            exposed_utc_ms=utc_ms(moment_s),
            dropped=self._pacer.dropped,
            repeated=repeated,
            stamped=stamps.stamped,
            stretch=self._laps.stretch,
        )


class _Stamps:
    """Device time stamps: those of `timestamps.csv`, moved on by each lap, or those of a steady clock."""

    def __init__(self, folder: Path, rate_hz: float) -> None:
        self._path = folder / STAMPS_FILE
        self._rate_hz = rate_hz
        self._table = read_stamps(folder) if self._path.is_file() else None

    def moments(self, numbers: Iterable[int]) -> list[int]:
        """What tells how much time lies between frames: their stamps where there are any, else their numbers."""
        table = self._table
        return list(numbers) if table is None else [table[number][0] for number in numbers if number in table]

    def of(self, number: int, sequence: int, lap: int) -> Stamps:
        """Time stamps of both exposures of a frame."""
        if self._table is None:
            steady_us = device_us(sequence, self._rate_hz)
            return Stamps(steady_us, steady_us, stamped=False)
        if number not in self._table:
            raise CameraError(f"{self._path}: no row for frame {number}; complete the file or remove it")
        moved_us = lap * _lap_us(self._table)
        stamps = self._table[number]
        return stamps._replace(left_us=stamps.left_us + moved_us, right_us=stamps.right_us + moved_us)


def _lap_us(table: dict[int, Stamps]) -> int:
    """Time from the first frame of a lap to that of the next, one mean period after the last frame."""
    stamps = [stamps.left_us for stamps in table.values()]
    span_us = max(stamps) - min(stamps)
    return span_us + span_us // max(1, len(stamps) - 1)
