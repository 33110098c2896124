"""The tables of the history, each column with its unit and text; exports and documents are derived from here.

The first column of a table is its time, and rows lie on disk in its order. The SQL stands in
`appliance.history.schema`, since a migration of a released version never changes.
"""

from typing import Literal, NamedTuple

Kind = Literal["time", "integer", "number", "text", "truth", "decision", "reasons"]
Value = float | int | str | None


class Column(NamedTuple):
    """One column.

    Attributes
    ----------
    name : str
        As in the database; a `time` ends in `_utc_ms`.
    kind : str
        `time` is ms since 1970 UTC; `truth` 0 or 1; `decision` a number of `plc.codes.Decision`; `reasons` the bits of
        `vision.reasons.Reason`.
    unit : str
        Empty for a plain number or text.
    text : str
        What it means, and what an empty one means.
    """

    name: str
    kind: Kind
    unit: str
    text: str


class Table(NamedTuple):
    """One table of the history."""

    name: str
    text: str
    columns: tuple[Column, ...]

    @property
    def time(self) -> str:
        """Name of the column that rows are selected and deleted by."""
        return self.columns[0].name


def _time(name: str, text: str) -> Column:
    return Column(f"{name}_utc_ms", "time", "", text)


def _mm(name: str, text: str) -> Column:
    return Column(f"{name}_mm", "number", "mm", text)


_RUN = Column("run_utc_ms", "time", "", "start of the run of the appliance that wrote the row")
_PRODUCT = Column("product_id", "integer", "", "the mill's number of the product, from the PLC; 0: not set")
_SIMULATED = Column("simulated", "truth", "", "whether the source was the simulated mill or a recording")
_DECISION = "against the tolerance with guard band g = U: none, in, out, undecided"

READINGS = Table(
    "readings",
    "Readings as they were served, thinned by `history.reading_period_s`; without a bar one a minute.",
    (
        _time("exposed", "moment of exposure"),
        _RUN,
        Column("sequence", "integer", "", "number of the exposure since the measuring process started"),
        Column("bar", "integer", "", "number of the bar since the start of the run, as `bar_sequence`"),
        Column("valid", "truth", "", "whether the diameter was served as valid"),
        _mm("diameter", "diameter, hot; empty without a value"),
        _mm("expanded_uncertainty", "U (k = 2) of the diameter"),
        _mm("diameter_cold", "diameter at 20 °C; empty without a grade or a temperature"),
        _mm("expanded_uncertainty_cold", "U (k = 2) of the cold diameter"),
        _mm("diameter_virtual_board", "diameter by the dissertation's route"),
        _mm("weighted_deviation", "Sigma, eq. 3.18 of the dissertation"),
        Column("trust", "number", "%", "confidence index, not a probability"),
        _mm("deviation", "diameter minus target, cold if a grade is set"),
        Column("decision", "decision", "", _DECISION),
        Column("reasons", "reasons", "", "reason flags, joined by a semicolon"),
        Column("windows_kept", "integer", "", "windows along the bar that agree with the result"),
        Column("windows_total", "integer", "", "windows along the bar"),
        Column("alignment_quality", "number", "%", "Q_R, eq. 4.1 of the dissertation"),
        _mm("plane_height", "height of the virtual board"),
        _mm("axis_height", "height of the bar's axis over the conveyor"),
        _mm("offset", "position of the axis across the line"),
        *(
            _mm(f"u_{part}", f"standard uncertainty (k = 1) from {part}")
            for part in ("edge", "calibration", "board", "light", "shape", "model")
        ),
        _mm("adjustment", "known error that was added to the diameter (`sizing.adjustment`); 0: none"),
        Column("elapsed_ms", "number", "ms", "time that measuring took"),
        _PRODUCT,
        _SIMULATED,
    ),
)

BARS = Table(
    "bars",
    "One row for each bar, from all of its readings; written when the bar has passed.",
    (
        _time("started", "first valid reading"),
        _RUN,
        Column("bar", "integer", "", "number of the bar since the start of the run, as `bar_sequence`"),
        _time("ended", "last valid reading"),
        _PRODUCT,
        Column("grade", "integer", "", "expansion grade; empty: not set, target and tolerances are hot"),
        Column("temperature_c", "number", "°C", "mean temperature of the section, from the PLC; empty: not set"),
        _mm("target", "target diameter when the bar had passed; empty: not set"),
        _mm("tolerance_plus", "allowed above the target; empty: not set"),
        _mm("tolerance_minus", "allowed below the target; empty: not set"),
        Column("readings", "integer", "", "valid readings of the bar"),
        Column("readings_out", "integer", "", "valid readings that were decided out of tolerance"),
        _mm("head", "mean of the head's diameters, hot; empty: no reading of the head alone"),
        _mm("body", "mean of the body's diameters, hot; empty: no reading of the body"),
        _mm("tail", "mean of the tail's diameters, hot; empty: no reading of the tail alone"),
        _mm("smallest", "smallest diameter of the body, else of all, hot"),
        _mm("mean", "mean diameter of the body, else of all, hot, as `bar_mean`"),
        _mm("largest", "largest diameter of the body, else of all, hot"),
        _mm("spread", "standard deviation of the diameters that `mean` is of; empty with a single one"),
        _mm(
            "expanded_uncertainty",
            "mean of their U (k = 2): no less than U of the mean, whatever errors have in common",
        ),
        _mm("mean_cold", "mean of their cold diameters; empty unless all have one"),
        _mm("expanded_uncertainty_cold", "mean of their U (k = 2) at 20 °C"),
        _mm("deviation", "mean minus target, cold if a grade is set"),
        Column("decision", "decision", "", _DECISION + ", of the mean; undecided below `judging.trust_min`"),
        Column("trust", "number", "%", "mean trust of the valid readings"),
        Column("reasons", "reasons", "", "reason flags that any valid reading of the bar had"),
        _SIMULATED,
    ),
)

