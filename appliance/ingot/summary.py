"""Summary of a recording of ingots, for the person at the terminal."""

from collections import Counter

from vision.ingot.sequential_decision import IngotDecision
from vision.readings import OrientationReading
from vision.reasons import INGOT_REASONS, IngotReason

LIKELY_CAUSES = {
    IngotReason.NOTHING_HOT: "no ingot in the pictures? or is the crop (roi_crop) elsewhere, or the picture too dark?",
    IngotReason.HANGING: "is the crop (roi_crop) too low, so that its upper side cuts the ingots?",
    IngotReason.OUTSIDE: "do ends lie outside roi_centroid? correct roi.json or set ingot.centroid",
    IngotReason.TOO_SMALL: "are the ends smaller than ingot.limits allow?",
    IngotReason.TOO_LARGE: "are the ends larger than ingot.limits allow, or joined with glare?",
    IngotReason.TILTED: "is the camera turned, so that ingots do not lie upright in its picture?",
    IngotReason.NO_CIRCLE: "are the ends hidden or out of focus?",
}
"""What a person should look at first, by the reason that most frames have where no end was found."""


class Summary:
    """Counts frames and ingots; `lines` says what became of them."""

    def __init__(self) -> None:
        self._frames = self._ends = 0
        self._without: Counter[IngotReason] = Counter()
        self._ingots: Counter[str] = Counter()

    def add_frame(self, reading: OrientationReading) -> None:
        """Count one frame."""
        self._frames += 1
        self._ends += reading.present
        if not reading.present:
            self._without.update(row.flag for row in INGOT_REASONS if row.flag in reading.reasons)

    def add_ingot(self, decision: IngotDecision) -> None:
        """Count one ingot, decided or gone."""
        self._ingots[decision.orientation] += 1

    def lines(self) -> list[str]:
        """Lines for the terminal."""
        verdicts = ", ".join(f"{self._ingots[name]} {name}" for name in ("top", "bottom", "undecided"))
        lines = [f"{self._ends} of {self._frames} frames show an end", f"  {self._ingots.total()} ingots: {verdicts}"]
        if self._without and not self._ends:
            (reason, count), *_ = self._without.most_common()
            name = next(row.name for row in INGOT_REASONS if row.flag == reason)
            lines.append(f"  no end: {name} in {count}")
            lines += [f"  likely cause: {LIKELY_CAUSES[reason]}"] if reason in LIKELY_CAUSES else []
        return lines
