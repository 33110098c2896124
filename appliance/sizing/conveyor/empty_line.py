"""The empty line between two barriers: the pictures that show it, and the gauge that they make, with its clock."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.recording.pairs import read_picture
from appliance.cameras.source import CameraError
from appliance.sizing.method import ScaleError
from vision.pictures import is_false_colour
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.conveyor.barriers import LEAST_SIDE_PX, Barriers
from vision.sizing.conveyor.gauge import ConveyorGauge

Picture = NDArray[np.uint8]

DRAWN_LEVEL = 230  # of the bar that warms up
BARRIER_TROUBLES = {
    Reason.BARRIER_HIDDEN: "no pair of barriers shows along the line, or more than a fifth of one is hidden",
    Reason.BARRIER_BENT: "a barrier is not straight in the picture",
}


class EmptyLineError(ScaleError):
    """There is no usable picture of the empty line; the message says which, why and what to do."""

    fault = "empty_line_unusable"


def background(path: Path) -> list[Picture]:
    """The picture of the empty line that a file holds; raises `EmptyLineError`."""
    if not path.is_file():
        raise EmptyLineError(f"{path}: no such picture; give a picture of the empty line")
    try:
        return [read_picture(path)]
    except CameraError as error:
        raise EmptyLineError(str(error)) from error


class TimedConveyorGauge:
    """A gauge between barriers that takes its own time and refuses pictures that its empty line is not for.

    Parameters
    ----------
    empty : list of ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    name : str
        Where they come from, for the sentence that refuses.
    make : callable
        Makes the gauge from them.

    Attributes
    ----------
    name : str

    Raises
    ------
    EmptyLineError
        The pictures are too small for barriers, or a palette has coloured them.
    """

    def __init__(self, empty: list[Picture], name: str, make: Callable[[list[Picture]], ConveyorGauge]) -> None:
        _check_usable(empty[0], name)
        self._empty = empty[0]
        self.name = name
        self._gauge = make(empty)

    @property
    def barriers(self) -> Barriers | Reason:
        """Barriers of the empty line, or why there are none."""
        return self._gauge.barriers

    def check_barriers(self) -> None:
        """Raise `EmptyLineError` when the barriers are hidden or bent, so that nothing can ever be measured."""
        if isinstance(self.barriers, Reason):
            raise EmptyLineError(
                f"{self.name}: {BARRIER_TROUBLES[self.barriers]}; clear the line, or set sizing.conveyor.background "
                "to a picture of it without a bar"
            )

    def warm_up(self) -> None:
        """Compile and load all that measuring needs, on a drawn bar, so that the first picture does not wait for it."""
        drawn = self._empty.copy()
        if isinstance(barriers := self.barriers, Barriers):
            for row, (left, right) in enumerate(barriers.columns(np.arange(len(drawn), dtype=np.float64))):
                drawn[row, round((2 * left + right) / 3) : round((left + 2 * right) / 3)] = DRAWN_LEVEL
        self._gauge.measure(drawn)

    def measure(self, picture: Picture) -> tuple[SizeReading, float]:
        """Reading of one picture, and the milliseconds that it took.

        Parameters
        ----------
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)

        Raises
        ------
        EmptyLineError
            The picture has another size than those of the empty line.
        """
        if picture.shape[:2] != self._empty.shape[:2]:
            sizes = [f"{columns} x {rows}" for rows, columns in (self._empty.shape[:2], picture.shape[:2])]
            raise EmptyLineError(
                f"{self.name}: {sizes[0]} pixels, the camera's pictures have {sizes[1]}; "
                "give a picture of the empty line by this camera"
            )
        started_s = time.perf_counter()
        reading = self._gauge.measure(picture)
        return reading, 1000 * (time.perf_counter() - started_s)


def _check_usable(picture: Picture, name: str) -> None:
    rows, columns = picture.shape[:2]
    if min(rows, columns) < LEAST_SIDE_PX:
        raise EmptyLineError(
            f"{name}: pictures of {columns} x {rows} pixels are too small to show barriers; give pictures of at least "
            f"{LEAST_SIDE_PX} x {LEAST_SIDE_PX}"
        )
    if is_false_colour(picture):
        raise EmptyLineError(
            f"{name}: a palette has coloured the pictures, and colours do not follow light; let the camera give grey"
        )
