"""The uncertainty of a diameter by route T, part by part (GUM, JCGM 100:2008, 5.1.2)."""

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from vision.calibration.rig import Rig
from vision.sizing.cylinder import CylinderFit, tangent_distance_mm
from vision.sizing.points import EdgePoints

Array = NDArray[np.float64]

U_EXPONENT = 0.02  # relative, of the camera's response: how far a power law of its code values may be off
U_PLACE_PX = 0.02  # of a whole limb: what a perfect-looking edge may still be off
CLIPPED_SHIFT_PX = 0.5  # how far an overexposed edge moves outwards


@dataclass(frozen=True, slots=True)
class Budget:
    """Parts of the standard uncertainty (k = 1) of the diameter, mm."""

    edge_mm: float
    calibration_mm: float
    board_mm: float
    light_mm: float
    shape_mm: float
    model_mm: float

    @property
    def expanded_mm(self) -> float:
        """U = 2 u, u the root sum of squares of the parts."""
        return 2 * float(np.sqrt(sum(part**2 for part in astuple(self))))


@dataclass(frozen=True, slots=True, eq=False)
class LimbLight:
    """Light along one limb.

    Attributes
    ----------
    blur_px : float
        Standard deviation of the edge's blur.
    dark_share : float
        Light of the background over that of the bar.
    clipped_share : float
        Share of overexposed points, which were left out.
    """

    blur_px: float
    dark_share: float
    clipped_share: float


def uncertainty_budget(fit: CylinderFit, points: EdgePoints, windows: int, rig: Rig, light: list[LimbLight]) -> Budget:
    """All parts of the diameter's uncertainty.

    Parameters
    ----------
    fit : CylinderFit
    points : EdgePoints
        What was fitted.
    windows : int
        Number of windows along the bar.
    rig : Rig
    light : list of LimbLight
        Of each limb, in the order of `points.limb`.

    Returns
    -------
    Budget
        `edge`: scatter of the points, correlation within windows counted. `calibration`: the rig's covariance,
        propagated through the fit. `board`: the board's scale. `light`: the camera's response and overexposed
        points. `shape`: 0, the bar is taken as round. `model`: limbs that lie off as a whole.
    """
    reach_mm = np.array([_reach_mm(fit, points, limb) for limb in range(len(light))])
    shift_px = np.array([_response_shift_px(one) for one in light])
    clipped_px = np.array([CLIPPED_SHIFT_PX * one.clipped_share for one in light])
    window_px = points.window_medians(np.where(fit.weight > 0, fit.residual_px, np.nan), windows)
    off_px = np.array([_off_px(of_limb[np.isfinite(of_limb)]) for of_limb in window_px])
    return Budget(
        edge_mm=fit.u_diameter_mm,
        calibration_mm=_calibration_mm(fit, points, rig),
        board_mm=fit.diameter_mm * rig.square_relative_u,
        # response and overexposure move all limbs the same way, a limb's own fault only that limb
        light_mm=float(np.hypot(reach_mm @ shift_px, reach_mm @ clipped_px)),
        shape_mm=0.0,
        model_mm=float(np.linalg.norm(reach_mm * off_px)),
    )


def _reach_mm(fit: CylinderFit, points: EdgePoints, limb: int) -> float:
    """Growth of the diameter when a whole limb moves outwards by one pixel."""
    mine = points.limb == limb
    return float(-2 * np.sum(fit.gain[4, mine] / fit.pixel_per_mm[mine]))


def _response_shift_px(light: LimbLight) -> float:
    """How far half level moves when code values follow light with an exponent that is off by `U_EXPONENT`."""
    k = 1 + U_EXPONENT
    dark = light.dark_share
    level = ((1 + dark**k) / 2) ** (1 / k)
    return float(light.blur_px * special.ndtri((level - dark) / (1 - dark)))


def _off_px(windows: Array) -> float:
    """How far a limb may be off as a whole: as far as its windows are off each other, and a little more."""
    if not len(windows):
        return 0.0  # a limb that the fit left out moves nothing
    middle = np.median(windows)
    spread = 1.4826 * np.median(np.abs(windows - middle))
    return float(np.sqrt(U_PLACE_PX**2 + spread**2 + middle**2))


def _calibration_mm(fit: CylinderFit, points: EdgePoints, rig: Rig) -> float:
    """The rig's covariance through one linear step of the fit; one point stands for each window of a limb."""
    strips = points.limb * (points.window.max() + 1) + points.window
    _, first, index, count = np.unique(strips, return_index=True, return_inverse=True, return_counts=True)
    weight = np.bincount(index, fit.gain[4])
    middle = points.only(first + count // 2)

    def diameter_mm(changed: Rig) -> float:
        return float(-2 * weight @ tangent_distance_mm(fit.parameters, middle.rays(changed))[0])

    return rig.standard_uncertainty(diameter_mm)
