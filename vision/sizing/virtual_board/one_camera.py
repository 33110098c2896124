"""One calibrated camera on the plane of its board: the dissertation's second method (chapters 3.5 to 3.7).

The bar's edges are mapped to the plane on which the board lay, as if they lay there too. They lie higher, so every
diameter is too large, by an amount that grows with the bar (chapter 3.8 calls it a fixed error and adds a
compensation). Route V finds the plane with a second camera instead.
"""

from dataclasses import replace
from typing import Literal

import numpy as np

from vision.alignment.height_search import Height
from vision.alignment.quality import Quality
from vision.alignment.view_alignment import Alignment
from vision.calibration.rig import Rig
from vision.edges.operators import Edges
from vision.reasons import Reason
from vision.sent_picture import Codes, SentPicture
from vision.sizing.checked_pictures import checked_pair
from vision.sizing.virtual_board.aligned_pair import AlignedPair
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.parameters import Parameters
from vision.sizing.virtual_board.reading import AS_PRINTED, Corrections, VirtualBoardReading
from vision.sizing.virtual_board.view_edges import reasons_of_edges

Side = Literal["left", "right"]
SIDES: tuple[Side, ...] = ("left", "right")


class OneCameraGauge:
    """Measures one bar with one camera of a calibrated rig, on one horizontal plane.

    Parameters
    ----------
    rig : Rig
    side : {"left", "right"}
        Camera that is used.
    plane_mm : float or None
        Height of the plane over the conveyor; None: of the low board.
    corrections : Corrections
        Those of one view: turned rows, robust lines, half level. The others have no part in it.
    edges : str or EdgeOptions
        Edge detector.
    parameters : Parameters or None
        See `VirtualBoardGauge`.

    Attributes
    ----------
    last_pair : AlignedPair or None
        The view and its edges, for plots.

    Raises
    ------
    ValueError
        As `VirtualBoardGauge`; or there is no such side.
    """

    def __init__(
        self,
        rig: Rig,
        side: Side = "left",
        plane_mm: float | None = None,
        *,
        corrections: Corrections = AS_PRINTED,
        edges: Edges = "forest",
        parameters: Parameters | None = None,
    ) -> None:
        if side not in SIDES:
            raise ValueError(f"side: {side!r} is none of {', '.join(SIDES)}")
        own = rig if side == "left" else replace(rig, left=rig.right, right=rig.left, boards={})
        self.last_pair: AlignedPair | None = None
        self._view = SIDES.index(side)
        self._rig = rig
        self._plane_mm = rig.low_mm if plane_mm is None else plane_mm
        of_view = replace(corrections, projective_boards=False, tangent_crossing=False)
        self._gauge = VirtualBoardGauge(own, corrections=of_view, edges=edges, parameters=parameters)

    def measure(self, left: SentPicture | Codes, right: SentPicture | Codes) -> VirtualBoardReading:
        """Diameter of the bar in one picture of a pair.

        Parameters
        ----------
        left, right : SentPicture, or ndarray of uint8 or uint16, shape (rows, columns) or (rows, columns, 3)
            The other camera's picture is only checked.

        Returns
        -------
        VirtualBoardReading
            `alignment_quality` is NaN. Without a value: `no_bar`, `several_bars`, `edge_not_found`, `edges_clipped`,
            `no_windows`, `implausible`. A value always has `uncertainty_unknown`.

        Raises
        ------
        ValueError
            As `VirtualBoardGauge.measure`.
        """
        self.last_pair = None
        picture = checked_pair(self._rig, left, right)[self._view]
        outlines = self._gauge.bars(0, picture)
        if len(outlines) != 1:
            return VirtualBoardReading(reasons=Reason.SEVERAL_BARS if outlines else Reason.NO_BAR)
        region, edges = self._gauge.view(0, picture, outlines[0])
        reasons = reasons_of_edges([edges])
        if reasons.forbids_value or edges.outline is None:
            return VirtualBoardReading(reasons=reasons)
        alignment = Alignment(self._gauge.rig, self._gauge.boards, region, region, projective=False)
        height = Height(self._plane_mm, Quality(np.nan, np.nan), 0)
        self.last_pair = AlignedPair(alignment, height, [edges], edges.outline)
        return self._gauge.read(self.last_pair, reasons)
