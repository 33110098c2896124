"""Reason flags of readings: one table for the bar and one for ingots; their bits stand in the PLC's reason words."""

import enum
from typing import NamedTuple


class Reason(enum.IntFlag):
    """Reason flags of a reading; the bit values stand in the PLC's `reason_word` and never change meaning.

    The low 16 bits forbid a value, the high 16 bits only lower the trust in it or say more.
    """

    NONE = 0
    NO_BAR = 1 << 0
    ONE_CAMERA = 1 << 1
    SEVERAL_BARS = 1 << 2
    EDGE_NOT_FOUND = 1 << 3
    FIT_FAILED = 1 << 4
    VIEWS_DISAGREE = 1 << 5
    IMPLAUSIBLE = 1 << 6
    NO_PAIR = 1 << 7
    STALE = 1 << 8
    STARTING = 1 << 9
    EDGES_CLIPPED = 1 << 10
    HELD = 1 << 11
    NO_WINDOWS = 1 << 12
    NOT_ALIGNED = 1 << 13
    CAMERA_MOVED = 1 << 14
    BAR_TOO_SHORT = 1 << 15
    SOME_EDGES_CLIPPED = 1 << 16
    LOW_CONTRAST = 1 << 17
    FEW_WINDOWS = 1 << 18
    BARRIER_HEIGHT = 1 << 19
    POOR_ALIGNMENT = 1 << 20
    BOARD_HELD = 1 << 21
    ADJUSTED = 1 << 22
    UNCERTAINTY_UNKNOWN = 1 << 23
    ROUTES_DISAGREE = 1 << 24
    CALIBRATION_DUE = 1 << 25
    LIMB_HIDDEN = 1 << 26
    BAR_HEAD = 1 << 27
    BAR_TAIL = 1 << 28
    BARRIER_HIDDEN = 1 << 29
    BARRIER_BENT = 1 << 30
    SHIMMER = 1 << 31

    @property
    def names(self) -> list[str]:
        """Lower-case names of the flags that are set, lowest bit first."""
        return [row.name for row in REASONS if row.flag in self]

    @property
    def forbids_value(self) -> bool:
        """Whether any flag that is set means that there is no value."""
        return any(row.forbids_value for row in REASONS if row.flag in self)


class ReasonRow(NamedTuple):
    """One row of the table of reason flags."""

    flag: Reason
    forbids_value: bool
    text: str

    @property
    def name(self) -> str:
        """Name as it stands in JSON, CSV and documents."""
        return str(self.flag.name).lower()


REASONS: tuple[ReasonRow, ...] = (
    ReasonRow(Reason.NO_BAR, True, "no hot bar crosses the measuring region in either view"),
    ReasonRow(Reason.ONE_CAMERA, True, "only one view shows a bar across the measuring region"),
    ReasonRow(Reason.SEVERAL_BARS, True, "more than one bar crosses the measuring region of a view"),
    ReasonRow(Reason.EDGE_NOT_FOUND, True, "too few sub-pixel edge points on a limb of the bar"),
    ReasonRow(Reason.FIT_FAILED, True, "no cylinder fits the edge rays"),
    ReasonRow(Reason.VIEWS_DISAGREE, True, "the two views do not see the same cylinder within their noise"),
    ReasonRow(Reason.IMPLAUSIBLE, True, "the cylinder is not where a bar on the rollers can be"),
    ReasonRow(Reason.NO_PAIR, True, "no image pair from the cameras"),
    ReasonRow(Reason.STALE, True, "the newest image pair is too old"),
    ReasonRow(Reason.STARTING, True, "the measuring process is not ready yet"),
    ReasonRow(Reason.EDGES_CLIPPED, True, "every colour channel is overexposed along a limb of the bar"),
    ReasonRow(Reason.HELD, True, "the PLC holds the gauge"),
    ReasonRow(Reason.NO_WINDOWS, True, "too few windows along the bar give a diameter"),
    ReasonRow(Reason.NOT_ALIGNED, True, "no virtual board makes the bar's outlines in both views agree"),
    ReasonRow(Reason.CAMERA_MOVED, True, "a camera has moved too far since its calibration"),
    ReasonRow(Reason.BAR_TOO_SHORT, True, "the bar covers less than half of the measuring region"),
    ReasonRow(Reason.SOME_EDGES_CLIPPED, False, "part of a limb is overexposed; the uncertainty is widened"),
    ReasonRow(Reason.LOW_CONTRAST, False, "an edge of the bar stands out weakly from its background"),
    ReasonRow(Reason.FEW_WINDOWS, False, "fewer than half of the windows agree with the cylinder"),
    ReasonRow(Reason.BARRIER_HEIGHT, False, "the barriers' faces contradict the heights that are given; do they hang?"),
    ReasonRow(Reason.POOR_ALIGNMENT, False, "the outlines overlap worse than a round bar's do on this rig"),
    ReasonRow(Reason.BOARD_HELD, False, "without a bar the virtual board stays at its last height"),
    ReasonRow(Reason.ADJUSTED, False, "a known error of the gauge was taken off (sizing.adjustment)"),
    ReasonRow(Reason.UNCERTAINTY_UNKNOWN, False, "how far the value may be wrong is not known; it has no trust"),
    ReasonRow(
        Reason.ROUTES_DISAGREE,
        False,
        "two routes, two places, or range and cameras differ by more than U allows",
    ),
    ReasonRow(Reason.CALIBRATION_DUE, False, "a camera has moved since its calibration; calibrate again"),
    ReasonRow(Reason.LIMB_HIDDEN, False, "not all four limbs are seen: three are measured, or two beside a range"),
    ReasonRow(Reason.BAR_HEAD, False, "the bar's head lies in the measuring region"),
    ReasonRow(Reason.BAR_TAIL, False, "the bar's tail lies in the measuring region"),
    ReasonRow(Reason.BARRIER_HIDDEN, False, "a barrier of the conveyor is not found, or partly hidden"),
    ReasonRow(Reason.BARRIER_BENT, False, "a barrier of the conveyor is not straight in the picture"),
    ReasonRow(Reason.SHIMMER, False, "hot air or scale displaces the bar's edges by more than 0.2 px"),
)


