"""Annotated pictures of `orient`: each frame with its end and verdict, and a strip of all ends."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.ingot.classifiers.similarity import SIZE
from vision.ingot.sequential_decision import IngotDecision
from vision.readings import OrientationReading

Picture = NDArray[np.uint8]

# blue-green-red; Okabe and Ito's vermilion, sky blue and yellow, told apart without red and green
COLOURS = {"top": (0, 94, 213), "bottom": (233, 180, 86), "undecided": (66, 228, 240)}
LEGEND_PX = 34  # height, below the strip
ENDS_IN_A_ROW = 12  # of the strip
BORDER_PX = 3
LARGEST_STRIP = 600  # ends; later ones are not in the strip


class Plot:
    """Writes each annotated frame at once, and the strip at the end.

    Parameters
    ----------
    folder : Path
        Made if it is missing; raises `OSError`.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self._ends: list[Picture] = []

    def add(self, frame: int, picture: Picture, reading: OrientationReading, ingot: IngotDecision | None) -> None:
        """Write one annotated frame.

        Parameters
        ----------
        frame : int
            Number of the frame.
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        reading : OrientationReading
        ingot : IngotDecision or None
            Decision on the ingot so far; None without an ingot.
        """
        colours = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR) if picture.ndim == 2 else picture.copy()
        shown = np.asarray(colours, np.uint8)
        colour = COLOURS[reading.orientation]
        if reading.present:
            if len(self._ends) < LARGEST_STRIP:
                self._ends.append(_framed(shown, reading, colour))
            center = round(reading.center_x), round(reading.center_y)
            cv2.circle(shown, center, round(reading.radius), colour, 2, cv2.LINE_AA)
        for line, text in enumerate(_lines(frame, reading, ingot)):
            cv2.putText(shown, text, (10, 24 + 24 * line), cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, 1, cv2.LINE_AA)
        _write(self._folder / f"{frame:06d}.jpg", shown)

    def write_strip(self) -> None:
        """Write the strip of all ends, each framed in the colour of its verdict, and a legend; nothing without ends."""
        if not self._ends:
            return
        empty = np.zeros_like(self._ends[0])
        ends = self._ends + [empty] * (-len(self._ends) % ENDS_IN_A_ROW)
        rows = [np.hstack(ends[start : start + ENDS_IN_A_ROW]) for start in range(0, len(ends), ENDS_IN_A_ROW)]
        strip = np.vstack(rows)
        _write(self._folder / "ends.png", np.vstack([strip, _legend(strip.shape[1])]))


def _legend(width_px: int) -> Picture:
    legend = np.zeros((LEGEND_PX, width_px, 3), np.uint8)
    for place, (verdict, colour) in enumerate(COLOURS.items()):
        left = 10 + 260 * place
        cv2.rectangle(legend, (left, 9), (left + 16, 25), colour, cv2.FILLED)
        words = "undecided" if verdict == "undecided" else f"{verdict} faces the line"
        cv2.putText(legend, words, (left + 24, 23), cv2.FONT_HERSHEY_SIMPLEX, 0.5, colour, 1, cv2.LINE_AA)
    return legend


def _framed(picture: Picture, reading: OrientationReading, colour: tuple[int, int, int]) -> Picture:
    half = max(1, round(reading.radius))
    square = cv2.getRectSubPix(picture, (2 * half, 2 * half), (reading.center_x, reading.center_y))
    square = cv2.resize(square, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
    return np.asarray(
        cv2.copyMakeBorder(square, BORDER_PX, BORDER_PX, BORDER_PX, BORDER_PX, cv2.BORDER_CONSTANT, value=colour),
        np.uint8,
    )


def _lines(frame: int, reading: OrientationReading, ingot: IngotDecision | None) -> list[str]:
    seen = f"frame {frame}: " + (reading.orientation if reading.present else "no end")
    if reading.reasons.names:
        seen += f" ({', '.join(reading.reasons.names)})"
    if ingot is None:
        return [seen]
    decided = f", decided at {ingot.decided_frame}" if ingot.decided_frame is not None else ""
    return [seen, f"ingot {ingot.ingot}: {ingot.orientation}, {ingot.confidence:.1f} %{decided}"]


def _write(file: Path, picture: Picture) -> None:
    _, data = cv2.imencode(file.suffix, picture)
    file.write_bytes(data.tobytes())
