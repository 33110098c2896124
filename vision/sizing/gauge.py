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
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from vision.calibration.camera_turn import camera_turn
from vision.calibration.rig import Rig
from vision.calibration.still_marks import MarksMotion
from vision.edges.operators import Edges
from vision.fusion.names import Fusion
from vision.geometry.surface_point import SurfacePoint
from vision.readings import SizeReading, of_all_bars
from vision.reasons import Reason
from vision.sent_picture import Codes, SentPicture
from vision.sizing.checked_pictures import checked_pair
from vision.sizing.region_grid import Outline
from vision.sizing.tangent.bar_pairs import MOST_BARS, crowded, pairs_of_bars
from vision.sizing.tangent.gauge import TangentGauge, one_bar
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
    ovality_mm : float or None
        Greatest minus least width of a section that the product may have; None: what is usual of hot-rolled rounds.
    edges : str or EdgeOptions
        Edge detector of route V.
    fusion : str
        How route V fuses the views, if at all; see `VirtualBoardGauge`.

    Raises
    ------
    ValueError
        The rig has no world frame or no boards, or a camera does not see the measuring region.
    """

    def __init__(
        self, rig: Rig, ovality_mm: float | None = None, *, edges: Edges = "forest", fusion: Fusion = "none"
    ) -> None:
        self._rig = rig
        self._beside = ThreadPoolExecutor(1)
        self._tangent = TangentGauge(rig, ovality_mm)
        self._virtual_board = VirtualBoardGauge(rig, edges=edges, fusion=fusion)

    @property
    def carried(self) -> tuple[float, float]:
        """What the next frame gets of the earlier ones; see `VirtualBoardGauge.carried`."""
        return self._virtual_board.carried

    def resume(self, carried: tuple[float, float]) -> None:
        """Go on as the gauge would whose `carried` this was; see `VirtualBoardGauge.resume`."""
        self._virtual_board.resume(carried)

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
        readings = self.measure_bars(left, right)
        return of_all_bars(readings)

    def measure_bars(
        self,
        left: SentPicture | Codes,
        right: SentPicture | Codes,
        *,
        synchronous: bool = False,
        point: SurfacePoint | None = None,
    ) -> tuple[SizeReading, ...]:
        """Diameters of all bars side by side in one pair of pictures; errors as in `measure`.

        Parameters
        ----------
        left, right : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
        synchronous : bool
            Whether time stamps prove that both cameras exposed together.
        point : SurfacePoint or None
            Where a laser meets the one bar: combined with what both views show, or `routes_disagree`; where only one
            view shows the bar, its diameter follows from that view and the point (`limb_hidden`).

        Returns
        -------
        tuple of SizeReading
            One, with the reasons of `measure`, unless a view shows several bars: then those that both views show, from
            smaller x, at most `MOST_BARS`, by route T alone, without a value where a neighbour's light lies beside a
            limb or hides one (`edge_not_found`), and last one without a value for each outline of only one view
            (`one_camera`).
        """
        pictures = checked_pair(self._rig, left, right)
        outlines = self._tangent.outlines(*pictures)
        motions = self._motions(*pictures)
        readings = self._readings(pictures, outlines, motions, synchronous=synchronous, point=point)
        moved_px = float(np.fmax(motions[0].moved_px, motions[1].moved_px))
        return tuple(replace(reading, marks_moved_px=moved_px) for reading in readings)

    def _readings(
        self,
        pictures: tuple[SentPicture, SentPicture],
        outlines: tuple[list[Outline], list[Outline]],
        motions: tuple[MarksMotion, MarksMotion],
        *,
        synchronous: bool,
        point: SurfacePoint | None,
    ) -> tuple[SizeReading, ...]:
        moved = _reasons_of_move(max(np.nan_to_num([motion.moved_px for motion in motions])))
        found = one_bar(outlines)
        alone = _only_outline(outlines) if point is not None else None
        if isinstance(found, Reason) and Reason.SEVERAL_BARS not in found and alone is None:
            return (SizeReading(reasons=found | moved),)
        if moved.forbids_value:
            return (SizeReading(reasons=moved),)
        turns = (camera_turn(self._rig.left, motions[0]), camera_turn(self._rig.right, motions[1]))
        if point is not None and alone is not None:
            reading = self._tangent.measure_one_view(alone[0], pictures[alone[0]], alone[1], point, turns)
            return (replace(reading, reasons=reading.reasons | moved),)
        still = synchronous and not any(math.isnan(motion.moved_px) for motion in motions)
        measure_bar = partial(self._tangent.measure_bar, *pictures, turns=turns, synchronous=still)
        if isinstance(found, Reason):
            readings = self._side_by_side(outlines, measure_bar)
        elif Reason.CALIBRATION_DUE in moved:  # route V does not allow for cameras that have turned
            readings = (measure_bar(found, point=point),)
        else:
            beside = self._beside.submit(self._virtual_board.measure_bar, *pictures, found)
            readings = (judged(measure_bar(found, point=point), beside.result()),)
        return tuple(replace(reading, reasons=reading.reasons | moved) for reading in readings)

    def _side_by_side(
        self,
        outlines: tuple[list[Outline], list[Outline]],
        measure_bar: Callable[[tuple[Outline, Outline]], SizeReading],
    ) -> tuple[SizeReading, ...]:
        pairs, alone = pairs_of_bars(self._rig, *outlines)
        near = crowded(self._rig, outlines)
        readings = [
            SizeReading(reasons=Reason.EDGE_NOT_FOUND)
            if any(one is other for one, view in zip(pair, near, strict=True) for other in view)
            else _wholly_seen(measure_bar(pair))
            for pair in pairs
        ]
        readings += [SizeReading(reasons=Reason.ONE_CAMERA)] * alone
        return tuple(readings[:MOST_BARS]) if len(readings) > 1 else (SizeReading(reasons=Reason.SEVERAL_BARS),)

    def _motions(self, left: SentPicture, right: SentPicture) -> tuple[MarksMotion, MarksMotion]:
        """How each camera's still marks (fixed background points) have moved."""
        marks = self._rig.marks
        beside = self._beside.submit(marks[0].motion, left.shown)
        right_motion = marks[1].motion(right.shown)
        return beside.result(), right_motion


def _only_outline(outlines: tuple[list[Outline], list[Outline]]) -> tuple[int, Outline] | None:
    """The view that alone shows a bar, and the bar's outline; None where both or neither do, or it shows several."""
    counts = [len(view) for view in outlines]
    return None if sorted(counts) != [0, 1] else (counts.index(1), outlines[counts.index(1)][0])


def _wholly_seen(reading: SizeReading) -> SizeReading:
    """The reading of a bar side by side with others, without a value where a neighbour hides one of its limbs.

    The three others leave nothing that could show where the neighbour's light or outline has moved one of them.
    """
    hidden = Reason.LIMB_HIDDEN in reading.reasons
    return SizeReading(reasons=reading.reasons | Reason.EDGE_NOT_FOUND) if hidden else reading


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
