"""The dissertation's two classifiers of a face, by its structural similarity with references."""

from vision.ingot.classifiers.classifier import Face, FaceClassifier, Orientation, Picture, Verdict
from vision.ingot.classifiers.similarity import USUAL_COMPARISON

SIMILARITY_THRESHOLD = USUAL_COMPARISON.threshold  # the dissertation's, between top and bottom

# Log odds of a top = weight x (what the classifier compares) + constant, by logistic regression on the simulated ingot
# line, seeds 20000 and up (`python -m appliance.training.similarity_odds`).
SINGLE_WEIGHT, SINGLE_CONSTANT = 20.0, 2.0
DUAL_WEIGHT, DUAL_CONSTANT = 30.0, 0.0


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
        """Top above the threshold; the log odds grow with the distance from it."""
        odds = SINGLE_WEIGHT * (face.ssim_top - self._threshold) + SINGLE_CONSTANT
        return Verdict(single(face.ssim_top, self._threshold), odds)


class DualSimilarity(FaceClassifier):
    """`dual` as a classifier; the references have been compared before.

    Parameters
    ----------
    top, bottom : ndarray of uint8, shape (64, 64)
    """

    def __init__(self, top: Picture, bottom: Picture) -> None:
        """Nothing of the references is needed beside the similarities."""

    def judge(self, face: Face) -> Verdict:
        """The more similar reference; the log odds grow with the difference."""
        orientation = dual(face.ssim_top, face.ssim_bottom)
        return Verdict(orientation, DUAL_WEIGHT * (face.ssim_top - face.ssim_bottom) + DUAL_CONSTANT)