class IngotReason(enum.IntFlag):
    """Reason flags of an ingot picture; the bits stand in the PLC's `ingot_reason_word` and never change meaning.

    The low 12 bits forbid an end, the high 4 only say how it was seen.
    """

    NONE = 0
    NOTHING_HOT = 1 << 0
    HANGING = 1 << 1
    OUTSIDE = 1 << 2
    TOO_SMALL = 1 << 3
    TOO_LARGE = 1 << 4
    TILTED = 1 << 5
    NO_CIRCLE = 1 << 6
    NO_PICTURE = 1 << 7
    STALE = 1 << 8
    STARTING = 1 << 9
    HELD = 1 << 10
    GLARE_JOINED = 1 << 12
    SEVERAL_ENDS = 1 << 13
    OVEREXPOSED = 1 << 14

    @property
    def names(self) -> list[str]:
        """Lower-case names of the flags that are set, lowest bit first."""
        return [row.name for row in INGOT_REASONS if row.flag in self]


class IngotReasonRow(NamedTuple):
    """One row of the table of reason flags of ingots."""

    flag: IngotReason
    forbids_value: bool
    text: str

    @property
    def name(self) -> str:
        """Name as it stands in JSON, CSV and documents."""
        return str(self.flag.name).lower()


INGOT_REASONS: tuple[IngotReasonRow, ...] = (
    IngotReasonRow(IngotReason.NOTHING_HOT, True, "nothing in the crop is hot and large enough"),
    IngotReasonRow(IngotReason.HANGING, True, "the ingot still hangs: cut by the crop's upper side, or on end"),
    IngotReasonRow(IngotReason.OUTSIDE, True, "the ingot is not where it lies on the line, or is cut by the crop"),
    IngotReasonRow(IngotReason.TOO_SMALL, True, "the hot region or its end is too small"),
    IngotReasonRow(IngotReason.TOO_LARGE, True, "the hot region or its end is too large, and no end was found in it"),
    IngotReasonRow(IngotReason.TILTED, True, "the ingot's axis is too far from the vertical of the picture"),
    IngotReasonRow(IngotReason.NO_CIRCLE, True, "the lower edge of the hot region is no arc of a circle"),
    IngotReasonRow(IngotReason.NO_PICTURE, True, "no picture from the ingot camera"),
    IngotReasonRow(IngotReason.STALE, True, "the newest picture is too old"),
    IngotReasonRow(IngotReason.STARTING, True, "the ingot station is not ready yet, or is off"),
    IngotReasonRow(IngotReason.HELD, True, "the PLC holds the gauge"),
    IngotReasonRow(IngotReason.GLARE_JOINED, False, "glare has joined the ingot; its end was found as a circle"),
    IngotReasonRow(IngotReason.SEVERAL_ENDS, False, "more than one end lies on the line; the largest is taken"),
    IngotReasonRow(IngotReason.OVEREXPOSED, False, "much of the end is overexposed"),
)
