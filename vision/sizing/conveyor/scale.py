"""What makes millimetres of places between two barriers, and how far it may be off."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from vision.sizing.conveyor.barrier_faces import FOCAL_SHARE, MOST_ACROSS_SHARE, U_FOCAL_SHARE
from vision.sizing.conveyor.barriers import Barriers
from vision.sizing.conveyor.camera_view import (
    U_BARRIER_HEIGHT_MM,
    U_CAMERA_HEIGHT_MM,
    ConveyorReference,
    ConveyorView,
    conveyor_view,
    faces_disagree,
)

Array = NDArray[np.float64]

# Budget (docs/methods/conveyor.md), standard uncertainties, all chosen:
U_EDGE_PX = 0.02  # of a whole limb or barrier: blur and halo that are not alike on both sides
U_SPACING_SHARE = 0.0005  # of W, relative
INTERVAL_95 = tuple(special.ndtr([-2.0, 2.0]))  # that of k = 2 of a normal law, 95.45 %
LAW_PARTS = 16  # equally probable parts of the law of an assumed quantity (JCGM 101)


@dataclass(frozen=True, slots=True, eq=False)
class Scale:
    """The view of the line, and the views that it may be instead.

    Attributes
    ----------
    barriers : Barriers
    view : ConveyorView
    changed : list of ConveyorView
        Each with one measured quantity off by its standard uncertainty.
    assumed : list of list of ConveyorView
        For each assumed quantity, views over its law.
    faces_disagree : bool
        As `vision.sizing.conveyor.camera_view.faces_disagree` says.
    """

    barriers: Barriers
    view: ConveyorView
    changed: list[ConveyorView]
    assumed: list[list[ConveyorView]]
    faces_disagree: bool

    @classmethod
    def of(cls, barriers: Barriers, reference: ConveyorReference) -> Self:
        """Return the scale of a line's barriers and known lengths."""
        view = conveyor_view(barriers, reference)
        changed, assumed = _changed_views(barriers, reference, view), _assumed_views(barriers, reference, view)
        return cls(barriers, view, changed, assumed, faces_disagree(barriers, reference, view))

    def u_view_mm(self, ends: list[Array], diameter_mm: float, coded_px: float) -> tuple[float, float]:
        """Standard uncertainties from the ruler, and from the bar's edges, the heights and the camera's place.

        Parameters
        ----------
        ends : list of ndarray of float64, shape (n, 2)
            Points (x, y) of the bar's left and of its right edge.
        diameter_mm : float
        coded_px : float
            Standard uncertainty of a barrier's place by compression, both moving apart or together.
        """
        rows, columns = self.barriers.light.shape
        width_px = abs(float(np.mean(ends[1][:, 0] - ends[0][:, 0])))
        barriers_px = float(self.barriers.width_px(np.array([rows / 2]))[0])
        edges = diameter_mm * np.sqrt(2) * U_EDGE_PX / width_px
        fitted_px = self.view.u_width_px or 2 * coded_px  # the fit of the faces knows of compression
        ruler = diameter_mm * np.hypot(np.sqrt(2) * U_EDGE_PX, fitted_px) / barriers_px
        half = np.array([barriers_px, width_px]) / columns  # in half widths of the picture
        lens = diameter_mm * self.barriers.lens.u_bending * abs(float(half[0] ** 2 - half[1] ** 2))
        calibration = np.linalg.norm([ruler, U_SPACING_SHARE * diameter_mm, lens])
        changes = [float(np.median(diameters_mm(view, *ends))) - diameter_mm for view in self.changed]
        return float(calibration), float(np.linalg.norm([edges, *changes]))

    def assumed_law_mm(self, ends: list[Array], diameter_mm: float, u_known_mm: float) -> tuple[float, float]:
        """Correction and standard uncertainty with assumed quantities, propagated as whole laws (JCGM 101).

        What is known follows a normal law and is part of it: the end of a rectangular law with a tail on it is as
        likely as its middle. The correction leads to the middle of the interval that holds 95 % of the diameters; the
        uncertainty is that of a normal law whose interval is as wide.

        Parameters
        ----------
        ends : list of ndarray of float64, shape (n, 2)
            As for `u_view_mm`.
        diameter_mm : float
        u_known_mm : float
            Standard uncertainty of all that is not assumed.
        """
        if not self.assumed:
            return 0.0, u_known_mm
        summed = np.zeros(1)
        for views in self.assumed:
            changes = [float(np.median(diameters_mm(view, *ends))) - diameter_mm for view in views]
            summed = np.add.outer(summed, changes).ravel()
        low, high = (_quantile(summed, u_known_mm, share) for share in INTERVAL_95)
        return 0.5 * (low + high), 0.25 * (high - low)


