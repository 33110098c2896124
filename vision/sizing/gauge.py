"""The gauge: the bar's diameter by tangent planes (route T), judged by virtual boards (route V).

Examples
--------
`Gauge(rig).measure(left, right)` returns a `SizeReading`. Its value stays when route V contradicts it beyond both
uncertainties, sqrt(U_T^2 + U_V^2), but the trust in it is limited:

>>> from vision.readings import SizeReading
>>> from vision.sizing.gauge import judged
>>> from vision.sizing.virtual_board.reading import VirtualBoardReading
>>> tangent = SizeReading(diameter_mm=120.00, expanded_uncertainty_mm=0.06)
>>> virtual_board = VirtualBoardReading(
...     diameter_mm=120.30, u_edge_mm=0.02, u_board_mm=0.03, u_light_mm=0.0, u_model_mm=0.02
... )
>>> reading = judged(tangent, virtual_board)
>>> reading.diameter_mm, reading.reasons.names, reading.trust_limit
(120.0, ['routes_disagree'], 50.0)
"""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from vision.calibration.rig import Rig
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sent_picture import Codes, SentPicture
from vision.sizing.checked_pictures import checked_pair
from vision.sizing.tangent.gauge import TangentGauge
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.reading import VirtualBoardReading

# Chosen: a camera whose still marks have moved by more than 0.3 px needs a new calibration; beyond 4 px no value is
# served.
CALIBRATION_DUE_PX, CAMERA_MOVED_PX = 0.3, 4.0


class Gauge:
    """Measures one bar with a calibrated rig by tangent planes, with virtual boards beside it.

    Parameters
    ----------
    rig : Rig
    ovality_mm : float
        Greatest minus least width of a section that the product may have.

    Raises
    ------
    ValueError
        The rig has no world frame or no boards, or a camera does not see the measuring region.
    """

    def __init__(self, rig: Rig, ovality_mm: float = 0.0) -> None:
        self._rig = rig
        self._beside = ThreadPoolExecutor(1)
        self._tangent = TangentGauge(rig, ovality_mm)
        self._virtual_board = VirtualBoardGauge(rig)

    def measure(self, left: SentPicture | Codes, right: SentPicture | Codes) -> SizeReading:
        """Diameter of the bar in one pair of pictures: route T's, judged by route V's.

        Parameters
        ----------
        left, right : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
            As they were sent; code values alone are grey or blue-green-red, all their bits used.

        Returns
        -------
        SizeReading
            Reasons as in `TangentGauge.measure`; also, without a value, `camera_moved`, and with one, `routes_disagree`
            and `calibration_due`.

        Raises
        ------
        ValueError
            A picture is not of 8 or 16 bit, not grey or three-channel, or not of the size that the rig was calibrated
            for.
        """
        pictures = checked_pair(self._rig, left, right)
        outlines = self._tangent.find(*pictures)
        moved_px = self._moved_px(*pictures)
        moved = _reasons_of_move(max(np.nan_to_num(moved_px)))
        if isinstance(outlines, Reason):
            return SizeReading(reasons=outlines | moved)
        if moved.forbids_value:
            return SizeReading(reasons=moved)
        beside = self._beside.submit(self._virtual_board.measure_bar, *pictures, outlines)
        tangent = self._tangent.measure_bar(*pictures, outlines, moved_px)
        reading = judged(tangent, beside.result())
        return replace(reading, reasons=reading.reasons | moved)

    def _moved_px(self, left: SentPicture, right: SentPicture) -> tuple[float, float]:
        """Distance that each camera's still marks (fixed background points) have moved, px."""
        marks = self._rig.marks
        beside = self._beside.submit(marks[0].moved_px, left.shown)
        right_px = marks[1].moved_px(right.shown)
        return beside.result(), right_px


def _reasons_of_move(moved_px: float) -> Reason:
    if moved_px > CAMERA_MOVED_PX:
        return Reason.CAMERA_MOVED
    return Reason.CALIBRATION_DUE if moved_px > CALIBRATION_DUE_PX else Reason.NONE


def judged(tangent: SizeReading, virtual_board: VirtualBoardReading) -> SizeReading:
    """Route T's reading with route V's values and verdict.

    |D_T - D_V| > sqrt(U_T^2 + U_V^2) raises `routes_disagree`, which limits the trust to 50 %. A route without a value
    raises nothing.

    Parameters
    ----------
    tangent : SizeReading
        Route T's.
    virtual_board : VirtualBoardReading
        Route V's of the same pair.

    Returns
    -------
    SizeReading
    """
    allowed_mm = math.hypot(tangent.expanded_uncertainty_mm, virtual_board.expanded_uncertainty_mm)
    apart = abs(tangent.diameter_mm - virtual_board.diameter_mm) > allowed_mm  # false without one of the values
    return replace(
        tangent,
        diameter_virtual_board_mm=virtual_board.diameter_mm,
        weighted_deviation_mm=virtual_board.weighted_deviation_mm,
        alignment_quality=virtual_board.alignment_quality,
        plane_height_mm=virtual_board.plane_height_mm,
        reasons=tangent.reasons | (Reason.ROUTES_DISAGREE if apart else Reason.NONE),
    )
