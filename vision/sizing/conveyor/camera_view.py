"""The view of a camera above two barriers: scale, vanishing point and, up to the focal length, its height.

All lines along the conveyor meet in one vanishing point of the picture, v_0 pixels from its middle. Seen from there,
each line along the conveyor has one slope q = u / (v - v_0), and on a level plane q is proportional to the place x
across the conveyor, as long as the camera looks along the line: the barriers' q_1 and q_2, a known distance W apart,
are the ruler. A camera that looks across the line, by the angle phi in the section plane, sees a line at the angle A
from straight below it at k q = tan(A - phi); k and phi follow from q_1 and q_2 as soon as it is known where between the
barriers the camera hangs. The two faces tell: the nearer one shows narrower. The camera's height over the
barriers' plane is Z = W / w_p f sin(theta), w_p the barriers' distance in the picture's middle and
tan(theta) = |v_0| / f; only the focal length f is not in the picture. Without the camera's height f is assumed.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.sizing.conveyor.barrier_faces import FOCAL_SHARE, U_FOCAL_SHARE, fitted_feet
from vision.sizing.conveyor.barriers import Barriers

Array = NDArray[np.float64]

# Assumed laws, all rectangular and chosen; U_ is the standard uncertainty (docs/methods/conveyor.md).
UNKNOWN_HEIGHT_MM, U_UNKNOWN_HEIGHT_MM = 50.0, 35.0  # height of the edge that is seen of barriers of unknown height
U_TILT_RAD = np.radians(5.0) / np.sqrt(3)  # of a camera that was pointed along the line by eye, within 5 degrees
LEAST_U_ACROSS_SHARE = 0.005  # chosen: of W, least doubt in the camera's place while its height is fitted
MOST_MISFIT_RATIO = 1.35  # chosen: the misfit falls by more when narrower faces are allowed: they are narrower
NARROW_FACE_SHARE = 0.85  # chosen, of the width of a wall's face; faces of walls are fitted 1 to 8 % too narrow
# Chosen on lines other than the studies': fits of walls leave 0.3 to 7 % open, of barriers that hang and are taken for
# walls 11 to 33 %.
MOST_U_FACE_SHARE = 0.1
U_FACE_SHARE = 0.03  # chosen: standard uncertainty of a fitted face's width, by the lens's halo
U_BARRIER_HEIGHT_MM, U_CAMERA_HEIGHT_MM = 1.0, 10.0  # chosen: of heights measured with a tape
DISAGREE_SIGMAS = 3.0  # chosen: faces whose camera height is further off, in standard uncertainties, are no walls


@dataclass(frozen=True, slots=True)
class ConveyorReference:
    """Known lengths of the line.

    Attributes
    ----------
    spacing_mm : float
        W, between the barriers' inner faces.
    barrier_height_mm : float or None
        Of the barriers' upper inner edges over the conveyor.
    camera_height_mm : float or None
        Of the camera's lens over the conveyor.
    barrier_lower_mm : float or None
        Of the barriers' lower edges over the conveyor: 0 for walls that stand on it, more for barriers that hang. None:
        walls, except over rollers, where they may hang at any height.

    Raises
    ------
    ValueError
        A length is not positive and finite, the barriers are higher than their distance, or the camera does not hang
        above them.
    """

    spacing_mm: float
    barrier_height_mm: float | None = None
    camera_height_mm: float | None = None
    barrier_lower_mm: float | None = None

    def __post_init__(self) -> None:
        lengths = (self.spacing_mm, self.barrier_height_mm, self.camera_height_mm)
        if not all(length is None or 0 < length < np.inf for length in lengths):
            raise ValueError("spacing_mm, barrier_height_mm and camera_height_mm: lengths above 0 are wanted")
        if self.barrier_height_mm is not None and self.barrier_height_mm >= self.spacing_mm:
            raise ValueError("barrier_height_mm: barriers are lower than their distance, spacing_mm; are they swapped?")
        if self.camera_height_mm is not None and self.camera_height_mm <= 2 * (self.barrier_height_mm or 0.0):
            raise ValueError("camera_height_mm: the camera must hang well above the barriers")
        if self.barrier_lower_mm is not None and not 0 <= self.barrier_lower_mm < (self.barrier_height_mm or np.inf):
            raise ValueError("barrier_lower_mm: 0 or more is wanted, and less than barrier_height_mm")

    def lower_range_mm(self, *, over_rollers: bool) -> tuple[float, float]:
        """Least and greatest height at which the barriers' lower edges may hang; both 0 for walls."""
        if self.barrier_lower_mm is not None:
            return self.barrier_lower_mm, self.barrier_lower_mm
        return 0.0, (self.barrier_height_mm or 0.0) if over_rollers else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class ConveyorView:
    """The conveyor as the camera sees it.

    Attributes
    ----------
    middle_px : ndarray of float64, shape (2,)
        Middle of the picture (x, y), assumed to be the principal point.
    turn_rad : float
        Of the picture, so that the vanishing point stands straight above or below its middle.
    vanishing_px : float
        v_0, where it stands then.
    slopes : tuple of float
        q_1, q_2 of the barriers.
    spacing_mm : float
        W.
    plane_mm : float
        Height over the conveyor of the barriers' edges that are the ruler.
    above_plane_mm : float
        Z, height of the camera over them.
    across_mm : float
        Place of the middle between the barriers, from straight below the camera.
    u_across_mm : float
        Its standard uncertainty.
    u_width_px : float
        Standard uncertainty of the edges' distance in the picture, by their fit.
    u_height : float
        Relative standard uncertainty of Z where it follows from the barriers' two edges.
    u_plane_mm : float
        Standard uncertainty of `plane_mm`, rectangular, where it is only assumed; else 0.
    narrow_faces : bool
        Whether the barriers' faces clearly show narrower than walls of that height: they hang, or are lower.
    """

    middle_px: Array
    turn_rad: float
    vanishing_px: float
    slopes: tuple[float, float]
    spacing_mm: float
    plane_mm: float
    above_plane_mm: float
    across_mm: float = 0.0
    u_across_mm: float = 0.0
    u_width_px: float = 0.0
    u_height: float = 0.0
    u_plane_mm: float = 0.0
    narrow_faces: bool = False

    def q(self, points_px: Array) -> Array:
        """Slope, seen from the vanishing point, of points (x, y), shape (n, 2)."""
        u, v = _turned(points_px - self.middle_px, self.turn_rad).T
        return u / (v - self.vanishing_px)

    def tangent(self, points_px: Array) -> Array:
        """Tangent of the angle at which the camera sees points, from straight below it, in the section plane."""
        scale, tilt = self._section()
        seen = scale * self.q(points_px)
        return (seen + tilt) / (1 - seen * tilt)

    def _section(self) -> tuple[float, float]:
        """Scale k and tan(phi), by which both barriers are seen where they are."""
        q1, q2 = self.slopes
        a1, a2 = (self.across_mm + side * self.spacing_mm / 2 for side in (-1, 1))
        a1, a2 = a1 / self.above_plane_mm, a2 / self.above_plane_mm
        # q2 tan(A1 - phi) = q1 tan(A2 - phi), written out in tan(phi): the root near 0
        square, linear, constant = q1 * a1 - q2 * a2, (q2 - q1) * (a1 * a2 - 1), q2 * a1 - q1 * a2
        root = np.sqrt(max(linear**2 - 4 * square * constant, 0.0))
        tilt = -2 * constant / (linear + np.copysign(root, linear))
        spread = (a2 - tilt) / (1 + a2 * tilt) - (a1 - tilt) / (1 + a1 * tilt)
        return float(spread / (q2 - q1)), float(tilt)

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
    edge_mm: float | None = None,
) -> ConveyorView:
    """View of the conveyor from its barriers.

    With the barriers' height, the foot of each inner face is separated from its upper edge by their known distance in
    the picture, and the feet are the ruler. Without it, or where the faces show too narrow for that or do not tell a
    wall from a barrier that hangs, the height of the edges that are seen is assumed.

    Parameters
    ----------
    barriers : Barriers
    reference : ConveyorReference
    focal_share : float
        Focal length over the picture's width, where the camera's height is not known.
    edge_mm : float, optional
        Height of the barriers' edges, in place of the rule above.

    Returns
    -------
    ConveyorView
    """
    top_mm = reference.barrier_height_mm
    if edge_mm is not None:
        return _of_lines(barriers, barriers.lines, reference, edge_mm, focal_share)
    if top_mm is None:
        view = _of_lines(barriers, barriers.lines, reference, UNKNOWN_HEIGHT_MM, focal_share)
        return replace(view, u_plane_mm=U_UNKNOWN_HEIGHT_MM)
    least_mm, most_mm = reference.lower_range_mm(over_rollers=barriers.over_rollers)
    if most_mm > 0 or barriers.over_rollers:  # the edge that is seen lies anywhere between the lowest and the upper one
        view = _of_lines(barriers, barriers.lines, reference, 0.5 * (least_mm + top_mm), focal_share)
        return replace(view, u_plane_mm=(top_mm - least_mm) / np.sqrt(12))
    view = _of_lines(barriers, barriers.lines, reference, 0.0, focal_share)
    across = view.across_mm / reference.spacing_mm
    u_across = view.u_across_mm / reference.spacing_mm
    part = top_mm / (view.camera_height_mm - top_mm)
    free = reference.camera_height_mm is None
    feet = fitted_feet(barriers, part, across, u_across, free=free)
    seen = feet if free else fitted_feet(barriers, part, across, u_across, free=True)
    sure = seen.u_part <= MOST_U_FACE_SHARE
    narrow = seen.part < _least_part(barriers, reference, top_mm)
    walls = reference.barrier_lower_mm is not None or (sure and not narrow)
    if not (feet.show and walls):
        view = _of_lines(barriers, barriers.lines, reference, top_mm / 2, focal_share)
        return replace(view, u_plane_mm=top_mm / np.sqrt(12), narrow_faces=sure and seen.show and narrow)
    view = replace(_of_lines(barriers, feet.lines, reference, 0.0, focal_share), u_width_px=feet.u_width_px)
    if reference.camera_height_mm is None:
        view = replace(view, above_plane_mm=top_mm * (1 + 1 / feet.part), u_height=feet.u_part)
    across_mm, u_across_mm = (share * reference.spacing_mm for share in (feet.across, feet.u_across))
    return replace(view, across_mm=across_mm, u_across_mm=u_across_mm)


