"""The dissertation's two classifiers of a face, by its structural similarity with references."""

from vision.ingot.classifiers.classifier import Face, FaceClassifier, Orientation, Picture, Verdict

SIMILARITY_THRESHOLD = 0.75  # the dissertation's, between top and bottom
LOG_ODDS_PER_SIMILARITY = 60.0  # similarities of tops and bottoms differ by some 0.1


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
    """

    def __init__(self, top: Picture, bottom: Picture) -> None:
        """Nothing of the references is needed beside the similarities."""

    def judge(self, face: Face) -> Verdict:
        """Top above the threshold; the log odds grow with the distance from it."""
        return Verdict(single(face.ssim_top), LOG_ODDS_PER_SIMILARITY * (face.ssim_top - SIMILARITY_THRESHOLD))


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
        return Verdict(orientation, LOG_ODDS_PER_SIMILARITY * (face.ssim_top - face.ssim_bottom))
