"""What a classifier of ingot faces is given, and what it must say."""

from abc import ABC, abstractmethod
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Orientation = Literal["top", "bottom", "undecided"]


class Face(NamedTuple):
    """An ingot's end as it is judged.

    Attributes
    ----------
    image : ndarray of uint8, shape (64, 64)
        As `end_image` gives it.
    ssim_top, ssim_bottom : float
        Structural similarity with either reference, eq. 6.1.
    """

    image: Picture
    ssim_top: float
    ssim_bottom: float


class Verdict(NamedTuple):
    """Which end a face is.

    Attributes
    ----------
    orientation : {"top", "bottom", "undecided"}
    log_odds : float
        Natural logarithm of the odds of a top against a bottom.
    """

    orientation: Orientation
    log_odds: float


class FaceClassifier(ABC):
    """Judges faces by two references.

    Parameters
    ----------
    top, bottom : ndarray of uint8, shape (64, 64)
        References, as `as_reference` gives them.
    """

    @abstractmethod
    def __init__(self, top: Picture, bottom: Picture) -> None: ...

    @abstractmethod
    def judge(self, face: Face) -> Verdict:
        """Which end a face is, and how sure that is."""

    def clearness(self, face: Face) -> float:
        """Natural logarithm of odds, of the verdict's sign, that grow with how clear a face is.

        By them references are compared. Those of the verdict, where they grow so.
        """
        return self.judge(face).log_odds
