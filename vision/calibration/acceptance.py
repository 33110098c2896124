"""Whether a calibration is good enough to measure with, and why not."""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.initial_guess import HIGH, LOW, Pose, View
from vision.calibration.rig import SIDES, Rig

GIVE_ONE_NUMBER = "give both pictures of a moment the same number"
NOT_OF_ONE_MOMENT = "left and right do not fit together"
NAMES_SHOWN = 4  # of pictures with one reason, in sentences
COVERED_LEAST, TILT_LEAST_DEG = 0.3, 25.0  # chosen: share of a picture, and difference of tilts, without a warning
LEAST_PAIRS = 6  # chosen: boards that both cameras must have seen
HEIGHT_SIGMAS = 4.0  # chosen: the high board may be off board.json by 4 standard uncertainties


class Dropped(NamedTuple):
    """A picture that the calibration does not use, and why.

    Attributes
    ----------
    name : str
    reason : str
    board : str
        Pose of the board that it shows.
    other_moment : bool
        Whether it is left out because it does not fit to the other camera's picture of that pose.
    """

    name: str
    reason: str
    board: str
    other_moment: bool = False


class CalibrationError(Exception):
    """The pictures do not allow a calibration that can be trusted.

    Attributes
    ----------
    reasons : tuple of str
        Everything that is wrong, a sentence each.
    dropped : tuple of Dropped
        Pictures that could not be used, and why.
    """

    def __init__(self, reasons: Sequence[str], dropped: Sequence[Dropped] = ()) -> None:
        super().__init__("calibration refused: " + "; ".join([*reasons, *_left_out(dropped)]))
        self.reasons = tuple(reasons)
        self.dropped = tuple(dropped)


def _left_out(dropped: Sequence[Dropped]) -> list[str]:
    """Pictures that were left out, those of one reason together, of many the first ones by name."""
    by_reason: dict[str, list[str]] = {}
    for drop in dropped:
        by_reason.setdefault(drop.reason, []).append(drop.name)
    return [f"left out: {some_names(names)} ({reason})" for reason, names in by_reason.items()]


def some_names(names: Sequence[str]) -> str:
    """Names in a sentence: the first `NAMES_SHOWN`, and how many more."""
    more = [f"{len(names) - NAMES_SHOWN} more"] if len(names) > NAMES_SHOWN else []
    return ", ".join([*names[:NAMES_SHOWN], *more])


class Limit(NamedTuple):
    """A quantity of a calibration, and its limits; all limits are chosen.

    Attributes
    ----------
    value : float
        The larger the worse; quantities that should be large are negated.
    doubtful, refused : float
        Above `doubtful` the calibration gets a warning, above `refused` it is refused.
    text : str
        Sentence for the report.
    """

    value: float
    doubtful: float
    refused: float
    text: str

    @property
    def broken(self) -> bool:
        """Whether the calibration is refused for it; NaN is."""
        return not self.value <= self.refused

    @property
    def close(self) -> bool:
        """Whether it deserves a warning."""
        return self.doubtful < self.value <= self.refused


def check_pairs(views: Sequence[View], dropped: Sequence[Dropped]) -> None:
    """Raise `CalibrationError` when too few boards were seen by both cameras, or a given low board is unusable.

    Parameters
    ----------
    views : sequence of View
        Pictures in which a board was found.
    dropped : sequence of Dropped
        Pictures that were left out, for the verdict and the error's text.

    Raises
    ------
    CalibrationError
    """
    reasons: list[str] = []
    left, right = ({view.board for view in views if view.side == side} for side in (0, 1))
    pairs = len(left & right)
    if pairs < LEAST_PAIRS:
        usable = f"{pairs} boards are usable in both pictures where {LEAST_PAIRS} are needed"
        apart = {drop.board for drop in dropped if drop.other_moment}
        advice = "take more pairs of pictures"
        if pairs + len(apart) >= LEAST_PAIRS:
            advice = f"the others, {len(apart)}, are not of one moment: {GIVE_ONE_NUMBER}"
        reasons.append(f"{usable}: {advice}")
    if LOW not in left | right and LOW in {drop.board for drop in dropped}:
        reasons.append("no picture of the low board is usable, and it defines the world frame: take it again")
    if reasons:
        raise CalibrationError(reasons, dropped)


