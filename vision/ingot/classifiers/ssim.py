"""Verdict on one picture's end by its similarities: the dissertation's two classifiers."""

from typing import Literal

Orientation = Literal["top", "bottom", "undecided"]

TOP_THRESHOLD = 0.75  # the dissertation's, of the similarity to the top reference


def single(ssim_top: float, threshold: float = TOP_THRESHOLD) -> Orientation:
    """The dissertation's first classifier: top where the similarity to the top reference exceeds a threshold.

    Parameters
    ----------
    ssim_top, threshold : float
        -1 to 1.
    """
    return "top" if ssim_top > threshold else "bottom"


def dual(ssim_top: float, ssim_bottom: float) -> Orientation:
    """Algorithm 17: the orientation of the more similar reference; the top when both are equally similar.

    Parameters
    ----------
    ssim_top, ssim_bottom : float
        -1 to 1.
    """
    return "top" if ssim_top >= ssim_bottom else "bottom"
