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
LOWEST, HIGHEST = (-6.0, -2.0, 0.0, 0.0, -0.1), (3.0, 2.0, 2.0, 2.0, 0.1)  # of a foot: place, slope, light
FACTOR_MOST = 2.0  # by which the distance of a barrier's two edges may be off before it is fitted
PROFILE_NOISE = 0.002  # of mean profiles, over full scale
CORRELATED = 1 / 0.25  # samples a pixel: neighbours have their noise in common
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
        A length is not positive and finite, the barriers are higher than their distance, or the camera does not hang
        above them.
    """

    spacing_mm: float
    barrier_height_mm: float | None = None
    camera_height_mm: float | None = None

    def __post_init__(self) -> None:
        lengths = (self.spacing_mm, self.barrier_height_mm, self.camera_height_mm)
        if not all(length is None or 0 < length < np.inf for length in lengths):
            raise ValueError("spacing_mm, barrier_height_mm and camera_height_mm: lengths above 0 are wanted")
        if self.barrier_height_mm is not None and self.barrier_height_mm >= self.spacing_mm:
            raise ValueError("barrier_height_mm: barriers are lower than their distance, spacing_mm; are they swapped?")
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
    u_width_px : float
        Standard uncertainty of the edges' distance in the picture, by their fit.
    u_height : float
        Relative standard uncertainty of Z where the barriers' two edges told it.
    """

    middle_px: Array
    turn_rad: float
    vanishing_px: float
    slopes: tuple[float, float]
    spacing_mm: float
    plane_mm: float
    above_plane_mm: float
    u_width_px: float = 0.0
    u_height: float = 0.0

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
    top_mm = reference.barrier_height_mm
    feet = _feet(barriers, 0.5 * top_mm / (view.camera_height_mm - top_mm), free=reference.camera_height_mm is None)
    view = replace(_of_lines(barriers, feet.lines, reference, 0.0, focal_share), u_width_px=feet.u_width_px)
    if reference.camera_height_mm is None:
        view = replace(view, above_plane_mm=top_mm * (1 + 0.5 / feet.part), u_height=feet.u_part)
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
    q1, q2 = view.q(at).tolist()
    view = replace(view, slopes=(q1, q2))
    if reference.camera_height_mm is not None:
        above_mm = reference.camera_height_mm - plane_mm
    else:
        focal = focal_share * columns
        width_px = abs((q2 - q1) * vanishing)
        above_mm = reference.spacing_mm / width_px * focal * abs(vanishing) / float(np.hypot(vanishing, focal))
    return replace(view, above_plane_mm=float(above_mm))


@dataclass(frozen=True, slots=True, eq=False)
class _Feet:
    """Lines of the inner faces' feet, `part` of the barriers' distance inside of the upper edges; uncertainties."""

    lines: Array
    part: float
    u_width_px: float
    u_part: float


def _feet(barriers: Barriers, part: float, *, free: bool) -> _Feet:
    """Two steps of light a known distance apart, fitted to mean profiles of both barriers, blurred alike by the lens.

    `free` where that distance is only roughly known: the profiles then tell it too.
    """
    sides = [_Steps.of(barriers, line, outwards, part) for line, outwards in zip(barriers.lines, (-1, 1), strict=True)]
    reach = FACTOR_MOST if free else 1 + 1e-9
    low, high = [1 / reach, 0.5, *LOWEST, *LOWEST], [reach, 5.0, *HIGHEST, *HIGHEST]
    start = np.clip([1.0, 1.5, *sides[0].start(), *sides[1].start()], low, high)
    n = len(LOWEST)

    def misfit(values: Array) -> Array:
        factor, blur_px = values[:2]
        by_side = zip(sides, values[2:].reshape(2, n), strict=True)
        known = np.array([PROFILE_NOISE * (factor - 1) / FOCAL_SHARE_U])  # where profiles tell little of it
        return np.concatenate([*(side.misfit(one, blur_px, factor) for side, one in by_side), known])

    found = optimize.least_squares(misfit, start, bounds=(low, high))
    lines = np.array([side.line_at(*found.x[2 + n * k : 4 + n * k]) for k, side in enumerate(sides)])
    scatter = CORRELATED * 2 * found.cost / (found.fun.size - found.x.size)
    used = slice(0 if free else 1, None)
    covariance = np.zeros((found.x.size, found.x.size))
    covariance[used, used] = scatter * np.linalg.pinv(found.jac[:, used].T @ found.jac[:, used])
    places = [2, 2 + n]
    factor = float(found.x[0])
    return _Feet(
        lines,
        part * factor,
        float(np.sqrt(covariance[np.ix_(places, places)].sum())),
        float(np.sqrt(covariance[0, 0])) / factor,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """Mean profiles of one barrier in bands of rows, shape (bands, samples), and what is known of them."""

    mean: Array
    line: Array
    outwards: int
    row: Array
    apart_px: Array

    @classmethod
    def of(cls, barriers: Barriers, line: Array, outwards: int, part: float) -> "_Steps":
        rows = np.arange(len(barriers.light), dtype=np.float64)
        profile = across(barriers.light, line, outwards, rows, SAMPLES_PX)
        whole = np.isfinite(profile).all(axis=1)
        rows, profile = rows[whole], profile[whole]
        profile = profile - profile[:, SAMPLES_PX < -DARK_PX].mean(axis=1, keepdims=True)
        row = np.array([band.mean() for band in np.array_split(rows, BANDS)])
        mean = np.array([band.mean(axis=0) for band in np.array_split(profile, BANDS)])
        return cls(mean, line, outwards, row, part * barriers.width_px(row) / np.hypot(1.0, line[0]))

    def start(self) -> list[float]:
        height = float(self.mean[:, -1].mean())
        return [-0.5 * float(self.apart_px.mean()), 0.0, 0.5 * height, 0.5 * height, 0.0]

    def misfit(self, values: Array, blur_px: float, factor: float) -> Array:
        """Of a foot at a place with a slope, and of the light of face and top."""
        place, slope, face, top, level = values
        along = (self.row - self.row.mean()) / np.ptp(self.row)
        at = SAMPLES_PX - (place + slope * along)[:, None]
        steps = face * special.ndtr(at / blur_px) + top * special.ndtr((at - factor * self.apart_px[:, None]) / blur_px)
        return (level + steps - self.mean).ravel()

    def line_at(self, place: float, slope: float) -> Array:
        """Line column(row) of the foot."""
        off = self.outwards * np.hypot(1.0, self.line[0])
        per_row = off * slope / np.ptp(self.row)
        return self.line + np.array([per_row, off * place - per_row * self.row.mean()])
