"""`hotgauge capture recording`: what the cameras send in N seconds, without loss, as a recording.

Grey, colour and mosaic pictures become PNG; luma becomes FFV1 (RFC 9043), which keeps its planes, its range and its
matrix. How pictures were compressed on their way stands beside them (`measured/codings.json`), and whether the cameras
shared a clock stands with their time stamps, so that they are measured as if they came from the camera.
"""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple, Protocol, Self

from appliance.cameras.recording.stored_coding import CODINGS_FILE, MEASURED_FOLDER, PLAIN_CODINGS, codings_document
from appliance.cameras.recording.time_stamps import STAMPS_FILE, Stamps, stamps_table
from appliance.cameras.settings import LivenessSettings
from appliance.cameras.source import Frame, FramePair, PairSource, PictureSource
from appliance.capture.believed_pairs import believed
from appliance.capture.console import Console
from appliance.capture.error import CaptureError
from appliance.capture.luma_video import LumaVideo
from appliance.capture.picture_writer import keep_coding, write_picture, write_whole
from vision.sent_picture import Coding, SentPicture

SIDES = ("left", "right")
LOST_MOST_SHARE = 0.05  # chosen: from here on the sentence at the end says that the computer is too slow
FIRST_WITHIN_S = 30.0  # for the first picture to come


class Recorded(NamedTuple):
    """What was recorded.

    Attributes
    ----------
    frames, lost : int
        Exposures that were stored, and those that came meanwhile and were not.
    size : tuple of int
        (columns, rows).
    """

    frames: int
    lost: int
    size: tuple[int, int]


def record(
    source: PairSource | PictureSource, settings: LivenessSettings, folder: Path, seconds: float, console: Console
) -> Recorded:
    """Store what comes in so many seconds, counted from the first picture.

    Parameters
    ----------
    source : PairSource or PictureSource
        Not opened yet.
    settings : LivenessSettings
    folder : Path
        New or empty.
    seconds : float
    console : Console

    Raises
    ------
    CaptureError
        The folder is not empty or cannot be written, or no picture came.
    CameraError
        A camera is lost.
    """
    if folder.exists() and any(folder.iterdir()):
        raise CaptureError(f"{folder}: is not empty; give a new or empty folder")
    with source, _Recorder(folder) as recorder:
        for exposed in believed(source, settings, FIRST_WITHIN_S + seconds):
            if recorder.seconds_at(exposed) >= seconds:
                break
            recorder.add(exposed)
            console.live(f"{recorder.seconds_at(exposed):.1f} of {seconds:g} s, {recorder.lost} lost")
    return Recorded(recorder.frames, recorder.lost, recorder.size)


class _Track(Protocol):
    """Where the pictures of one camera go."""

    def write(self, number: int, picture: SentPicture, since_first_s: float, /) -> None: ...

    def close(self) -> None: ...


class _PngTrack:
    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def write(self, number: int, picture: SentPicture, _since_first_s: float) -> None:
        write_picture(self._folder / f"{number:06}.png", picture)

    def close(self) -> None:
        pass


class _Recorder:
    """Writes exposures as they come; both cameras' pictures at once."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._first: FramePair | Frame | None = None
        self._tracks: list[_Track] = []
        self._stamps: dict[int, Stamps] = {}
        self._codings: dict[str, list[Coding]] = {}
        self.frames = self.lost = 0
        self.size = (0, 0)

    def __enter__(self) -> Self:
        self._pool = ThreadPoolExecutor(len(SIDES))
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown()
        for track in self._tracks:
            track.close()
        if self._stamps:
            write_whole(self._folder / STAMPS_FILE, stamps_table(self._stamps))
        if self._codings:
            write_whole(self._folder / MEASURED_FOLDER / CODINGS_FILE, codings_document(self._codings))

    def seconds_at(self, exposed: FramePair | Frame) -> float:
        """Time from the first exposure to this one."""
        return 0.0 if self._first is None else exposed.exposed_monotonic_s - self._first.exposed_monotonic_s

    def add(self, exposed: FramePair | Frame) -> None:
        """Store an exposure; raises `CaptureError` where it cannot be written."""
        pictures = exposed.pictures
        if self._first is None:
            self._first = exposed
            self.size = pictures[0].size
            keep_coding(self._folder, pictures[0].coding)
            places = [self._folder / side for side in SIDES] if isinstance(exposed, FramePair) else [self._folder]
            self._tracks = [_track(place, picture) for place, picture in zip(places, pictures, strict=True)]
        number, since_s = self.frames, self.seconds_at(exposed)
        writes = [
            self._pool.submit(track.write, number, picture, since_s)
            for track, picture in zip(self._tracks, pictures, strict=True)
        ]
        for write in writes:
            write.result()
        if isinstance(exposed, FramePair):
            self._stamps[number] = Stamps.of(exposed)
        codings = [picture.coding for picture in pictures]
        if any(_is_told_apart(coding) for coding in codings):
            self._codings[f"{number:06}"] = codings
        self.lost = exposed.dropped - self._first.dropped
        self.frames += 1


def _is_told_apart(coding: Coding) -> bool:
    """Whether a coding is stored: a PNG of limited range was stretched, so that its code values are others."""
    return coding not in PLAIN_CODINGS and (coding.samples == "luma" or coding.full_range)


def _track(place: Path, picture: SentPicture) -> _Track:
    if picture.coding.samples == "luma":
        return LumaVideo(place.with_suffix(".mkv") if place.name in SIDES else place / "video.mkv", picture)
    return _PngTrack(place)
