"""References that follow the line: an ingot whose end is confirmed may become the reference of its kind.

A confirmed ingot is tried in place of the reference of its kind. It stays if the pair then judges the ingots that were
confirmed last, the commissioned references among them, clearly better than before. While the pair in use judges most
of them well, one that it takes for the other kind becomes no reference, and some of the worst judged never count: a
wrong confirmation now and then changes nothing.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vision.ingot.classifiers.classifier import Face, FaceClassifier, Picture
from vision.ingot.classifiers.names import ClassifierName
from vision.ingot.classifiers.similarity import as_reference, similarity
from vision.ingot.classifiers.ssim import DualSimilarity, SingleSimilarity
from vision.ingot.classifiers.table import CLASSIFIERS

CLEARNESS = 60.0  # chosen: log odds to a difference of similarities of 1; kinds differ by some 0.1


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
        Share of the worst judged of each kind that does not count.
    gain : float
        Least fall of the mean cross entropy, natural logarithm, of a pair that is adopted.
    good : float
        Mean cross entropy below which the pair in use judges well; a coin's is 0.69.
    """

    remembered: int = 12
    least: int = 4
    left_out: float = 0.2
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
    rule : LearningRule, optional

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
        rule: LearningRule | None = None,
    ) -> None:
        ends = as_reference(commissioned[0]), as_reference(commissioned[1])
        self.current = as_reference(current[0]), as_reference(current[1])
        self._classifier: type[FaceClassifier] = CLASSIFIERS[classifier]
        self._rule = rule or LearningRule()
        self._judge = _Judge(self._classifier, self.current)
        self._confirmed = {
            is_top: [_Confirmed(end, self._judge.log_odds(end))]
            for end, is_top in zip(ends, (True, False), strict=True)
        }

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
        log_odds = self._judge.log_odds(image)
        first, *others = [*self._confirmed[is_top], _Confirmed(image, log_odds)]
        self._confirmed[is_top] = [first, *others[-self._rule.remembered :]]
        if min(len(ingots) for ingots in self._confirmed.values()) <= self._rule.least:
            return False
        loss = self._loss(self._confirmed)
        if loss < self._rule.good and (log_odds > 0) != is_top:
            return False
        top, bottom = self.current
        tried = (image, bottom) if is_top else (top, image)
        judge = _Judge(self._classifier, tried)
        judged = {
            kind: [_Confirmed(one.image, judge.log_odds(one.image)) for one in ingots]
            for kind, ingots in self._confirmed.items()
        }
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
    """Picture of a confirmed ingot, and how the pair in use judges it."""

    image: Picture
    log_odds: float


class _Judge:
    """A classifier with its references."""

    def __init__(self, classifier: type[FaceClassifier], references: tuple[Picture, Picture]) -> None:
        self._references = references
        self._compares = issubclass(classifier, (SingleSimilarity, DualSimilarity))
        self._classifier = classifier(*references)

    def log_odds(self, image: Picture) -> float:
        if self._compares:  # the evidence of a verdict is the same for near and far
            top, bottom = (similarity(image, one) for one in self._references)
            return CLEARNESS * (top - bottom)
        return self._classifier.judge(Face(image, 0.0, 0.0)).log_odds
