"""Summary of a measured recording, for the person at the terminal: how many values, which doubts, the likely cause."""

import math
import statistics
from collections import Counter

from vision.readings import SizeReading
from vision.reasons import REASONS, Reason

LIKELY_CAUSES = {
    Reason.NO_BAR: "no hot bar in the pictures? another rig, or left and right exchanged?",
    Reason.ONE_CAMERA: "is one camera covered, dark or turned away?",
    Reason.SEVERAL_BARS: "do other hot things cross the measuring region? calibrate with a smaller --region",
    Reason.EDGE_NOT_FOUND: "blurred pictures, or a bar too dark?",
    Reason.FIT_FAILED: "another rig, or left and right exchanged?",
    Reason.VIEWS_DISAGREE: "another rig, left and right exchanged, or a camera that moved since its calibration?",
    Reason.IMPLAUSIBLE: "another rig, or left and right exchanged?",
    Reason.EDGES_CLIPPED: "overexposed: shorten the exposure of the cameras",
    Reason.NO_WINDOWS: "a rough or hidden bar, or another rig?",
    Reason.NOT_ALIGNED: "another rig, or left and right exchanged?",
    Reason.CAMERA_MOVED: "a camera has moved: calibrate again",
    Reason.BAR_TOO_SHORT: "short bars? calibrate with a smaller --region",
}
"""What a person should look at first, by the reason that most frames without a value have."""
MANY_SHARE = 0.5  # chosen: of the frames without a value; a cause is told where half of them have its reason


class Summary:
    """Counts readings; `lines` says what became of them.

    Attributes
    ----------
    frames, valid : int
        Frames measured, and those of them with a value.
    """

    def __init__(self) -> None:
        self.frames = self.valid = 0
        self._diameters_mm: list[float] = []
        self._expanded_mm: list[float] = []
        self._without: Counter[Reason] = Counter()
        self._doubts: Counter[Reason] = Counter()
        self._decisions: Counter[str] = Counter()

    def add(self, reading: SizeReading, decision: object = None) -> None:
        """Count one reading.

        Parameters
        ----------
        reading : SizeReading
        decision : str or None
            As in the column of this name.
        """
        self.frames += 1
        self.valid += reading.valid
        counted = self._doubts if reading.valid else self._without
        counted.update(row.flag for row in REASONS if row.flag in reading.reasons)
        if reading.valid:
            self._diameters_mm.append(reading.diameter_mm)
            self._expanded_mm.append(reading.expanded_uncertainty_mm)
        if decision is not None:
            self._decisions[str(decision)] += 1

    @property
    def says_nothing(self) -> bool:
        """Whether no frame has a value."""
        return self.frames > 0 and not self.valid

    def lines(self, cause: str = "") -> list[str]:
        """Lines for the terminal.

        Parameters
        ----------
        cause : str
            Likely cause of missing values, where it is known better than from their reasons.
        """
        lines = [f"{self.valid} of {self.frames} frames have a value"]
        if self._diameters_mm:
            lowest, highest = min(self._diameters_mm), max(self._diameters_mm)
            mean = statistics.fmean(self._diameters_mm)
            stated = [expanded for expanded in self._expanded_mm if math.isfinite(expanded)]
            told = f"{statistics.median(stated):.2f} mm (median)" if stated else "not known"
            lines.append(f"  diameter {lowest:.2f} to {highest:.2f} mm, mean {mean:.2f} mm; U {told}")
        if self._decisions:
            lines.append(f"  decision: {_counts(self._decisions)}")
        if self._doubts:
            lines.append(f"  doubts: {_counts(_names(self._doubts))}")
        if self._without:
            lines.append(f"  without a value: {_counts(_names(self._without))}")
            likely = cause or self._cause()
            lines += [f"  likely cause: {likely}"] if likely else []
        return lines

    def _cause(self) -> str:
        """Cause of what most frames without a value show; an empty line between bars needs none."""
        reason, count = max(self._without.items(), key=lambda item: item[1])
        missing = self.frames - self.valid
        if count < MANY_SHARE * missing or (reason is Reason.NO_BAR and self.valid):
            return ""
        return LIKELY_CAUSES.get(reason, "")


def _names(counts: Counter[Reason]) -> Counter[str]:
    return Counter({row.name: counts[row.flag] for row in REASONS if row.flag in counts})


def _counts(counts: Counter[str]) -> str:
    return ", ".join(f"{name} in {count}" for name, count in counts.most_common())
