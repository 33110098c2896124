"""Corrections of route V to the dissertation's method, and its reading of one pair."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from vision.readings import SizeReading
from vision.reasons import Reason

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Corrections:
    """Corrections to the dissertation's method; each can be switched off to show its worth.

    Attributes
    ----------
    turned_rows : bool
        Rows cross the bar at a right angle on a horizontal plane; else they are rows of the undistorted left picture.
    robust_lines : bool
        Points of an edge are held against one robust line for the frame; else k-means splits each window's.
    projective_boards : bool
        Virtual boards by cross ratio; else linearly, eq. 4.2.
    tangent_crossing : bool
        The board at which the outlines' centroids coincide, and the exact tangent model of both views; else the one
        with the largest |Q_R|, and the left view's width on its plane.
    half_level : bool
        Edge points at half level in linear light; else at the edge detector's ridge. Works with robust lines only.
    """

    turned_rows: bool = True
    robust_lines: bool = True
    projective_boards: bool = True
    tangent_crossing: bool = True
    half_level: bool = True

    def __post_init__(self) -> None:
        if self.robust_lines and not self.turned_rows:
            raise ValueError("robust_lines: they need turned_rows")
        if self.half_level and not self.robust_lines:
            raise ValueError("half_level: it needs robust_lines")


CORRECTED = Corrections()
AS_PRINTED = Corrections(False, False, False, False, False)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VirtualBoardReading:
    """Route V's reading of one pair; NaN where there is no value.

    Attributes
    ----------
    diameter_mm : float
        Mean over the kept windows, eq. 3.19; NaN with any reason that forbids a value.
    u_edge_mm, u_board_mm, u_light_mm, u_model_mm : float
        Parts of its standard uncertainty (k = 1): scatter of the kept windows, scale of the board, response and
        compression, edges that lie off as a whole. NaN, with the reason `uncertainty_unknown`, of a fused picture, and
        unless everything is corrected, all parameters are the served ones and the edge detector has its own numbers
        and the shipped model: the errors of other ways are not known.
    weighted_deviation_mm : float
        Median over the kept windows of Sigma, eq. 3.18.
    alignment_quality : float
        Q_R, eq. 4.1, percent, signed, on the chosen board.
    plane_height_mm : float
        Height of the chosen board.
    evaluations : int
        Boards that were tried.
    windows_kept, windows_total : int
        Windows whose Sigma did not jump, and all.
    window_diameters_mm, window_sigmas_mm : ndarray of float64, shape (windows_total,)
        l_i and Sigma_i; NaN where a window gave none.
    window_kept : ndarray of bool, shape (windows_total,)
    reasons : Reason
    """

    diameter_mm: float = math.nan
    u_edge_mm: float = math.nan
    u_board_mm: float = math.nan
    u_light_mm: float = math.nan
    u_model_mm: float = math.nan
    weighted_deviation_mm: float = math.nan
    alignment_quality: float = math.nan
    plane_height_mm: float = math.nan
    evaluations: int = 0
    windows_kept: int = 0
    windows_total: int = 0
    window_diameters_mm: Array = field(default_factory=lambda: np.empty(0))
    window_sigmas_mm: Array = field(default_factory=lambda: np.empty(0))
    window_kept: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=bool))
    reasons: Reason = Reason.NONE

    @property
    def valid(self) -> bool:
        """Whether the diameter may be used."""
        return math.isfinite(self.diameter_mm) and not self.reasons.forbids_value

    @property
    def expanded_uncertainty_mm(self) -> float:
        """U = 2 u, u the root sum of squares of the four parts; the calibration's covariance is not among them."""
        return 2 * math.hypot(self.u_edge_mm, self.u_board_mm, self.u_light_mm, self.u_model_mm)

    def size_reading(self) -> SizeReading:
        """Return it as a reading whose diameter is route V's own."""
        return SizeReading(
            diameter_mm=self.diameter_mm,
            expanded_uncertainty_mm=self.expanded_uncertainty_mm,
            diameter_virtual_board_mm=self.diameter_mm,
            weighted_deviation_mm=self.weighted_deviation_mm,
            reasons=self.reasons,
            windows_kept=self.windows_kept,
            windows_total=self.windows_total,
            alignment_quality=self.alignment_quality,
            plane_height_mm=self.plane_height_mm,
            u_edge_mm=self.u_edge_mm,
            u_board_mm=self.u_board_mm,
            u_light_mm=self.u_light_mm,
            u_model_mm=self.u_model_mm,
            method="virtual-board",
        )


def without_uncertainty(reading: VirtualBoardReading) -> VirtualBoardReading:
    """Reading whose U is not known, with the reason `uncertainty_unknown`."""
    return replace(reading, u_model_mm=math.nan, reasons=reading.reasons | Reason.UNCERTAINTY_UNKNOWN)
