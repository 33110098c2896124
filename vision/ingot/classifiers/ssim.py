"""Which end one picture shows: the source's two classifiers, and how classifiers are judged (eq. 6.4 to 6.6)."""

from typing import Literal

Orientation = Literal["top", "bottom", "undecided"]

THRESHOLD = 0.75  # of the source


def single(ssim_top: float, threshold: float = THRESHOLD) -> Orientation:
    """The source's first classifier: top where the similarity to the top reference exceeds a threshold."""
    return "top" if ssim_top > threshold else "bottom"


def dual(ssim_top: float, ssim_bottom: float) -> Orientation:
    """Algorithm 17: the more similar reference, the top when both are equally so."""
    return "top" if ssim_top >= ssim_bottom else "bottom"