def _quantile(places: Array, u: float, share: float) -> float:
    """Quantile of a law that is a normal one, of standard deviation u, around each of the places."""

    def surplus(at: float) -> float:
        return float(np.mean(special.ndtr((at - places) / u))) - share

    bounds = float(places.min()) - 5 * u, float(places.max()) + 5 * u
    return float(optimize.root_scalar(surplus, bracket=bounds).root)


def _changed_views(barriers: Barriers, reference: ConveyorReference, view: ConveyorView) -> list[ConveyorView]:
    """Views with one measured quantity off by a standard uncertainty.

    The quantities are the given heights, and the camera's height and place by the barriers' faces where they show.
    """
    changed: list[ConveyorView] = []
    if (camera_mm := reference.camera_height_mm) is not None:
        higher = replace(reference, camera_height_mm=camera_mm + U_CAMERA_HEIGHT_MM)
        changed.append(conveyor_view(barriers, higher))
    if (barrier_mm := reference.barrier_height_mm) is not None and view.u_width_px > 0:
        lower = replace(reference, barrier_height_mm=barrier_mm - min(U_BARRIER_HEIGHT_MM, barrier_mm / 2))
        changed += [
            conveyor_view(barriers, lower),
            replace(view, above_plane_mm=view.above_plane_mm * (1 + view.u_height)),
            replace(view, across_mm=view.across_mm + view.u_across_mm),
        ]
    return changed


def _assumed_views(barriers: Barriers, reference: ConveyorReference, view: ConveyorView) -> list[list[ConveyorView]]:
    """Views over assumed quantities: for each, one in every equally probable part of its law, a rectangular one.

    Of barriers whose height is given the edge that is seen is as likely at an end of the law as between: a face as
    light as the barrier's top shows its lower edge alone, one as dark as what lies beside it the upper one. A camera
    that would have to hang outside the barriers to look across the line by an angle does not look by that angle.
    """
    if view.u_plane_mm == 0:
        return []
    places = np.sqrt(3) * (2 * (np.arange(LAW_PARTS) + 0.5) / LAW_PARTS - 1)  # in standard uncertainties
    edges_mm = view.plane_mm + places * view.u_plane_mm
    if reference.barrier_height_mm is not None:
        ends = np.sqrt(3) * np.repeat([-1.0, 1.0], LAW_PARTS // 2)
        edges_mm = np.append(edges_mm, view.plane_mm + ends * view.u_plane_mm)
    focal_shares = FOCAL_SHARE * (1 + places * U_FOCAL_SHARE)
    laws = [
        [conveyor_view(barriers, reference, edge_mm=float(edge_mm)) for edge_mm in edges_mm],
        [replace(view, across_mm=float(across_mm)) for across_mm in _places_across_mm(view)],
    ]
    if reference.camera_height_mm is None:
        laws.append([conveyor_view(barriers, reference, float(share), view.plane_mm) for share in focal_shares])
    return laws


def _places_across_mm(view: ConveyorView) -> Array:
    """Middles of equally probable parts of the rectangular law of the camera's place, kept between the barriers."""
    reach_mm = np.sqrt(3) * view.u_across_mm
    most_mm = MOST_ACROSS_SHARE * view.spacing_mm
    low_mm, high_mm = max(view.across_mm - reach_mm, -most_mm), min(view.across_mm + reach_mm, most_mm)
    if low_mm >= high_mm:  # the lines contradict a camera between the barriers
        low_mm, high_mm = view.across_mm - reach_mm, view.across_mm + reach_mm
    return low_mm + (high_mm - low_mm) * (np.arange(LAW_PARTS) + 0.5) / LAW_PARTS


def diameters_mm(view: ConveyorView, left_px: Array, right_px: Array) -> Array:
    """Diameter of a round bar on the conveyor from points on its two edges.

    Parameters
    ----------
    view : ConveyorView
    left_px, right_px : ndarray of float64, shape (n, 2)
        (x, y), one pair for each section.

    Returns
    -------
    ndarray of float64, shape (n,)
        2 R = 2 Z sin b / (cos a + sin b).
    """
    first, second = np.arctan(view.tangent(left_px)), np.arctan(view.tangent(right_px))
    a, b = 0.5 * (first + second), 0.5 * np.abs(second - first)
    return 2 * view.camera_height_mm * np.sin(b) / (np.cos(a) + np.sin(b))
