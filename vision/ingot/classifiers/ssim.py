"""The dissertation's two classifiers of a face, by its structural similarity with references.

Evidence of a verdict is what the dissertation's own confusion matrices say of it (figures 6.17 and 6.21, 1,329 ends of
tops that look like the reference): the logarithm of the share of tops that get this verdict over that of bottoms, with
half an end added to each count (Jeffreys' prior), since a count of 0 is no certainty. On simulated lines whose tops
differ from the reference a similarity says nothing, or the opposite (docs/methods/orientation.md).
"""

import math
from typing import NamedTuple

from vision.ingot.classifiers.classifier import Face, FaceClassifier, Orientation, Picture, Verdict
from vision.ingot.classifiers.similarity import USUAL_COMPARISON

CLEARNESS_PER_SIMILARITY = 60.0  # chosen: log odds to a difference of similarities of 1; kinds differ by some 0.1
SIMILARITY_THRESHOLD = USUAL_COMPARISON.threshold  # the dissertation's, between top and bottom


class VerdictCounts(NamedTuple):
    """A confusion matrix: true end and verdict."""

    top_as_top: int
    top_as_bottom: int
    bottom_as_top: int
    bottom_as_bottom: int

    def log_odds(self, verdict: Orientation) -> float:
        """Natural logarithm of the odds of a top against a bottom that a verdict gives."""
        tops, bottoms = self.top_as_top + self.top_as_bottom + 1, self.bottom_as_top + self.bottom_as_bottom + 1
        of_top = self.top_as_top if verdict == "top" else self.top_as_bottom
        of_bottom = self.bottom_as_top if verdict == "top" else self.bottom_as_bottom
        return math.log((of_top + 0.5) / tops) - math.log((of_bottom + 0.5) / bottoms)


SINGLE_COUNTS = VerdictCounts(475, 109, 0, 745)  # figure 6.17
DUAL_COUNTS = VerdictCounts(560, 24, 0, 745)  # figure 6.21 and table 6.3


def single(ssim_top: float, threshold: float = SIMILARITY_THRESHOLD) -> Orientation:
    """The dissertation's first classifier: top where the similarity to the top reference exceeds a threshold.

    Parameters
    ----------
    ssim_top : float
    threshold : float
    """
    return "top" if ssim_top > threshold else "bottom"


def dual(ssim_top: float, ssim_bottom: float) -> Orientation:
    """Algorithm 17 of the dissertation: the more similar reference, the top when both are equally so.

    Parameters
    ----------
    ssim_top, ssim_bottom : float
    """
    return "top" if ssim_top >= ssim_bottom else "bottom"


class SingleSimilarity(FaceClassifier):
    """`single` as a classifier; the references have been compared before.

    Parameters
    ----------
    top, bottom : ndarray of uint8, shape (64, 64)
    threshold : float
    """

    def __init__(self, top: Picture, bottom: Picture, threshold: float = SIMILARITY_THRESHOLD) -> None:  # noqa: ARG002
        self._threshold = threshold

    def judge(self, face: Face) -> Verdict:
        """Top above the threshold, with the evidence of this verdict."""
        orientation = single(face.ssim_top, self._threshold)
        return Verdict(orientation, SINGLE_COUNTS.log_odds(orientation))


class DualSimilarity(FaceClassifier):
    """`dual` as a classifier; the references have been compared before.

    Parameters
    ----------
    top, bottom : ndarray of uint8, shape (64, 64)
    """

    def __init__(self, top: Picture, bottom: Picture) -> None:
        """Nothing of the references is needed beside the similarities."""

    def judge(self, face: Face) -> Verdict:
        """The more similar reference, with the evidence of this verdict."""
        orientation = dual(face.ssim_top, face.ssim_bottom)
        return Verdict(orientation, DUAL_COUNTS.log_odds(orientation))

    def clearness(self, face: Face) -> float:
        """By the difference of both similarities; the evidence of a verdict is the same for a small one and a large.

        On six simulated lines with a new camera, references learned by it had 70 % of the ends right, by the evidence
        alone 52 %, as commissioned 50 %. Of `single` the evidence stays: learned by the distance from its threshold,
        references fell from 50 % to 39 % (ten lines), for tops unlike the reference lie far below any threshold.
        """
        return CLEARNESS_PER_SIMILARITY * (face.ssim_top - face.ssim_bottom)
