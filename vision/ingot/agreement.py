"""Which ingots are sure enough to be learned from: their pictures agree, many of them."""

from dataclasses import dataclass
from typing import Literal

from vision.ingot.sequential_decision import IngotDecision
from vision.readings import OrientationReading

AGREED_FRAMES = 12  # chosen: pictures of an ingot on the line
AGREED_SHARE = 0.95  # chosen: of them that are what was decided
LEAST_CONFIDENCE = 99.0  # chosen: percent, of the decision


@dataclass(slots=True)
class Agreement:
    """Counts the pictures of the ingot on the line that agree with its decision."""

    _ingot: int = 0
    _frames: int = 0
    _tops: int = 0
    _told: bool = False

    def add(self, reading: OrientationReading, current: IngotDecision | None) -> Literal["top", "bottom"] | None:
        """Count a picture.

        Parameters
        ----------
        reading : OrientationReading
        current : IngotDecision or None
            Of the ingot on the line, after this picture.

        Returns
        -------
        {"top", "bottom"} or None
            Once per ingot, with the picture from which on it counts as confirmed.
        """
        if current is None or not reading.present:
            return None
        if current.ingot != self._ingot:
            self._ingot, self._frames, self._tops, self._told = current.ingot, 0, 0, False
        self._frames += 1
        self._tops += reading.orientation == "top"
        if self._told or self._frames < AGREED_FRAMES or current.confidence < LEAST_CONFIDENCE:
            return None
        agreeing = {"top": self._tops, "bottom": self._frames - self._tops, "undecided": 0}[current.orientation]
        if current.orientation == "undecided" or agreeing < AGREED_SHARE * self._frames:
            return None
        self._told = True
        return current.orientation
