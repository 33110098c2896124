"""Learns references from the ingots that pass: who confirms them, and what is kept of them."""

import time
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.pacing import utc_ms
from appliance.ingot.learned_references import (
    Learned,
    current_number,
    keep,
    keep_confirmed,
    pair,
    read_confirmed,
)
from appliance.ingot.reader_setup import comparison_of
from appliance.ingot.settings import IngotSettings
from vision.ingot.agreement import Agreement
from vision.ingot.end_finder import End
from vision.ingot.end_image import end_image
from vision.ingot.reference_learner import LearningRule, ReferenceLearner
from vision.ingot.sequential_decision import IngotDecision
from vision.readings import OrientationReading

Confirmation = Literal["agreement", "top", "bottom"]


class Learning:
    """Follows the ingots of one line and keeps each reference that is better than the one in use.

    Parameters
    ----------
    references : Path
        Folder of the references; learned ones are kept in `learned` inside it.
    settings : IngotSettings
        Classifier and comparison, as of the reader.
    confirmation : {"agreement", "top", "bottom"}
        `agreement`: an ingot counts as confirmed when its pictures agree; else an operator says that all ingots show
        that end.

    Raises
    ------
    LearnedReferencesError
        The history cannot be read.
    """

    def __init__(self, references: Path, settings: IngotSettings, confirmation: Confirmation) -> None:
        self._references = references
        self._confirmation: Confirmation = confirmation
        self._number = current_number(references)
        self._learner = ReferenceLearner(
            pair(references, 0),
            pair(references, self._number),
            settings.classifier,
            comparison_of(settings.comparison),
            confirmed=read_confirmed(references),
        )
        self._agreement = Agreement()
        self._told = 0  # ingot that the operator's word was used for
        self._learned = 0

    def add(
        self, frame: int, picture: NDArray[np.uint8], reading: OrientationReading, current: IngotDecision | None
    ) -> bool:
        """Take a picture into account.

        Parameters
        ----------
        frame : int
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        reading : OrientationReading
            Of that picture.
        current : IngotDecision or None
            Of the ingot on the line, after that picture.

        Returns
        -------
        bool
            Whether a new pair is in use: the reader must be made anew.

        Raises
        ------
        OSError
            The confirmed end or the new pair cannot be written.
        """
        kind = self._confirmed(reading, current)
        if kind is None:
            return False
        end = End(reading.center_x, reading.center_y, reading.radius, "region")
        better = self._learner.add(end_image(picture, end), is_top=kind == "top")
        keep_confirmed(self._references, self._learner.confirmed)
        if not better:
            return False
        learned = Learned(
            kind=kind,
            confirmed_by="agreement" if self._confirmation == "agreement" else "operator",
            frame=frame,
            utc_ms=utc_ms(time.monotonic()),
            before=self._number,
        )
        self._number = keep(self._references, self._learner.current, learned)
        self._learned += 1
        return True

    @property
    def line(self) -> str:
        """What was learned, as a line for a person."""
        rule, (tops, bottoms) = LearningRule(), self._learner.confirmed
        return (
            f"  {self._learned} references learned; {len(tops)} confirmed tops and {len(bottoms)} bottoms are kept "
            f"(at least {rule.least} of each are needed, the last {rule.remembered} count)"
        )

    def _confirmed(self, reading: OrientationReading, current: IngotDecision | None) -> Literal["top", "bottom"] | None:
        """What the ingot on the line is known to show, once per ingot."""
        if self._confirmation == "agreement":
            return self._agreement.add(reading, current)
        if current is None or not reading.present or current.ingot == self._told:
            return None
        self._told = current.ingot
        return self._confirmation
