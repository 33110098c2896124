"""Pictures of the empty line between two barriers, and the gauge made from them, which measures its computing time."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from appliance.cameras.recording.picture_file import read_picture
from appliance.cameras.section import EmptyLine
from appliance.cameras.source import CameraError, Frame
from appliance.processes.preview import Line, Lines
from appliance.sizing.method import ScaleError, ScaleFile
from vision.pictures import is_false_colour
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sent_picture import Codes, SentPicture
from vision.sizing.conveyor.barriers import LEAST_SIDE_PX, Barriers
from vision.sizing.conveyor.gauge import ConveyorGauge

DRAWN_LEVEL = 230  # chosen: pixel value of the bar that `warm_up` draws
BARRIER_TROUBLES = {
    Reason.BARRIER_HIDDEN: "no pair of barriers shows along the line, or more than a fifth of one is hidden",
    Reason.BARRIER_BENT: "a barrier is not straight in the picture, or compression leaves too little of it",
}


class EmptyLineError(ScaleError):
    """The picture of the empty line cannot be used; the message says which, why and what to do."""

    fault = "empty_line_unusable"


def read_background(path: Path) -> EmptyLine:
    """Read the picture of the empty line from a file; raises `EmptyLineError`."""
    if not path.is_file():
        raise EmptyLineError(f"{path}: no such picture; give a picture of the empty line")
    try:
        return EmptyLine([read_picture(path)], str(path), path.read_bytes())
    except CameraError as error:
        raise EmptyLineError(str(error)) from error


class TimedConveyorGauge:
    """A conveyor gauge that returns its computing time and refuses pictures of another size than the empty line's.

    Parameters
    ----------
    empty : EmptyLine
    make : callable
        Makes the gauge from its pictures.

    Attributes
    ----------
    name : str
        File or camera that shows the empty line, for error sentences.

    Raises
    ------
    EmptyLineError
        The pictures are too small for barriers, or in false colours.
    """

    def __init__(self, empty: EmptyLine, make: Callable[[Sequence[SentPicture]], ConveyorGauge]) -> None:
        self.name = empty.name
        self._empty = empty.pictures[0]
        self._content = empty.content
        _check_size(self._empty, self.name)
        for picture in empty.pictures:
            self._check_colours(picture)
        self._gauge = make(empty.pictures)

    @property
    def scale_files(self) -> Sequence[ScaleFile]:
        """The picture of the empty line; none where the camera has its own pictures of it."""
        if not self._content:
            return ()
        return (ScaleFile("background", f"empty{Path(self.name).suffix}", self._content),)

    @property
    def carried(self) -> tuple[float, ...]:
        """Nothing: each picture is measured on its own."""
        return ()

    def resume(self, carried: Sequence[float]) -> None:
        """Nothing is carried over; see `TimedReader.resume`."""

    @property
    def barriers(self) -> Barriers | Reason:
        """Barriers of the empty line, or the reason why they cannot be used."""
        return self._gauge.barriers

    def check_barriers(self) -> None:
        """Raise `EmptyLineError` if the barriers are hidden or bent, for then no frame can be measured."""
        if isinstance(self.barriers, Reason):
            raise EmptyLineError(
                f"{self.name}: {BARRIER_TROUBLES[self.barriers]}; clear the line, or set sizing.conveyor.background "
                "to a picture of it without a bar"
            )

    def _check_colours(self, picture: SentPicture) -> None:
        if is_false_colour(picture.shown):
            raise EmptyLineError(
                f"{self.name}: the camera's pictures are in false colours, in which a colour is no light; "
                "have it send or record grey values"
            )

    def warm_up(self) -> None:
        """Measure a drawn bar once, so that code is compiled before the first picture."""
        drawn = self._empty.shown.copy()
        if isinstance(barriers := self.barriers, Barriers):
            for row, (left, right) in enumerate(barriers.columns(np.arange(len(drawn), dtype=np.float64))):
                drawn[row, round((2 * left + right) / 3) : round((left + 2 * right) / 3)] = DRAWN_LEVEL
        self._gauge.measure(drawn)

    def measure(self, picture: SentPicture | Codes) -> tuple[SizeReading, float]:
        """Measure one picture: reading and computing time, ms.

        Parameters
        ----------
        picture : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)

        Raises
        ------
        EmptyLineError
            The picture has another size than those of the empty line, or is in false colours.
        """
        picture = SentPicture.of(picture)
        self._check_colours(picture)
        if picture.size != self._empty.size:
            sizes = [f"{columns} x {rows}" for columns, rows in (self._empty.size, picture.size)]
            raise EmptyLineError(
                f"{self.name}: {sizes[0]} pixels, the camera's pictures have {sizes[1]}; "
                "give a picture of the empty line by this camera"
            )
        started_s = time.perf_counter()
        reading = self._gauge.measure(picture)
        return reading, 1000 * (time.perf_counter() - started_s)

    def measure_exposed(self, exposed: Frame) -> tuple[tuple[SizeReading, ...], float]:
        """Measure the one bar of an exposure: its reading alone, and computing time, ms; raises as `measure`."""
        reading, elapsed_ms = self.measure(*exposed.pictures)
        return (reading,), elapsed_ms

    def lines(self, _: SizeReading) -> Lines:
        """Both barriers of the empty line."""
        barriers = self.barriers
        if not isinstance(barriers, Barriers):
            return [[]]
        row = np.arange(0.0, self._empty.size[1], 8.0)
        return [[Line("region", np.column_stack([side, row])) for side in barriers.columns(row).T]]


def _check_size(picture: SentPicture, name: str) -> None:
    columns, rows = picture.size
    if min(rows, columns) < LEAST_SIDE_PX:
        raise EmptyLineError(
            f"{name}: pictures of {columns} x {rows} pixels are too small to show barriers; give pictures of at least "
            f"{LEAST_SIDE_PX} x {LEAST_SIDE_PX}"
        )
