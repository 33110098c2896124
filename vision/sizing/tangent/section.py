"""What the limbs of both views tell of the bar's section and of its height, and what they cannot tell.

Each limb is one tangent to the section. A section whose widths differ by o has the support function
h(t) = D / 2 + (o / 4) cos 2 (t - t0) in the direction t, so that limbs along t_i move the fitted diameter by
sum of G_i (o / 4) cos 2 (t_i - t0), G_i being the diameter's growth per millimetre of limb i: at most C o / 2 with
C = |sum of G_i exp(2 i t_i)| / 2. Four limbs have one residual; it shows the component of o that the views see.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.order_statistics import median
from vision.sizing.limits import LIMB_SIDES
from vision.sizing.tangent.cylinder_fit import CylinderFit, EdgeRays, touched_points
from vision.sizing.tangent.edge_points import EdgePoints

Array = NDArray[np.float64]

CIRCLE_PARAMETERS = 3  # across, height and radius of a circle in the section


class SpotView(NamedTuple):
    """What a laser's spot on the bar tells of the section.

    Attributes
    ----------
    growth : float
        Growth of the diameter per millimetre by which the spot lies further outwards.
    outwards : ndarray of float64, shape (3,)
        The bar's outward normal there.
    """

    growth: float
    outwards: Array


@dataclass(frozen=True, slots=True, eq=False)
class SectionView:
    """The section as its limbs show it.

    Attributes
    ----------
    unseen_share : float
        C: largest error of the diameter over half of the ovality; 1 where the views see no more than one width.
    seen_ovality_mm : float
        Least ovality that the limbs' residuals call for, less their noise; 0 with three limbs.
    sideways : ndarray of float64, shape (5,)
        Change of the cylinder's parameters per millimetre by which the axis seems higher because one view has shifted
        sideways: of the view that changes the diameter more.
    """

    unseen_share: float
    seen_ovality_mm: float
    sideways: Array


def section_view(fit: CylinderFit, points: EdgePoints, rays: EdgeRays, spot: SpotView | None = None) -> SectionView:
    """What the limbs tell of the section, and a laser's spot beside them.

    Parameters
    ----------
    fit : CylinderFit
    points : EdgePoints
        Points that the cylinder was fitted to.
    rays : EdgeRays
        Theirs.
    spot : SpotView or None
        One more place of the section's outline that decides the diameter.
    """
    limbs = range(int(points.limb.max()) + 1)
    _, outwards = touched_points(fit.parameters, rays)
    mean = np.array([outwards[points.limb == limb].mean(axis=0) for limb in limbs])
    turn = np.arctan2(mean[:, 2], mean[:, 0])
    growth = np.array([-2 * np.sum(fit.gain[4, points.limb == limb]) for limb in limbs])
    waves = complex(growth @ np.exp(2j * turn))
    if spot is not None:
        waves += spot.growth * complex(np.exp(2j * np.arctan2(spot.outwards[2], spot.outwards[0])))
    return SectionView(
        unseen_share=abs(waves) / 2,
        seen_ovality_mm=_seen_ovality_mm(fit, points, turn),
        sideways=_sideways(fit, points),
    )


def _seen_ovality_mm(fit: CylinderFit, points: EdgePoints, turn: Array) -> float:
    if len(turn) <= CIRCLE_PARAMETERS:
        return 0.0
    place_mm, u_mm = np.array([_limb_place_mm(fit, points, limb) for limb in range(len(turn))]).T
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.ones(len(turn))])
    unseen = np.linalg.svd(circle)[0][:, CIRCLE_PARAMETERS]  # the one pattern of places that no circle explains
    per_ovality = float(abs(unseen @ np.exp(2j * turn))) / 4
    noise2 = float(unseen**2 @ u_mm**2)
    return math.sqrt(max(float(unseen @ place_mm) ** 2 - noise2, 0.0)) / max(per_ovality, 1e-9)


def _limb_place_mm(fit: CylinderFit, points: EdgePoints, limb: int) -> tuple[float, float]:
    """How far a limb lies outside the cylinder, mm, and its standard uncertainty from the scatter of its windows."""
    mine = (points.limb == limb) & (fit.weight > 0)
    if not mine.any():
        return 0.0, math.inf
    outwards_mm = fit.residual_px[mine] / fit.pixel_per_mm[mine]
    window = points.window[mine]
    means = np.bincount(window, outwards_mm) / np.maximum(np.bincount(window), 1)
    means = means[np.bincount(window) > 0]
    return median(outwards_mm), float(means.std() / math.sqrt(max(len(means) - 1, 1)))


def _sideways(fit: CylinderFit, points: EdgePoints) -> Array:
    """What a view's limbs that shift sideways together do per mm of apparent height, where the diameter grows most."""
    largest = np.zeros(5)
    for view in range(2):
        shift = -(fit.gain @ np.where(points.view == view, np.where(points.side < 0, *LIMB_SIDES), 0.0))
        apparent_mm = shift[1] - shift[4]
        if abs(apparent_mm) > 1e-6 and abs(shift[4] / apparent_mm) > abs(largest[4]):
            largest = shift / apparent_mm
    return largest
