"""Rows of the file that `measure` writes, one for each frame."""

from collections.abc import Callable
from dataclasses import asdict

from appliance.files.columns import FileColumn
from appliance.files.row_writer import Row, Value
from appliance.sizing.trust import trust_percent
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.bar_gap import BarGap

Judge = Callable[[SizeReading], Row]
"""Gives what is wanted of a bar and how a reading compares: `JUDGED_COLUMNS`, and `trust` by the tolerance."""

# a micrometre is a twentieth of the smallest U; parts of u, whose squares are added, are written to a tenth of that
_MM, _U_MM = 3, 4
READING_COLUMNS = (
    FileColumn("diameter_mm", "mm", _MM, "diameter of the hot bar; empty without a value"),
    FileColumn("expanded_uncertainty_mm", "mm", _MM, "U of the diameter (k = 2)"),
    FileColumn("diameter_virtual_board_mm", "mm", _MM, "diameter by virtual boards, which checks the other"),
    FileColumn("weighted_deviation_mm", "mm", _U_MM, "Sigma, the dissertation's level of trust: small is good"),
    FileColumn("trust", "%", 1, "confidence index, no probability; by the tolerance where one is set"),
    FileColumn("valid", "", None, "whether there is a value"),
    FileColumn("reasons", "", None, "flags of [reasons](reasons.md): why there is no value, or what is doubtful"),
    FileColumn("windows_kept", "", None, "strips of 20 mm along the bar that agree with the diameter"),
    FileColumn("windows_total", "", None, "strips of 20 mm along the bar"),
    FileColumn("alignment_quality", "%", 2, "Q_R: how far the outlines of both views agree, signed"),
    FileColumn("plane_height_mm", "mm", _MM, "height of the virtual board over the conveyor"),
    FileColumn("axis_height_mm", "mm", _MM, "height of the bar's axis over the conveyor"),
    FileColumn("u_edge_mm", "mm", _U_MM, "part of the standard uncertainty (k = 1): scatter of the edges"),
    FileColumn("u_calibration_mm", "mm", _U_MM, "likewise: calibration of the cameras"),
    FileColumn("u_board_mm", "mm", _U_MM, "likewise: print and heights of the board"),
    FileColumn("u_light_mm", "mm", _U_MM, "likewise: response, compression and overexposure"),
    FileColumn("u_shape_mm", "mm", _U_MM, "likewise: ovality that the product may have"),
    FileColumn("u_model_mm", "mm", _U_MM, "likewise: bars that are no cylinders"),
    FileColumn("offset_mm", "mm", _MM, "position of the axis across the line"),
    FileColumn("method", "", None, "`tangent`, `range` (one camera and a laser), `virtual-board` or `conveyor`"),
    FileColumn("u_motion_mm", "mm", _U_MM, "of `u_model_mm`: the bar may have moved between the two exposures"),
    FileColumn("u_range_mm", "mm", _U_MM, "of `u_model_mm`: the laser beside the cameras"),
    FileColumn("range_gap_mm", "mm", _MM, "how far the laser's point lies outside of the bar that the cameras see"),
    FileColumn("wander_px", "px", 3, "how far hot air, or scale, displaces an edge over some centimetres, RMS"),
    FileColumn("camber_mm", "mm", _MM, "sagitta of the axis over 1 m; positive: the ends lie at larger x"),
    FileColumn("u_camber_mm", "mm", _MM, "its standard uncertainty (k = 1)"),
    FileColumn("bar_frames", "", None, "frames of the passing bar that its values are of"),
    FileColumn("bar_diameter_mm", "mm", _MM, "diameter of the passing bar from its last frames"),
    FileColumn("bar_expanded_uncertainty_mm", "mm", _MM, "U of it (k = 2)"),
    FileColumn("bar_ovality_mm", "mm", _MM, "greatest minus least width, once the bar has turned by half a turn"),
    FileColumn("bar_ovality_expanded_uncertainty_mm", "mm", _MM, "U of it (k = 2)"),
)
JUDGED_COLUMNS = (
    FileColumn("target_mm", "mm", _MM, "size that is wanted, `sizing.set_points.target_mm`; empty without one"),
    FileColumn("deviation_mm", "mm", _MM, "size minus target: cold size where a steel grade is set, else hot"),
    FileColumn("decision", "", None, "`in`, `out` or `undecided`, with U as guard band; empty without a tolerance"),
)
FRAME_COLUMNS = (
    FileColumn("frame", "", None, "number of the frame"),
    *READING_COLUMNS,
    FileColumn("elapsed_ms", "ms", 1, "computing time, without decoding"),
    FileColumn("time_us", "µs", None, "stamp of the left camera from `timestamps.csv`; empty without that file"),
    FileColumn("bar", "", None, "bars side by side, counted from smaller x; 0 where there is one"),
    FileColumn(
        "bar_number", "", None, "number of the passing bar in this recording, from 1; empty where there is none"
    ),
    *JUDGED_COLUMNS,
)
COLUMNS = tuple(column.name for column in FRAME_COLUMNS)


def unjudged(reading: SizeReading) -> Row:
    """Row of a reading of which nothing is wanted."""
    return {"trust": trust_percent(reading)} | dict.fromkeys(column.name for column in JUDGED_COLUMNS)


class ReadingRows:
    """Makes rows of one recording and numbers its bars, which `BarGap` tells apart.

    Parameters
    ----------
    judge : callable
    """

    def __init__(self, judge: Judge = unjudged) -> None:
        self._judge = judge
        self._gap = BarGap()
        self._bars = 0
        self._passing = False

    def row(
        self,
        frame: int,
        reading: SizeReading,
        elapsed_ms: float,
        moment_s: float,
        *,
        time_us: int | None = None,
        bar: int = 0,
    ) -> Row:
        """Row of one reading; None for no value.

        Parameters
        ----------
        frame : int
            Number of the frame.
        reading : SizeReading
        elapsed_ms : float
            Computing time.
        moment_s : float
            Of its exposure, on any clock.
        time_us : int or None
            Time stamp of its exposure.
        bar : int
            Place among bars side by side, from smaller x.
        """
        there = Reason.NO_BAR not in reading.reasons
        if self._gap.ends_bar(reading, moment_s):
            self._passing = False
        self._bars += there and not self._passing
        self._passing = self._passing or there
        found: dict[str, Value] = asdict(reading) | {
            "frame": frame,
            "valid": reading.valid,
            "reasons": reading.reasons.names,
            "elapsed_ms": elapsed_ms,
            "time_us": time_us,
            "bar": bar,
            "bar_number": self._bars if there else None,
        }
        found |= self._judge(reading)
        return {column.name: column.written(found[column.name]) for column in FRAME_COLUMNS}
