"""Leaves the newest pictures of a station in the runtime directory, for people; measuring never waits for it.

About once a second the pictures of one exposure are shrunk, drawn upon and written by a thread of low priority, as one
file, so that pictures and figures are of one moment. What comes while it works is left out.
"""

import base64
import contextlib
import json
import logging
import math
import os
import queue
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.files.atomic_file import whole_file
from appliance.files.runtime_folder import preview_file, runtime_folder

PERIOD_S = 1.0  # chosen: people aim and focus by it
WIDTH_PX = 960  # chosen: as wide as half a screen
JPEG_QUALITY = 80  # chosen
SHARPNESS_ROWS = 128  # chosen
PREVIEW_MODE = 0o640
NICENESS = 10  # of the thread: measuring goes first

# blue-green-red, told apart without red and green: Okabe and Ito's blue, orange and sky blue
COLOURS = {"region": (178, 114, 0), "edge": (0, 159, 230), "board": (233, 180, 86), "end": (0, 159, 230)}

Picture = NDArray[np.uint8]

logger = logging.getLogger("hotgauge.preview")


class Line(NamedTuple):
    """A line that is drawn into a picture.

    Attributes
    ----------
    kind : {"region", "edge", "board", "end"}
    points_px : ndarray of float64, shape (n, 2)
        x, y in pixels of the whole picture; NaN outside what the camera sees.
    """

    kind: Literal["region", "edge", "board", "end"]
    points_px: NDArray[np.float64]


Lines = Sequence[Sequence[Line]]
"""Lines of each picture, left first."""


class _Shown(NamedTuple):
    pictures: Sequence[Picture]
    lines: Callable[[], Lines]
    figures: Mapping[str, float | None]


class PreviewWriter:
    """Writes the previews of one station; without a runtime directory it writes nothing.

    Parameters
    ----------
    station : {"sizing", "ingot"}
    clock : callable
        Monotonic time, seconds.
    """

    def __init__(self, station: str, clock: Callable[[], float] = time.monotonic) -> None:
        folder = runtime_folder()
        self._file = None if folder is None else preview_file(folder, station)
        self._clock = clock
        self._due_s = -math.inf
        self._waiting: queue.Queue[_Shown] = queue.Queue(maxsize=1)
        self._thread: threading.Thread | None = None

    def offer(
        self, pictures: Sequence[Picture], lines: Callable[[], Lines], figures: Mapping[str, float | None]
    ) -> None:
        """Have the pictures written if one is due and the one before is done; never waits, never raises.

        Parameters
        ----------
        pictures : sequence of ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
            Left first; they must not change any more.
        lines : callable
            Gives what is drawn into them; called in the thread.
        figures : mapping of str to float or None
            What stands beside them; NaN is written as None.
        """
        now_s = self._clock()
        if self._file is None or now_s < self._due_s or self._waiting.full():
            return
        self._due_s = now_s + PERIOD_S
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, daemon=True, name="preview")
            self._thread.start()
        with contextlib.suppress(queue.Full):
            self._waiting.put_nowait(_Shown(pictures, lines, figures))

    def _run(self) -> None:
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)  # of this thread alone, on Linux
        while True:
            shown = self._waiting.get()
            try:
                self._write(shown)
            except Exception:  # what cannot be drawn ends neither the previews after it nor measuring
                logger.exception("a preview was left out")

    def _write(self, shown: _Shown) -> None:
        if self._file is None:
            return
        document = to_document(shown.pictures, shown.lines(), shown.figures)
        with contextlib.suppress(OSError), whole_file(self._file, PREVIEW_MODE) as file:
            json.dump(document, file)


def to_document(pictures: Sequence[Picture], lines: Lines, figures: Mapping[str, float | None]) -> dict[str, Any]:
    """Contents of a preview file: pictures as JPEG in base64, and figures.

    Parameters
    ----------
    pictures : sequence of ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    lines : sequence of sequence of Line
        For each picture.
    figures : mapping of str to float or None
    """
    known = {name: value if value is not None and math.isfinite(value) else None for name, value in figures.items()}
    measured = {f"sharpness_{number}": sharpness(picture) for number, picture in enumerate(pictures)}
    drawn = [_jpeg(picture, own) for picture, own in zip(pictures, lines, strict=True)]
    return {"pictures": [base64.b64encode(one).decode("ascii") for one in drawn], "figures": known | measured}


def sharpness(picture: Picture) -> float:
    """Sharpness for focusing: steepest step from pixel to pixel over the picture's range of light, 0 to 1.

    The 99.9th percentile of the horizontal steps in the middle half, over the 99.9th minus the 0.1st percentile of the
    levels there; an edge that is sharp to the pixel gives 1. It compares settings of one lens before one scene, no
    more. Of the middle half about SHARPNESS_ROWS rows are enough.

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    """
    rows, columns = picture.shape[:2]
    apart = max(1, rows // 2 // SHARPNESS_ROWS)
    middle = picture[rows // 4 : -(rows // 4) or None : apart, columns // 4 : -(columns // 4) or None]
    grey = middle if middle.ndim == 2 else middle.max(axis=2)
    levels = np.percentile(grey, (0.1, 99.9))
    steps = np.abs(np.diff(grey.astype(np.int16), axis=1))
    span = float(levels[1] - levels[0])
    return round(float(np.percentile(steps, 99.9)) / span, 3) if span > 0 else 0.0


def _jpeg(picture: Picture, lines: Sequence[Line]) -> bytes:
    scale = min(1.0, WIDTH_PX / picture.shape[1])
    size = round(picture.shape[1] * scale), round(picture.shape[0] * scale)
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    shown = cv2.cvtColor(small, cv2.COLOR_GRAY2BGR) if small.ndim == 2 else small
    for line in lines:
        points = line.points_px[np.isfinite(line.points_px).all(axis=1)] * scale
        if len(points) > 1:
            cv2.polylines(shown, [np.rint(points).astype(np.int32)], False, COLOURS[line.kind], 2, cv2.LINE_AA)
    _, data = cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return data.tobytes()
