"""Recorded pictures of one camera: a folder of pictures, as a camera or one after the other."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.pacing import Pacer, utc_ms
from appliance.cameras.recording.pairs import Laps, numbered_pictures, unchanged_size
from appliance.cameras.recording.picture_file import read_picture, read_told_coding
from appliance.cameras.source import CameraError, Frame

Picture = NDArray[np.uint8]

DARKEST_MOST = 20  # pictures of the empty line that are averaged
SAME_LIGHT_SHARE = 0.005  # of full scale: mean light of empty pictures differs by less; a hot bar adds more


class PictureRecording:
    """All pictures of a recording of one camera in their order, without any timing.

    Parameters
    ----------
    folder : Path
        With PNG or JPEG pictures named by their frame number; what they cannot say of their coding stands in
        `coding.json`.

    Raises
    ------
    CameraError
        Folder missing or unreadable, no pictures in it, a name without a number, a number twice.
    """

    def __init__(self, folder: Path) -> None:
        try:
            self._paths = sorted(numbered_pictures(folder).items())
        except FileNotFoundError as error:
            raise CameraError(f"{folder}: no such folder; give the folder of a recording") from error
        except OSError as error:
            raise CameraError(f"{folder}: cannot be read ({error.strerror}); give a recording's folder") from error
        if not self._paths:
            raise CameraError(
                f"{folder}: holds no PNG or JPEG pictures; give the folder of a recording of one camera, "
                "with its pictures directly in it"
            )
        self._told = read_told_coding(folder)
        self._shape: tuple[int, int] | None = None

    def __len__(self) -> int:
        """Number of pictures."""
        return len(self._paths)

    def __iter__(self) -> Iterator[tuple[int, Picture]]:
        """Frame number and picture of each frame; raises `CameraError` like `read`."""
        position = 0
        while (frame := self.read(position)) is not None:
            yield frame
            position += 1

    def read(self, position: int) -> tuple[int, Picture] | None:
        """Frame number and picture at a position from 0; None after the end.

        Raises
        ------
        CameraError
            The picture is truncated or unreadable, or of another size than the first.
        """
        if position >= len(self._paths):
            return None
        number, path = self._paths[position]
        picture = read_picture(path, self._told)
        self._shape = unchanged_size(self._shape, picture, str(path))
        return number, picture.shown


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
        recording = PictureRecording(self._folder)
        self._laps = Laps(self._folder, len(recording), recording.read, self._loop)
        self._pacer = Pacer(self._rate_hz)
        self._last: int | None = None
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held open."""

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
            picture,
            sequence=sequence,
            exposed_monotonic_s=moment_s,
            exposed_utc_ms=utc_ms(moment_s),
            dropped=self._pacer.dropped,
            repeated=repeated,
        )


def darkest(frames: Iterable[tuple[int, Picture]]) -> list[Picture]:
    """Pictures of the empty line among those of a recording: a hot bar makes all others brighter.

    Parameters
    ----------
    frames : iterable of (int, ndarray of uint8)
        Number and picture of each frame; gone through once, and only those that may be empty are kept.
    """
    kept: list[tuple[float, Picture]] = []
    for _, picture in frames:
        kept.append((float(picture.mean()) / 255, picture))
        limit = min(light for light, _ in kept) + SAME_LIGHT_SHARE
        kept = [one for one in kept if one[0] <= limit][:DARKEST_MOST]
    return [picture for _, picture in kept]
