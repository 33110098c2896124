"""Why a reading by tangent planes has no value, or is doubtful: limbs, fit, ends of the bar."""

import numpy as np
from numpy.typing import NDArray

from vision.order_statistics import median, median_without_nan
from vision.reasons import Reason
from vision.sizing.limits import (
    CLIPPED_FEW_SHARE,
    CLIPPED_MOST_SHARE,
    COVERED_SHARE,
    DIAMETER_MM,
    OFF_ROLLERS_MM,
    OFF_ROLLERS_SHARE,
    WEAK_CONTRAST,
)
from vision.sizing.tangent.cylinder_fit import CylinderFit
from vision.sizing.tangent.edge_points import EdgePoints
from vision.sizing.tangent.limb_finder import LimbPoints

Array = NDArray[np.float64]

END_MARGIN_MM = 10.0  # chosen: a bar that ends further inside the region shows its head or its tail
# Chosen: a bin of 5 mm along the bar belongs to the bar if two limbs have a point in it within half a pixel of the fit.
END_BIN_MM, END_AGREEMENT_PX, LEAST_LIMBS_AT_END = 5.0, 0.5, 2
WORST_LIMB_PX = 1.5  # chosen: a limb whose median window lies further off the cylinder means `views_disagree`


def reasons_of_limbs(limbs: list[LimbPoints], shown: list[int], least: int) -> Reason:
    """Reasons from the limbs' exposure and contrast; without a value where too few are shown.

    Parameters
    ----------
    limbs : list of LimbPoints
    shown : list of int
        Numbers of those that show enough of the bar.
    least : int
        Limbs that fix the cylinder.
    """
    reasons = Reason.NONE
    if len(shown) < least:
        lost = [limb for index, limb in enumerate(limbs) if index not in shown]
        clipped = any(limb.clipped_share > CLIPPED_MOST_SHARE for limb in lost)
        return Reason.EDGES_CLIPPED if clipped else Reason.EDGE_NOT_FOUND
    if len(shown) < len(limbs):
        reasons |= Reason.LIMB_HIDDEN
    for index in shown:
        if median(limbs[index].bright) < WEAK_CONTRAST * median(limbs[index].dark):
            reasons |= Reason.LOW_CONTRAST
    if any(limb.is_guess or limb.clipped_share > CLIPPED_FEW_SHARE for limb in limbs):
        reasons |= Reason.SOME_EDGES_CLIPPED
    return reasons


def reasons_of_ends(fit: CylinderFit, points: EdgePoints, region_y_mm: tuple[float, float]) -> Reason:
    """Reasons for a bar that ends in the region, or covers too little of it.

    Parameters
    ----------
    fit : CylinderFit
    points : EdgePoints
        Points that it was fitted to.
    region_y_mm : tuple of float
    """
    edges = np.arange(region_y_mm[0], region_y_mm[1] + END_BIN_MM / 2, END_BIN_MM)
    good = np.abs(fit.residual_px) < END_AGREEMENT_PX
    limbs = [points.station_mm[good & (points.limb == limb)] for limb in range(points.limb.max() + 1)]
    showing = np.sum([np.histogram(stations, edges)[0] > 0 for stations in limbs], axis=0)
    shown, sure = np.flatnonzero(showing), np.flatnonzero(showing >= LEAST_LIMBS_AT_END)
    if not sure.size:
        return Reason.EDGE_NOT_FOUND
    first_mm, last_mm = edges[shown[0]], edges[shown[-1] + 1]
    reasons = Reason.NONE
    if last_mm < region_y_mm[1] - END_MARGIN_MM:
        reasons |= Reason.BAR_HEAD
    if first_mm > region_y_mm[0] + END_MARGIN_MM:
        reasons |= Reason.BAR_TAIL
    if edges[sure[-1]] - edges[sure[0]] < COVERED_SHARE * (region_y_mm[1] - region_y_mm[0]):
        reasons |= Reason.BAR_TOO_SHORT
    return reasons


def reasons_of_fit(fit: CylinderFit, window_px: Array, region_y_mm: tuple[float, float]) -> Reason:
    """Reasons from limbs that lie off the cylinder, and from a cylinder where no bar can be.

    Parameters
    ----------
    fit : CylinderFit
    window_px : ndarray of float64, shape (limbs, windows)
        Median residual of each limb in each window.
    region_y_mm : tuple of float
    """
    _, z0, _, slope_z, radius_mm = fit.parameters
    reasons = Reason.NONE
    if max(abs(median_without_nan(limb_px)) for limb_px in window_px) > WORST_LIMB_PX:
        reasons |= Reason.VIEWS_DISAGREE
    end_mm = np.abs(np.array(region_y_mm) * slope_z + z0 - radius_mm).max()
    on_rollers = end_mm <= OFF_ROLLERS_SHARE * 2 * radius_mm + OFF_ROLLERS_MM
    if not (DIAMETER_MM[0] <= 2 * radius_mm <= DIAMETER_MM[1] and on_rollers):
        reasons |= Reason.IMPLAUSIBLE
    return reasons