def limits(rig: Rig, views: Sequence[View], boards: Sequence[Pose]) -> list[Limit]:
    """Quantities by which a finished calibration is judged, with their limits.

    There is a warning above a residual of 0.2 px, below 25 degrees between the boards' tilts, a baseline of 15 % of the
    boards' distance and boards on 30 % of each picture, and above a standard uncertainty of 0.5 % of a focal length. It
    is refused above 0.5 px, below 10 degrees, 5 % and 10 %, and above 2 %.

    Parameters
    ----------
    rig : Rig
    views : sequence of View
        The pictures that it uses.
    boards : sequence of Pose
        Their boards in the world frame.

    Returns
    -------
    list of Limit
    """
    found = [
        Limit(
            rig.residual_px,
            0.2,
            0.5,
            f"residual {rig.residual_px:.3f} px: blurred or moving board, or a board.json of another board",
        ),
        _tilt(boards),
        _baseline(rig, boards),
    ]
    for side, camera in enumerate((rig.left, rig.right)):
        covered = covered_share(np.concatenate([v.corners_px for v in views if v.side == side]), camera.image_size)
        text = f"the boards cover {100.0 * covered:.0f} % of the {SIDES[side]} picture: show them in its corners too"
        found.append(Limit(-covered, -COVERED_LEAST, -0.1, text))
        relative_u = float(np.sqrt(rig.covariance[15 * side, 15 * side]) / camera.K[0, 0])
        text = f"the {SIDES[side]} focal length is known to {100.0 * relative_u:.2f} % only: more boards, more tilt"
        found.append(Limit(relative_u, 0.005, 0.02, text))
    return found


def check_moments(boards: Sequence[str], apart: Sequence[str]) -> None:
    """Raise `CalibrationError` when most boards were not before both cameras at one moment.

    Parameters
    ----------
    boards : sequence of str
        Boards that both cameras saw.
    apart : sequence of str
        Those of them on which the cameras do not agree.

    Raises
    ------
    CalibrationError
    """
    if 2 * len(apart) > len(boards):
        sentence = (
            f"{NOT_OF_ONE_MOMENT} on {len(apart)} of {len(boards)} boards, though each camera's pictures are good: "
            f"{GIVE_ONE_NUMBER}, and let cameras stand still meanwhile"
        )
        raise CalibrationError([sentence])


def mounting_warnings(rig: Rig) -> list[str]:
    """What is unusual in how the cameras stand, and is measured as it is.

    Parameters
    ----------
    rig : Rig
    """
    x, y, z = rig.left.R @ (rig.right.centre_mm - rig.left.centre_mm) / rig.baseline_mm
    warnings: list[str] = []
    if x < -max(abs(y), abs(z)):
        warnings.append(
            "the pictures named left come from the camera on the right, or both are mirrored or upside down: "
            "that is measured as well, but let recordings have the same names and turns"
        )
    along = abs(rig.right.centre_mm - rig.left.centre_mm)
    if rig.has_world and along[1] > along[0]:
        warnings.append(
            "the cameras stand behind one another along the line, where they see the same two edges of a bar: put them "
            "on either side of it, or lay the low board with its long side across the line"
        )
    return warnings


def check_height(measured_mm: float, u_mm: float, expected_mm: float) -> None:
    """Raise `CalibrationError` when the high board is not where `board.json` says.

    Parameters
    ----------
    measured_mm : float
        Its height over z = 0 as the pictures have it.
    u_mm : float
        Standard uncertainty of the difference.
    expected_mm : float
        As board.json has it.

    Raises
    ------
    CalibrationError
    """
    if abs(measured_mm - expected_mm) > HEIGHT_SIGMAS * u_mm:
        found = f"{measured_mm:.2f} mm (u = {u_mm:.2f} mm) where board.json says {expected_mm:g} mm"
        advice = f"check square_mm, low_mm and high_mm, and that the pictures {LOW} and {HIGH} are not swapped"
        raise CalibrationError([f"the high board appears at {found}: {advice}"])


def _tilt(boards: Sequence[Pose]) -> Limit:
    normals = np.array([pose.R[:, 2] for pose in boards])
    degrees = float(np.degrees(np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0))))
    return Limit(
        -degrees, -TILT_LEAST_DEG, -10.0, f"the boards' tilts differ by {degrees:.0f} degrees only: tilt them more"
    )


def _baseline(rig: Rig, boards: Sequence[Pose]) -> Limit:
    distance_mm = float(np.median([np.linalg.norm(pose.t - rig.left.centre_mm) for pose in boards]))
    ratio = rig.baseline_mm / distance_mm
    text = f"the cameras stand {rig.baseline_mm:.0f} mm apart, {distance_mm:.0f} mm from the boards: move them apart"
    return Limit(-ratio, -0.15, -0.05, text)


def covered_share(corners_px: NDArray[np.float64], image_size: tuple[int, int]) -> float:
    """Part of the picture inside the convex hull of all corners.

    Parameters
    ----------
    corners_px : ndarray of float64, shape (n, 2)
    image_size : tuple of int
        (columns, rows), pixels.
    """
    hull = cv2.convexHull(corners_px.astype(np.float32))
    return float(cv2.contourArea(hull)) / (image_size[0] * image_size[1])
