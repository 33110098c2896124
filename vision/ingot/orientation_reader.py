"""Reading of one picture of the ingot on the line: end, similarities, verdict."""

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.ingot.classifiers.similarity import as_reference, similarity
from vision.ingot.classifiers.ssim import TOP_THRESHOLD, Orientation, dual, single
from vision.ingot.classifiers.wrinkles import FaceJudge
from vision.ingot.end_finder import End, EndFinder
from vision.ingot.end_image import end_image
from vision.light import CLIPPED_CODE
from vision.readings import OrientationReading
from vision.reasons import IngotReason

Picture = NDArray[np.uint8]
Classifier = Literal["wrinkles", "dual", "single"]

CLASSIFIERS: tuple[Classifier, ...] = ("wrinkles", "dual", "single")
OVEREXPOSED_SHARE = 0.1  # chosen: with more of the end clipped in red the picture is `overexposed`
LOG_ODDS_PER_SIMILARITY = 60.0  # chosen: the dissertation's classifiers compare similarities that differ by about 0.1


@dataclass(frozen=True, slots=True, eq=False)
class References:
    """Ends to compare with: pictures of uint8, any size, grey or blue-green-red."""

    top: Picture
    bottom: Picture


class OrientationReader:
    """Reads pictures of one camera.

    Parameters
    ----------
    finder : EndFinder
    references : References
    classifier : {"wrinkles", "dual", "single"}
        "single" and "dual" are the dissertation's.

    Raises
    ------
    ValueError
        `classifier` is none of the three, or a reference has no picture's shape.
    """

    def __init__(self, finder: EndFinder, references: References, classifier: Classifier = "wrinkles") -> None:
        if classifier not in CLASSIFIERS:
            raise ValueError(f"classifier is {classifier!r}; allowed are {', '.join(CLASSIFIERS)}")
        self._finder = finder
        self._top, self._bottom = as_reference(references.top), as_reference(references.bottom)
        self._classifier = classifier
        self._judge = FaceJudge(self._top, self._bottom)

    def read(self, picture: Picture) -> OrientationReading:
        """Find the end in a picture and say which one it is.

        Parameters
        ----------
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
            Grey, or blue-green-red.

        Returns
        -------
        OrientationReading
            Without an end all numbers are NaN, with the reasons of `EndFinder.find`. With one, `OVEREXPOSED` says that
            red is clipped on more than a tenth of it.

        Raises
        ------
        ValueError
            As in `EndFinder.find`.
        """
        end, reasons = self._finder.find(picture)
        if end is None:
            return OrientationReading(reasons=reasons)
        image = end_image(picture, end)
        ssim_top, ssim_bottom = similarity(image, self._top), similarity(image, self._bottom)
        orientation, log_odds = self._verdict(image, ssim_top, ssim_bottom)
        return OrientationReading(
            present=True,
            orientation=orientation,
            ssim_top=ssim_top,
            ssim_bottom=ssim_bottom,
            log_odds=log_odds,
            center_x=end.center_x,
            center_y=end.center_y,
            radius=end.radius,
            reasons=reasons | (IngotReason.OVEREXPOSED if _is_overexposed(picture, end) else IngotReason.NONE),
        )

    def _verdict(self, image: Picture, ssim_top: float, ssim_bottom: float) -> tuple[Orientation, float]:
        if self._classifier == "single":
            return single(ssim_top), LOG_ODDS_PER_SIMILARITY * (ssim_top - TOP_THRESHOLD)
        if self._classifier == "dual":
            return dual(ssim_top, ssim_bottom), LOG_ODDS_PER_SIMILARITY * (ssim_top - ssim_bottom)
        log_odds = self._judge.log_odds(image)
        return "top" if log_odds > 0 else "bottom", log_odds


def _is_overexposed(picture: Picture, end: End) -> bool:
    """Whether much of the square within the end's circle is clipped in red."""
    half = round(0.7 * end.radius)
    x, y = round(end.center_x), round(end.center_y)
    inside = picture[max(0, y - half) : y + half + 1, max(0, x - half) : x + half + 1]
    red = inside if inside.ndim == 2 else inside[..., 2]
    clipped = cv2.countNonZero(cv2.inRange(np.ascontiguousarray(red), CLIPPED_CODE, 255))
    return bool(clipped > OVEREXPOSED_SHARE * red.size)
