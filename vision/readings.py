"""Readings: the values of one image pair or picture, their uncertainties and the reasons for doubt.

A value that does not exist is NaN, never zero and never the last good one; `REASONS` is the one table of
reason flags, and every NaN is explained by at least one flag that forbids a value.

Examples
--------
A reading without a bar has no diameter, and its reasons say why:

>>> from vision.readings import SizeReading
>>> from vision.reasons import Reason
>>> empty = SizeReading(reasons=Reason.NO_BAR)
>>> empty.diameter_mm, empty.valid, empty.reasons.names
(nan, False, ['no_bar'])

A flag of the high 16 bits lowers the trust in a value but does not forbid it:

>>> doubted = SizeReading(diameter_mm=119.93, expanded_uncertainty_mm=0.09, reasons=Reason.ROUTES_DISAGREE)
>>> doubted.valid, doubted.trust_limit
(True, 50.0)
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from vision.reasons import IngotReason, Reason

DOUBTED_TRUST = 50.0  # chosen: most trust, percent, in a value that the other sizing route contradicts


@dataclass(frozen=True, slots=True, kw_only=True)
class SizeReading:
    """Diameter of the bar in one image pair, hot, in mm; NaN where there is no value.

    Attributes
    ----------
    diameter_mm : float
        Diameter of the circle whose tangent planes fit; NaN with any reason that forbids a value.
    expanded_uncertainty_mm : float
        U = 2 u of the diameter, u the root sum of squares of the six parts below.
    diameter_virtual_board_mm : float
        Diameter by the dissertation's route (route V).
    weighted_deviation_mm : float
        Median over the kept windows of the weighted deviation Sigma, eq. 3.18.
    reasons : Reason
        Flags; see `REASONS`.
    windows_kept, windows_total : int
        Windows along the bar that agree with the result, and all of them.
    alignment_quality : float
        Q_R, eq. 4.1, percent, signed.
    plane_height_mm : float
        Height of the virtual board.
    axis_height_mm : float
        Height of the bar's axis over the conveyor plane z = 0, at y = 0; NaN by one camera, which assumes it.
    offset_mm : float
        Position of the axis across the line (x), at y = 0.
    u_edge_mm, u_calibration_mm, u_board_mm, u_light_mm, u_shape_mm, u_model_mm : float
        Parts of the standard uncertainty (k = 1) of the diameter.
    u_motion_mm : float
        The share of `u_model_mm` that comes from a bar that may have moved between both exposures.
    u_range_mm : float
        The share of `u_model_mm` that comes from a laser's range; 0 without one.
    range_gap_mm : float
        How far the laser's point lies outside of the cylinder that the cameras see; NaN without a point on the bar.
    width_left_mm, width_right_mm : float
        Width of the bar across the left and the right camera's line of sight.
    camber_mm : float
        Sagitta of the axis over 1 m; positive where the ends lie at larger x than the middle.
    u_camber_mm : float
        Standard uncertainty (k = 1) of it.
    wander_px : float
        How far neighbouring windows of an edge are displaced together, RMS: hot air, or patches of scale.
    bar_frames : int
        Frames of the passing bar that its values are of; 0 where there is none.
    bar_diameter_mm, bar_expanded_uncertainty_mm : float
        Diameter of the passing bar from its last frames, and U = 2 u of it.
    bar_ovality_mm, bar_ovality_expanded_uncertainty_mm : float
        Greatest minus least width of the passing bar, once it has turned by half a turn, and U = 2 u of it.
    clipped_share : float
        Largest share of a limb's points that is overexposed.
    limb_light : float
        Light of the bar beside its darkest limb, over full scale.
    marks_moved_px : float
        Distance that the still marks of the camera that moved more have moved since the calibration.
    method : str
        Route that gave `diameter_mm`: "tangent", "range" (one camera beside a laser), "virtual-board" or "conveyor".
    """

    diameter_mm: float = math.nan
    expanded_uncertainty_mm: float = math.nan
    diameter_virtual_board_mm: float = math.nan
    weighted_deviation_mm: float = math.nan
    reasons: Reason = Reason.NONE
    windows_kept: int = 0
    windows_total: int = 0
    alignment_quality: float = math.nan
    plane_height_mm: float = math.nan
    axis_height_mm: float = math.nan
    u_edge_mm: float = math.nan
    u_calibration_mm: float = math.nan
    u_board_mm: float = math.nan
    u_light_mm: float = math.nan
    u_shape_mm: float = math.nan
    u_model_mm: float = math.nan
    u_motion_mm: float = math.nan
    u_range_mm: float = math.nan
    range_gap_mm: float = math.nan
    width_left_mm: float = math.nan
    width_right_mm: float = math.nan
    camber_mm: float = math.nan
    u_camber_mm: float = math.nan
    wander_px: float = math.nan
    offset_mm: float = math.nan
    bar_frames: int = 0
    bar_diameter_mm: float = math.nan
    bar_expanded_uncertainty_mm: float = math.nan
    bar_ovality_mm: float = math.nan
    bar_ovality_expanded_uncertainty_mm: float = math.nan
    clipped_share: float = math.nan
    limb_light: float = math.nan
    marks_moved_px: float = math.nan
    method: str = "tangent"

    @property
    def trust_limit(self) -> float:
        """Most that the trust may be, in percent, whatever windows and uncertainty say."""
        return DOUBTED_TRUST if Reason.ROUTES_DISAGREE in self.reasons else 100.0

    @property
    def valid(self) -> bool:
        """Whether the diameter may be used."""
        return math.isfinite(self.diameter_mm) and not self.reasons.forbids_value


def of_all_bars(readings: Sequence[SizeReading]) -> SizeReading:
    """The one reading of a frame: of its bar, or `several_bars` with what the frame says of cameras and light.

    Parameters
    ----------
    readings : sequence of SizeReading
        Of all bars of the frame, at least one.

    Returns
    -------
    SizeReading
        Of several bars: `calibration_due` and the marks' move, which are the cameras'; of all limbs the largest clipped
        share and the least light, by which the exposure is set.
    """
    if len(readings) == 1:
        return readings[0]
    due = any(Reason.CALIBRATION_DUE in reading.reasons for reading in readings)
    return SizeReading(
        reasons=Reason.SEVERAL_BARS | (Reason.CALIBRATION_DUE if due else Reason.NONE),
        clipped_share=max(_finite(reading.clipped_share for reading in readings), default=math.nan),
        limb_light=min(_finite(reading.limb_light for reading in readings), default=math.nan),
        marks_moved_px=max(_finite(reading.marks_moved_px for reading in readings), default=math.nan),
    )


def _finite(values: Iterable[float]) -> list[float]:
    return [value for value in values if math.isfinite(value)]


@dataclass(frozen=True, slots=True, kw_only=True)
class OrientationReading:
    """Verdict of one picture of the ingot on the line; NaN where there is no end.

    Attributes
    ----------
    present : bool
        Whether an ingot's end lies on the line.
    orientation : {"top", "bottom", "undecided"}
        Verdict of this picture alone; `undecided` without an end.
    ssim_top, ssim_bottom : float
        Similarity of the end to the two references, -1 to 1.
    log_odds : float
        Natural logarithm of the odds of a top against a bottom, from this picture alone.
    center_x, center_y, radius : float
        Circle of the end, in pixels of the whole picture.
    reasons : IngotReason
        Flags; see `INGOT_REASONS`.
    """

    present: bool = False
    orientation: str = "undecided"
    ssim_top: float = math.nan
    ssim_bottom: float = math.nan
    log_odds: float = math.nan
    center_x: float = math.nan
    center_y: float = math.nan
    radius: float = math.nan
    reasons: IngotReason = IngotReason.NONE
