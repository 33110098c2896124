"""Recorded pictures of one camera: a folder of pictures, as a camera or one after the other."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Self

from appliance.cameras.pacing import Pacer, utc_ms
from appliance.cameras.recording.frames import open_single
from appliance.cameras.recording.names import stretch_starts
from appliance.cameras.recording.pairs import Laps, unchanged_size
from appliance.cameras.source import Frame
from vision.sent_picture import SentPicture

DARKEST_MOST = 20  # pictures of the empty line that are averaged
SAME_LIGHT_SHARE = 0.005  # of full scale: mean light of empty pictures differs by less; a hot bar adds more


class PictureRecording:
    """All pictures of a recording of one camera in their order, without any timing.

    Parameters
    ----------
    folder : Path
        With pictures named by their frame number, or with one video, or a video file; what pictures cannot say of
        their coding stands in `coding.json`.

    Attributes
    ----------
    numbers : sequence of int
        Frame number of each picture; of a video as its header announces them.

    Raises
    ------
    CameraError
        Folder missing or unreadable, no pictures in it, a name without a number, a number twice.
    """

    def __init__(self, folder: Path) -> None:
        self._frames = open_single(folder)
        self.numbers = self._frames.numbers
        self._shape: tuple[int, int] | None = None

    def __len__(self) -> int:
        """Number of pictures."""
        return len(self.numbers)

    def __iter__(self) -> Iterator[tuple[int, SentPicture]]:
        """Frame number and picture of each frame; raises `CameraError` like `read`."""
        position = 0
        while (frame := self.read(position)) is not None:
            yield frame
            position += 1

    def read(self, position: int) -> tuple[int, SentPicture] | None:
        """Frame number and picture at a position from 0; None after the end.

        Raises
        ------
        CameraError
            The picture is truncated or unreadable, or of another size than the first.
        """
        frame = self._frames.read(position)
        if frame is None:
            return None
        number, (picture,) = frame
        self._shape = unchanged_size(self._shape, picture, self._frames.place(0, number))
        return number, picture

    def close(self) -> None:
        """Let go of the files."""
        self._frames.close()


class PictureRecordingSource:
    """A recording of one camera as a camera; see `PictureSource`.

    Parameters
    ----------
    folder : Path
        As for `PictureRecording`.
    rate_hz : float
        Pictures per second in real time; 0 delivers every picture as fast as it is asked for.
    loop : bool
        Start again at the end, else raise `EndOfRecording`.
    """

    simulated = True

    def __init__(self, folder: Path, rate_hz: float, loop: bool) -> None:
        self._folder = folder
        self._rate_hz = rate_hz
        self._loop = loop

    def __enter__(self) -> Self:
        """Open the recording; raises `CameraError` like `PictureRecording`."""
        self._recording = PictureRecording(self._folder)
        numbers = self._recording.numbers
        self._laps = Laps(self._folder, len(numbers), self._recording.read, self._loop, stretch_starts(numbers))
        self._pacer = Pacer(self._rate_hz)
        self._last: int | None = None
        return self

    def __exit__(self, *_: object) -> None:
        """Close the files."""
        self._recording.close()

    def next(self, timeout_s: float) -> Frame | None:
        """Newest picture that is due; None when none is due in time.

        Raises
        ------
        EndOfRecording
            All pictures were played and `loop` is off.
        CameraError
            As in `PictureRecording.read`.
        """
        due = self._pacer.next_due(timeout_s)
        if due is None:
            return None
        sequence, moment_s = due
        number, picture = self._laps.frame(sequence)
        repeated, self._last = number == self._last, number
        return Frame(
            picture.shown,
            sent=picture,
            sequence=sequence,
            exposed_monotonic_s=moment_s,
            exposed_utc_ms=utc_ms(moment_s),
            dropped=self._pacer.dropped,
            repeated=repeated,
            stretch=self._laps.stretch,
        )


def darkest(frames: Iterable[tuple[int, SentPicture]]) -> list[SentPicture]:
    """Pictures of the empty line among those of a recording: a hot bar makes all others brighter.

    Parameters
    ----------
    frames : iterable of (int, SentPicture)
        Number and picture of each frame; gone through once, and only those that may be empty are kept.
    """
    kept: list[tuple[float, SentPicture]] = []
    for _, picture in frames:
        kept.append((float(picture.shown.mean()) / 255, picture))
        limit = min(light for light, _ in kept) + SAME_LIGHT_SHARE
        kept = [one for one in kept if one[0] <= limit][:DARKEST_MOST]
    return [picture for _, picture in kept]
