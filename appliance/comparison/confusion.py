"""Counts of right and wrong verdicts of a classifier."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class Confusion:
    """Counts of verdicts against truth.

    Attributes
    ----------
    top_as_top, top_as_bottom, bottom_as_top, bottom_as_bottom : int
    top_undecided, bottom_undecided : int
        Verdicts that are neither; they count as not recalled and not accurate.
    """

    top_as_top: int = 0
    top_as_bottom: int = 0
    bottom_as_top: int = 0
    bottom_as_bottom: int = 0
    top_undecided: int = 0
    bottom_undecided: int = 0

    @classmethod
    def of(cls, pairs: Iterable[tuple[str, str]]) -> "Confusion":
        """Count pairs of truth and verdict."""
        counts: dict[str, int] = {}
        for truth, verdict in pairs:
            name = f"{truth}_undecided" if verdict == "undecided" else f"{truth}_as_{verdict}"
            counts[name] = counts.get(name, 0) + 1
        return cls(**counts)

    def precision(self, orientation: Literal["top", "bottom"]) -> float:
        """Eq. 6.4: share of the verdicts for an orientation that are right; NaN without any."""
        right, wrong = (
            (self.top_as_top, self.bottom_as_top)
            if orientation == "top"
            else (self.bottom_as_bottom, self.top_as_bottom)
        )
        return _share(right, right + wrong)

    def recall(self, orientation: Literal["top", "bottom"]) -> float:
        """Eq. 6.5: share of the pictures of an orientation that are recognised; NaN without any."""
        if orientation == "top":
            return _share(self.top_as_top, self.top_as_top + self.top_as_bottom + self.top_undecided)
        return _share(self.bottom_as_bottom, self.bottom_as_bottom + self.bottom_as_top + self.bottom_undecided)

    @property
    def accuracy(self) -> float:
        """Eq. 6.6: share of all pictures that are right; NaN without any."""
        right = self.top_as_top + self.bottom_as_bottom
        wrong = self.top_as_bottom + self.bottom_as_top + self.top_undecided + self.bottom_undecided
        return _share(right, right + wrong)


def _share(part: int, whole: int) -> float:
    return part / whole if whole else float("nan")
