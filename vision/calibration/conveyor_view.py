"""What two barriers tell of the camera above them: scale, vanishing point and, nearly, its height.

All lines along the conveyor meet in one vanishing point of the picture, v_0 pixels from its middle. Seen from there,
each line along the conveyor has one slope q = u / (v - v_0), and on a level plane q is proportional to the place x
across the conveyor: the barriers' q_1 and q_2, a known distance W apart, are the ruler. The camera's height over the
barriers' plane is Z = W / w_p f sin(theta), w_p the barriers' distance in the picture's middle and
tan(theta) = |v_0| / f; only the focal length f is not in the picture. Without the camera's height f is assumed.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from vision.calibration.conveyor import SAMPLES_PX, Barriers, across

Array = NDArray[np.float64]

FOCAL_SHARE, FOCAL_SHARE_U = 0.95, 0.18  # of the picture's width: fields of view from 43 to 75 degrees, rectangular
UNKNOWN_HEIGHT_MM, UNKNOWN_HEIGHT_U_MM = 50.0, 35.0  # of the edge that is seen of barriers of unknown height
BANDS = 12  # of rows whose mean profile is fitted
DARK_PX = 5.0  # from a barrier's edge: surely conveyor


@dataclass(frozen=True, slots=True)
class ConveyorReference:
    """What is known of the line.

    Attributes
    ----------
    spacing_mm : float
        W, between the barriers' inner faces.
    barrier_height_mm : float or None
        Of the barriers' upper inner edges over the conveyor.
    camera_height_mm : float or None
        Of the camera's lens over the conveyor.

    Raises
    ------
    ValueError
        A length is not positive and finite, or the camera is not above the barriers.
    """

    spacing_mm: float
    barrier_height_mm: float | None = None
    camera_height_mm: float | None = None

    def __post_init__(self) -> None:
        lengths = (self.spacing_mm, self.barrier_height_mm, self.camera_height_mm)
        if not all(length is None or 0 < length < np.inf for length in lengths):
            raise ValueError("spacing_mm, barrier_height_mm and camera_height_mm: lengths above 0 are wanted")
        if self.camera_height_mm is not None and self.camera_height_mm <= 2 * (self.barrier_height_mm or 0.0):
            raise ValueError("camera_height_mm: the camera must hang well above the barriers")


@dataclass(frozen=True, slots=True, eq=False)
class ConveyorView:
    """The conveyor as the camera sees it.

    Attributes
    ----------
    middle_px : ndarray of float64, shape (2,)
        Middle of the picture (x, y), taken for the principal point.
    turn_rad : float
        Of the picture, so that the vanishing point stands straight above or below its middle.
    vanishing_px : float
        v_0, where it stands then.
    slopes : tuple of float
        q_1, q_2 of the barriers.
    spacing_mm : float
        W.
    plane_mm : float
        Height over the conveyor of the barriers' edges that were taken.
    above_plane_mm : float
        Z, height of the camera over them.
    """

    middle_px: Array
    turn_rad: float
    vanishing_px: float
    slopes: tuple[float, float]
    spacing_mm: float
    plane_mm: float
    above_plane_mm: float

    def q(self, points_px: Array) -> Array:
        """Slope, seen from the vanishing point, of points (x, y), shape (n, 2)."""
        u, v = _turned(points_px - self.middle_px, self.turn_rad).T
        return u / (v - self.vanishing_px)

    def tangent(self, points_px: Array) -> Array:
        """Tangent of the angle at which the camera sees points, from straight below it, in the section plane."""
        return self.spacing_mm * self.q(points_px) / (self.slopes[1] - self.slopes[0]) / self.above_plane_mm

    @property
    def camera_height_mm(self) -> float:
        """Of the camera over the conveyor."""
        return self.plane_mm + self.above_plane_mm


def _turned(points: Array, angle: float) -> Array:
    cos, sin = np.cos(angle), np.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])


def conveyor_view(
    barriers: Barriers,
    reference: ConveyorReference,
    focal_share: float = FOCAL_SHARE,
    edge_mm: float = UNKNOWN_HEIGHT_MM,
) -> ConveyorView:
    """View of the conveyor from its barriers.

    With the barriers' height, the foot of each inner face is told from its upper edge by their known distance in the
    picture, and the feet are the ruler; without it, the edges stand at a height that nobody knows.

    Parameters
    ----------
    barriers : Barriers
    reference : ConveyorReference
    focal_share : float
        Focal length over the picture's width, where the camera's height is not known.
    edge_mm : float
        Height of the barriers' edges, where the barriers' height is not known.

    Returns
    -------
    ConveyorView
    """
    plane_mm = 0.0 if reference.barrier_height_mm is not None else edge_mm
    view = _of_lines(barriers, barriers.lines, reference, plane_mm, focal_share)
    if reference.barrier_height_mm is None:
        return view
    for _ in range(3):  # the distance of both edges follows from the height, which follows from the feet
        top_mm = reference.barrier_height_mm
        part = 0.5 * top_mm / (view.camera_height_mm - top_mm)
        view = _of_lines(barriers, _feet(barriers, part), reference, 0.0, focal_share)
    return view


def _of_lines(
    barriers: Barriers, lines: Array, reference: ConveyorReference, plane_mm: float, focal_share: float
) -> ConveyorView:
    rows, columns = barriers.light.shape
    middle = np.array([(columns - 1) / 2, (rows - 1) / 2])
    (m1, c1), (m2, c2) = lines
    apart = m1 - m2 if abs(m1 - m2) > 1e-5 else 1e-5
    row = (c2 - c1) / apart
    off = np.array([m1 * row + c1, row]) - middle
    turn = float(np.arctan(off[0] / off[1]))
    vanishing = float(_turned(off[None], turn)[0, 1])
    view = ConveyorView(middle, turn, vanishing, (0.0, 1.0), reference.spacing_mm, plane_mm, 1.0)
    at = np.array([[m * middle[1] + c, middle[1]] for m, c in lines])
    slopes = view.q(at)
    if reference.camera_height_mm is not None:
        above_mm = reference.camera_height_mm - plane_mm
    else:
        focal = focal_share * columns
        width_px = abs(slopes[1] - slopes[0]) * abs(vanishing)
        above_mm = reference.spacing_mm / width_px * focal * abs(vanishing) / float(np.hypot(vanishing, focal))
    return replace(view, slopes=(float(slopes[0]), float(slopes[1])), above_plane_mm=float(above_mm))


def _feet(barriers: Barriers, part: float) -> Array:
    """Lines of the inner faces' feet, which are `part` of the barriers' distance inside of their upper edges."""
    return np.array([_foot(barriers, line, side, part) for line, side in zip(barriers.lines, (-1, 1), strict=True)])


def _foot(barriers: Barriers, line: Array, outwards: int, part: float) -> Array:
    """Two steps of light, both blurred alike, a known distance apart, fitted to the mean profiles of bands of rows."""
    rows = np.arange(len(barriers.light), dtype=np.float64)
    profile = across(barriers.light, line, outwards, rows, SAMPLES_PX)
    whole = np.isfinite(profile).all(axis=1)
    rows, profile = rows[whole], profile[whole]
    profile = profile - profile[:, SAMPLES_PX < -DARK_PX].mean(axis=1, keepdims=True)
    mean = np.array([band.mean(axis=0) for band in np.array_split(profile, BANDS)])
    row = np.array([band.mean() for band in np.array_split(rows, BANDS)])
    apart_px = part * barriers.width_px(row) / np.hypot(1.0, line[0])
    along = (row - row.mean()) / np.ptp(row)

    def misfit(values: Array) -> Array:
        place, slope, face, top, blur, level = values
        at = SAMPLES_PX - (place + slope * along)[:, None]
        steps = face * special.ndtr(at / blur) + top * special.ndtr((at - apart_px[:, None]) / blur)
        return (level + steps - mean).ravel()

    height = float(mean[:, -1].mean())
    start = [-0.5 * float(apart_px.mean()), 0.0, 0.5 * height, 0.5 * height, 1.5, 0.0]
    low, high = [-6.0, -2.0, 0.0, 0.0, 0.5, -0.1], [3.0, 2.0, 2.0, 2.0, 5.0, 0.1]
    place, slope = optimize.least_squares(misfit, np.clip(start, low, high), bounds=(low, high)).x[:2]
    off = outwards * np.hypot(1.0, line[0])
    per_row = off * slope / np.ptp(row)
    return line + np.array([per_row, off * place - per_row * row.mean()])
