"""What one picture says of the ingot on the line: end, similarities, verdict."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.ingot.classifiers.names import ClassifierName
from vision.ingot.classifiers.similarity import USUAL_COMPARISON, Comparison
from vision.ingot.end_finder import Box, End, EndFinder
from vision.ingot.end_image import end_image
from vision.ingot.face_judge import FaceJudge
from vision.light import CLIPPED_CODE
from vision.readings import OrientationReading
from vision.reasons import IngotReason

Picture = NDArray[np.uint8]

CLIPPED_SHARE = 0.1  # of the end: from here the picture counts as overexposed


@dataclass(frozen=True, slots=True, eq=False)
class References:
    """Ends to compare with: pictures of uint8, any size, grey or blue-green-red."""

    top: Picture
    bottom: Picture


@dataclass(frozen=True, slots=True, eq=False)
class IngotView:
    """What must be known of a camera before its ingots can be read.

    Attributes
    ----------
    references : References
    crop, centroid : Box or None
        None: shares of the picture.
    """

    references: References
    crop: Box | None = None
    centroid: Box | None = None


class OrientationReader:
    """Reads pictures of one camera.

    Parameters
    ----------
    finder : EndFinder
    references : References
    classifier : str
        One of `CLASSIFIERS`; "single" and "dual" are the dissertation's.
    comparison : Comparison
        How similarities with the references are computed.

    Raises
    ------
    ValueError
        `classifier` is not in the table, or a reference has no picture's shape.
    """

    def __init__(
        self,
        finder: EndFinder,
        references: References,
        classifier: ClassifierName = "relief",
        comparison: Comparison = USUAL_COMPARISON,
    ) -> None:
        self._finder = finder
        self._judge = FaceJudge((references.top, references.bottom), classifier, comparison)

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
        face = self._judge.face(end_image(picture, end))
        verdict = self._judge.verdict(face)
        return OrientationReading(
            present=True,
            orientation=verdict.orientation,
            ssim_top=face.ssim_top,
            ssim_bottom=face.ssim_bottom,
            log_odds=verdict.log_odds,
            center_x=end.center_x,
            center_y=end.center_y,
            radius=end.radius,
            reasons=reasons | (IngotReason.OVEREXPOSED if is_overexposed(picture, end) else IngotReason.NONE),
        )


def is_overexposed(picture: Picture, end: End) -> bool:
    """Whether much of the square within the end's circle is clipped in red.

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    end : End
    """
    half = round(0.7 * end.radius)
    x, y = round(end.center_x), round(end.center_y)
    inside = picture[max(0, y - half) : y + half + 1, max(0, x - half) : x + half + 1]
    red = inside if inside.ndim == 2 else inside[..., 2]
    return bool(cv2.countNonZero(cv2.inRange(np.ascontiguousarray(red), CLIPPED_CODE, 255)) > CLIPPED_SHARE * red.size)