def _least_part(barriers: Barriers, reference: ConveyorReference, top_mm: float) -> float:
    """Least width of both walls' faces together over the barriers' distance, under the highest camera that may be."""
    highest = _of_lines(barriers, barriers.lines, reference, 0.0, FOCAL_SHARE + np.sqrt(3) * U_FOCAL_SHARE)
    least = top_mm / (highest.camera_height_mm - top_mm)
    return least if reference.camera_height_mm is None else NARROW_FACE_SHARE * least


def faces_disagree(barriers: Barriers, reference: ConveyorReference, view: ConveyorView) -> bool:
    """Whether the barriers' faces are too narrow or too wide for walls of that height, seen by that camera.

    A face that reaches down to the conveyor tells the camera's height. That of a barrier that hangs shows narrower, as
    from a higher camera; so does that of a barrier which is lower than was said.

    Parameters
    ----------
    barriers : Barriers
    reference : ConveyorReference
    view : ConveyorView
        As `conveyor_view` gives it.

    Returns
    -------
    bool
        False where the faces were not fitted: then the barriers' edges are taken to be at any height.
    """
    top_mm = reference.barrier_height_mm
    if top_mm is None or view.u_width_px == 0:
        return False
    if reference.camera_height_mm is not None:
        part = top_mm / (reference.camera_height_mm - top_mm)
        place, u_place = (value / reference.spacing_mm for value in (view.across_mm, view.u_across_mm))
        told, feet = (
            fitted_feet(barriers, part, place, max(u_place, LEAST_U_ACROSS_SHARE), free=free) for free in (False, True)
        )
        if told.misfit > MOST_MISFIT_RATIO * feet.misfit and feet.part < NARROW_FACE_SHARE * part:
            return True
        seen_mm, u_seen = top_mm * (1 + 1 / feet.part), feet.u_part
        low_mm = high_mm = reference.camera_height_mm
    else:
        seen_mm, u_seen = view.camera_height_mm, view.u_height
        shares = [FOCAL_SHARE + sign * np.sqrt(3) * U_FOCAL_SHARE for sign in (-1, 1)]
        low_mm, high_mm = (
            _of_lines(barriers, barriers.lines, reference, 0.0, share).camera_height_mm for share in shares
        )
    known = [seen_mm * u_seen, seen_mm * U_FACE_SHARE, seen_mm * U_BARRIER_HEIGHT_MM / top_mm, U_CAMERA_HEIGHT_MM]
    most_mm = DISAGREE_SIGMAS * float(np.linalg.norm(known))
    return not low_mm - most_mm <= seen_mm <= high_mm + most_mm


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
    across_mm = reference.spacing_mm * 0.5 * (q1 + q2) / (q2 - q1)  # of a camera that looks along the line
    u_across_mm = above_mm * np.tan(U_TILT_RAD)
    return replace(view, above_plane_mm=float(above_mm), across_mm=float(across_mm), u_across_mm=float(u_across_mm))