INGOTS = Table(
    "ingots",
    "One row for each ingot that was decided, or left undecided.",
    (
        _time("told", "moment of the decision, or of the ingot's leaving undecided"),
        _RUN,
        Column("ingot", "integer", "", "number of the ingot since the start of the run, as `ingot_sequence`"),
        Column("orientation", "text", "", "end that faced the line: top, bottom or undecided"),
        Column("confidence", "number", "%", "confidence of the decision"),
        Column("ssim_top", "number", "", "similarity to the reference of the top, mean over the pictures that counted"),
        Column("ssim_bottom", "number", "", "similarity to the reference of the bottom, likewise"),
        _PRODUCT,
        _SIMULATED,
    ),
)

ALARMS = Table(
    "alarms",
    "One row for each time that an alarm became active.",
    (
        _time("came", "moment at which it became active"),
        _RUN,
        Column("name", "text", "", "coil of the register map"),
        _time("acknowledged", "moment of its acknowledgement; empty: not yet, or not before it came again"),
        _time("gone", "moment from which it was not active; empty: still active, and then the run's end if it ended"),
        _PRODUCT,
    ),
)

FAULTS = Table(
    "faults",
    "One row for each time that a fault came.",
    (
        _time("came", "moment at which it came"),
        _RUN,
        Column("name", "text", "", "name in the fault table"),
        Column("station", "text", "", "station that had it; empty: the gauge as a whole"),
        Column("code", "integer", "", "code in the fault table"),
        Column("state", "integer", "", "NE 107 class, as `device_state`"),
        Column("detail", "text", "", "what exactly was wrong"),
        _time("gone", "moment at which it was over; empty: still there, and then the run's end if it ended"),
    ),
)

SET_POINT_WRITES = Table(
    "set_point_writes",
    "One row for each set point or command that a client changed.",
    (
        _time("written", "moment of the write"),
        _RUN,
        Column("name", "text", "", "register or coil"),
        Column("value", "number", "", "new value, in the unit of the register; a command's level 0 or 1"),
        Column("role", "text", "", "role of the client that wrote; on the port without TLS what `plc.writes` gives it"),
        Column("address", "text", "", "IP address of the client"),
        Column("certificate", "text", "", "common name in the client's certificate; empty on the port without TLS"),
    ),
)

CALIBRATIONS = Table(
    "calibrations",
    "One row for each rig file, or picture of the empty line, that the sizing station was seen to use.",
    (
        _time("found", "moment at which the file was first seen with this content"),
        _RUN,
        Column("file", "text", "", "path of the file"),
        Column("sha256", "text", "", "SHA-256 of its content"),
    ),
)

MARK_CHECKS = Table(
    "mark_checks",
    "One row for each day (UTC) and run: how far the fixed background points have moved since the calibration.",
    (
        _time("day", "begin of the day"),
        _RUN,
        Column("readings", "integer", "", "readings that found the points"),
        Column("mean_px", "number", "px", "mean of how far the points of the camera that moved more have moved"),
        Column("largest_px", "number", "px", "largest of them; from 0.3 px on a calibration is due"),
        _SIMULATED,
    ),
)

ADJUSTMENTS = Table(
    "adjustments",
    "One row for each run in which a known error is taken off, and for each change of it.",
    (
        _time("found", "moment from which it counted"),
        _RUN,
        _mm("added", "added to every diameter; 0: none any more"),
        _mm("expanded", "its U (k = 2)"),
        Column("date", "text", "", "day of the verification that found it"),
        Column("reason", "text", "", "why, and by which master"),
        Column("who", "text", "", "who decided it"),
        Column("calibration_sha256", "text", "", "SHA-256 of the calibration that it was found with"),
    ),
)

VERIFICATIONS = Table(
    "verifications",
    "One row for each `hotgauge verify` that was given these settings.",
    (
        _time("checked", "moment of the verification"),
        Column("recording", "text", "", "folder of the recording of the master"),
        Column("rig", "text", "", "file of the calibration"),
        Column("rig_sha256", "text", "", "SHA-256 of its content"),
        Column("who", "text", "", "who verified"),
        _mm("master", "diameter of the master"),
        _mm("master_expanded", "its U (k = 2)"),
        Column("readings", "integer", "", "readings with a value"),
        Column("missing", "integer", "", "readings without a value"),
        _mm("mean", "mean of the readings"),
        _mm("error", "mean minus master"),
        _mm("repeatability", "standard deviation of one reading"),
        _mm("test_expanded", "U (k = 2) with which the error is known"),
        _mm("limit", "permissible error, either way"),
        _mm("drift", "error minus that of the first verification on a like master; empty without one"),
        Column("verdict", "text", "", "pass, fail or undecided, after ISO 14253-1"),
    ),
)

RUNS = Table(
    "runs",
    "One row for each run of the appliance.",
    (
        _time("started", "start of the run"),
        _time("alive", "last moment at which the history was written; the end, once the run is over"),
        Column("version", "text", "", "version of the software"),
    ),
)

TABLES = (
    READINGS, BARS, INGOTS, ALARMS, FAULTS, SET_POINT_WRITES, CALIBRATIONS, MARK_CHECKS, ADJUSTMENTS, VERIFICATIONS,
    RUNS,
)  # fmt: skip


class Row(NamedTuple):
    """One row for one table; it takes the place of a row with the same key."""

    table: str
    values: dict[str, Value]
