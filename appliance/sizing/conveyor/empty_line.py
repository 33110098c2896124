"""Pictures of the empty line between two barriers, and the gauge made from them, which measures its computing time."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.cameras.recording.picture_file import read_picture
from appliance.cameras.source import CameraError, Frame
from appliance.processes.preview import Line, Lines
from appliance.sizing.method import ScaleError, ScaleFile
from vision.pictures import is_false_colour
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.conveyor.barriers import LEAST_SIDE_PX, Barriers
from vision.sizing.conveyor.gauge import ConveyorGauge

Picture = NDArray[np.uint8]

DRAWN_LEVEL = 230  # chosen: pixel value of the bar that `warm_up` draws
BARRIER_TROUBLES = {
    Reason.BARRIER_HIDDEN: "no pair of barriers shows along the line, or more than a fifth of one is hidden",
    Reason.BARRIER_BENT: "a barrier is not straight in the picture",
}


class EmptyLineError(ScaleError):
    """The picture of the empty line cannot be used; the message says which, why and what to do."""

    fault = "empty_line_unusable"


def read_background(path: Path) -> list[Picture]:
    """Read the picture of the empty line from a file, as a list of one; raises `EmptyLineError`."""
    if not path.is_file():
        raise EmptyLineError(f"{path}: no such picture; give a picture of the empty line")
    try:
        return [read_picture(path).shown]
    except CameraError as error:
        raise EmptyLineError(str(error)) from error


class TimedConveyorGauge:
    """A conveyor gauge that returns its computing time and refuses pictures of another size than the empty line's.

    Parameters
    ----------
    empty : list of ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Pictures of the empty line.
    name : str
        File or camera they come from, for error sentences.
    make : callable
        Makes the gauge from them.

    Attributes
    ----------
    name : str

    Raises
    ------
    EmptyLineError
        The pictures are too small for barriers, or in false colours.
    """

    def __init__(self, empty: list[Picture], name: str, make: Callable[[list[Picture]], ConveyorGauge]) -> None:
        _check_size(empty[0], name)
        self._empty = empty[0]
        self._is_one = len(empty) == 1
        self.name = name
        for picture in empty:
            self._check_colours(picture)
        self._gauge = make(empty)

    @property
    def scale_files(self) -> Sequence[ScaleFile]:
        """The picture of the empty line; none where the camera has its own pictures of it."""
        if not self._is_one:
            return ()
        return (ScaleFile("background", "empty.png", cv2.imencode(".png", self._empty)[1].tobytes()),)

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

    def _check_colours(self, picture: Picture) -> None:
        if is_false_colour(picture):
            raise EmptyLineError(
                f"{self.name}: the camera's pictures are in false colours, in which a colour is no light; "
                "have it send or record grey values"
            )

    def warm_up(self) -> None:
        """Measure a drawn bar once, so that code is compiled before the first picture."""
        drawn = self._empty.copy()
        if isinstance(barriers := self.barriers, Barriers):
            for row, (left, right) in enumerate(barriers.columns(np.arange(len(drawn), dtype=np.float64))):
                drawn[row, round((2 * left + right) / 3) : round((left + 2 * right) / 3)] = DRAWN_LEVEL
        self._gauge.measure(drawn)

    def measure(self, picture: Picture) -> tuple[SizeReading, float]:
        """Measure one picture: reading and computing time, ms.

        Parameters
        ----------
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)

        Raises
        ------
        EmptyLineError
            The picture has another size than those of the empty line, or is in false colours.
        """
        self._check_colours(picture)
        if picture.shape[:2] != self._empty.shape[:2]:
            sizes = [f"{columns} x {rows}" for rows, columns in (self._empty.shape[:2], picture.shape[:2])]
            raise EmptyLineError(
                f"{self.name}: {sizes[0]} pixels, the camera's pictures have {sizes[1]}; "
                "give a picture of the empty line by this camera"
            )
        started_s = time.perf_counter()
        reading = self._gauge.measure(picture)
        return reading, 1000 * (time.perf_counter() - started_s)

    def measure_exposed(self, exposed: Frame) -> tuple[tuple[SizeReading, ...], float]:
        """Measure the one bar of an exposure: its reading alone, and computing time, ms; raises as `measure`."""
        reading, elapsed_ms = self.measure(exposed.picture)
        return (reading,), elapsed_ms

    def lines(self, _: SizeReading) -> Lines:
        """Both barriers of the empty line."""
        barriers = self.barriers
        if not isinstance(barriers, Barriers):
            return [[]]
        row = np.arange(0.0, len(self._empty), 8.0)
        return [[Line("region", np.column_stack([side, row])) for side in barriers.columns(row).T]]


def _check_size(picture: Picture, name: str) -> None:
    rows, columns = picture.shape[:2]
    if min(rows, columns) < LEAST_SIDE_PX:
        raise EmptyLineError(
            f"{name}: pictures of {columns} x {rows} pixels are too small to show barriers; give pictures of at least "
            f"{LEAST_SIDE_PX} x {LEAST_SIDE_PX}"
        )
