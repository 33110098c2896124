"""References that follow the line: an ingot whose end is confirmed may become the reference of its kind.

A confirmed ingot is tried in place of the reference of its kind. It stays if the pair then judges the ingots that were
confirmed last, the commissioned references among them, clearly better than before. While the pair in use judges most
of them well, one that it takes for the other kind becomes no reference, and some of the worst judged never count: a
wrong confirmation now and then changes nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vision.ingot.classifiers.classifier import Picture
from vision.ingot.classifiers.names import ClassifierName
from vision.ingot.classifiers.similarity import USUAL_COMPARISON, Comparison, as_reference
from vision.ingot.face_judge import FaceJudge


@dataclass(frozen=True, slots=True, kw_only=True)
class LearningRule:
    """When a confirmed ingot becomes a reference; all numbers are chosen.

    Attributes
    ----------
    remembered : int
        Confirmed ingots of each kind that are judged, the last ones.
    least : int
        Confirmed ingots of each kind before which nothing is learned.
    left_out : float
        Share of the worst judged of each kind that does not count: three of thirteen ends, since one wrong word in
        twenty may come three times among so few.
    gain : float
        Least fall of the mean cross entropy, natural logarithm, of a pair that is adopted.
    good : float
        Mean cross entropy below which the pair in use judges well; a coin's is 0.69.
    """

    remembered: int = 12
    least: int = 4
    left_out: float = 0.25
    gain: float = 0.02
    good: float = 0.3


class ReferenceLearner:
    """References of one line that follow its confirmed ingots.

    Parameters
    ----------
    commissioned : tuple of ndarray of uint8
        Top and bottom, as they were recorded for this line; any size.
    current : tuple of ndarray of uint8
        The pair in use, learned before or the commissioned one.
    classifier : str
        Which judges; one of `CLASSIFIERS`.
    comparison : Comparison
        How similarities with the references are computed, as for `OrientationReader`.
    rule : LearningRule, optional
    confirmed : tuple of sequence of ndarray of uint8, optional
        Tops and bottoms that were confirmed before, oldest first.

    Attributes
    ----------
    current : tuple of ndarray of uint8, shape (64, 64)
        Top and bottom in use.
    """

    def __init__(
        self,
        commissioned: tuple[Picture, Picture],
        current: tuple[Picture, Picture],
        classifier: ClassifierName,
        comparison: Comparison = USUAL_COMPARISON,
        *,
        rule: LearningRule | None = None,
        confirmed: tuple[Sequence[Picture], Sequence[Picture]] = ((), ()),
    ) -> None:
        ends = as_reference(commissioned[0]), as_reference(commissioned[1])
        self.current = as_reference(current[0]), as_reference(current[1])
        self._classifier: ClassifierName = classifier
        self._comparison = comparison
        self._rule = rule or LearningRule()
        self._judge = FaceJudge(self.current, classifier, comparison)
        self._confirmed = {
            is_top: [_judged(self._judge, one) for one in (end, *before)]
            for is_top, end, before in zip((True, False), ends, confirmed, strict=True)
        }

    @property
    def confirmed(self) -> tuple[list[Picture], list[Picture]]:
        """Tops and bottoms that were confirmed last, oldest first, without the commissioned ones."""
        tops, bottoms = ([one.image for one in self._confirmed[is_top][1:]] for is_top in (True, False))
        return tops, bottoms

    def add(self, image: Picture, *, is_top: bool) -> bool:
        """Take a confirmed ingot into account.

        Parameters
        ----------
        image : ndarray of uint8, shape (64, 64)
            Its end, as `end_image` gives it.
        is_top : bool

        Returns
        -------
        bool
            Whether it became the reference of its kind in `current`.
        """
        new = _judged(self._judge, image)
        first, *others = [*self._confirmed[is_top], new]
        self._confirmed[is_top] = [first, *others[-self._rule.remembered :]]
        if min(len(ingots) for ingots in self._confirmed.values()) <= self._rule.least:
            return False
        loss = self._loss(self._confirmed)
        if loss < self._rule.good and (new.log_odds > 0) != is_top:
            return False
        top, bottom = self.current
        tried = (image, bottom) if is_top else (top, image)
        judge = FaceJudge(tried, self._classifier, self._comparison)
        judged = {kind: [_judged(judge, one.image) for one in ingots] for kind, ingots in self._confirmed.items()}
        if self._loss(judged) > loss - self._rule.gain:
            return False
        self.current, self._judge, self._confirmed = tried, judge, judged
        return True

    def _loss(self, confirmed: "dict[bool, list[_Confirmed]]") -> float:
        """Mean cross entropy over the confirmed ingots, both kinds alike, without the worst of each."""
        means: list[float] = []
        for is_top, ingots in confirmed.items():
            sign = 1 if is_top else -1
            losses = np.sort([np.logaddexp(0, -sign * one.log_odds) for one in ingots])
            means.append(float(losses[: len(losses) - int(self._rule.left_out * len(losses))].mean()))
        return 0.5 * sum(means)


class _Confirmed(NamedTuple):
    """Picture of a confirmed ingot, and how clearly the pair in use judges it."""

    image: Picture
    log_odds: float


def _judged(judge: FaceJudge, image: Picture) -> _Confirmed:
    return _Confirmed(image, judge.clearness(judge.face(image)))
