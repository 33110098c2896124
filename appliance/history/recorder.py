"""Makes rows of the history out of what the supervisor publishes; keeps no disk waiting and none that waits.

It is called by the loop that serves the PLC, so it only compares and hands over.
"""

import math
import time
from collections.abc import Callable, Mapping, Set
from pathlib import Path

from appliance.conformity.plc_inputs import PlcInputs
from appliance.diagnostics.fault_table import FAULTS
from appliance.history.bar_record import BarRecord, Mean
from appliance.history.settings import HistorySettings
from appliance.history.tables import Row, Value
from appliance.ingot.message import IngotVerdict
from appliance.sizing.adjustment import Adjustment
from appliance.sizing.message import ReadingMessage
from plc.registers import REGISTERS
from plc.rows import Value as Served
from plc.security.roles import Client
from vision.reasons import Reason

EMPTY_PERIOD_S = 60.0
MARKS_FIRST = 100  # readings after which a day's check of the still marks is kept for the first time
MARKS_PERIOD_MS = 3_600_000
MS_PER_DAY = 86_400_000
_FAULTS = {row.name: row for row in FAULTS}
_REGISTERS = {row.name: row for row in REGISTERS}
_FROM_READING = (
    "plane_height_mm", "axis_height_mm", "offset_mm", "u_edge_mm", "u_calibration_mm", "u_board_mm", "u_light_mm",
    "u_shape_mm", "u_model_mm",
)  # fmt: skip
_SERVED = {
    "diameter_mm": "diameter",
    "expanded_uncertainty_mm": "expanded_uncertainty",
    "diameter_cold_mm": "diameter_cold",
    "expanded_uncertainty_cold_mm": "expanded_uncertainty_cold",
    "diameter_virtual_board_mm": "diameter_virtual_board",
    "weighted_deviation_mm": "weighted_deviation",
    "trust": "trust",
    "deviation_mm": "deviation",
    "decision": "decision",
    "reasons": "reason_word",
    "windows_kept": "windows_kept",
    "windows_total": "windows_total",
    "alignment_quality": "alignment_quality",
}
"""Registers of a reading, by the column that keeps each."""


class Recorder:
    """Makes rows of readings, bars, ingots, alarms, faults and writes.

    Parameters
    ----------
    put : callable
        Gets each row; must not wait.
    run_utc_ms : int
        Start of this run.
    settings : HistorySettings
    inputs : PlcInputs
        What the PLC has written.
    trust_min : float
        Mean trust below which a bar is undecided.
    wall : callable
        Wall time, seconds since 1970.

    Attributes
    ----------
    calibration : str
        SHA-256 of the file that the readings were made with; empty before the first, or without a file.
    """

    def __init__(
        self,
        put: Callable[[Row], None],
        run_utc_ms: int,
        settings: HistorySettings,
        inputs: PlcInputs,
        *,
        trust_min: float,
        wall: Callable[[], float] = time.time,
    ) -> None:
        self._put_row = put
        self._run_utc_ms = run_utc_ms
        self._period_s = settings.reading_period_s
        self._inputs = inputs
        self._trust_min = trust_min
        self._wall = wall
        self._before: tuple[Served, ...] = ()
        self._kept_s = -math.inf
        self._bar: BarRecord | None = None
        self._faults: dict[tuple[str, str], dict[str, Value]] = {}
        self._alarms: dict[str, dict[str, Value]] = {}
        self._unacknowledged: dict[str, dict[str, Value]] = {}
        self.calibration = ""
        self._adjustment = Adjustment()
        self._marks = Mean()
        self._marks_day_ms = self._marks_kept_ms = 0
        self._marks_kept = 0
        self._marks_simulated = False

    def add_reading(self, message: ReadingMessage, served: Mapping[str, Served]) -> None:
        """Count a new reading.

        Parameters
        ----------
        message : ReadingMessage
        served : mapping of str to value
            Values of the registers that belong to it, by name, `bar_sequence` included.
        """
        if not math.isnan(message.reading.marks_moved_px):
            self._count_marks(message)
        if self._is_kept(message, served):
            self._put("readings", self._reading(message, served))
        bar = int(served.get("bar_sequence") or 0)
        if self._bar is not None and self._bar.bar != bar:
            self.end_bar()
        if served.get("measurement_valid"):
            self._bar = self._bar or BarRecord(bar)
            self._bar.add(message, served)

    def end_bar(self) -> None:
        """Keep the bar that was passing, if one was: nothing is seen of it any more."""
        if self._bar is not None:
            bar, self._bar = self._bar, None
            self._put("bars", bar.values(self._inputs.points, self._inputs.product_id, self._trust_min))

    def add_verdict(self, verdict: IngotVerdict, number: int, *, simulated: bool) -> None:
        """Keep what was decided of an ingot.

        Parameters
        ----------
        verdict : IngotVerdict
        number : int
            Of the ingot since the start of this run.
        simulated : bool
        """
        values: dict[str, Value] = {"told_utc_ms": verdict.told_utc_ms, "ingot": number}
        values |= verdict.model_dump(include={"orientation", "confidence", "ssim_top", "ssim_bottom"})
        self._put("ingots", values | {"product_id": self._inputs.product_id, "simulated": simulated})

    def add_writes(self, changed: Mapping[str, int | bool], client: Client) -> None:
        """Keep what a client has changed; its heartbeat is no news.

        Parameters
        ----------
        changed : mapping of str to int or bool
            New numbers by name.
        client : Client
            Who has written.
        """
        who: dict[str, Value] = {"role": str(client.role), "address": client.address, "certificate": client.certificate}
        for name, number in changed.items():
            if name != "plc_heartbeat":
                value = float(number) if isinstance(number, bool) else _REGISTERS[name].to_value(number)
                written: dict[str, Value] = {"written_utc_ms": self._now_utc_ms(), "name": name, "value": value}
                self._put("set_point_writes", written | who)

    def set_adjustment(self, adjustment: Adjustment) -> None:
        """Keep the known error that is taken off from now on, if it is another than before."""
        if adjustment != self._adjustment and (self._adjustment.added_mm or adjustment.added_mm):
            self._put("adjustments", {"found_utc_ms": self._now_utc_ms(), **adjustment.model_dump()})
        self._adjustment = adjustment

    def update_faults(self, active: Mapping[tuple[str, str], str]) -> None:
        """Keep what has come and gone since the last call.

        Parameters
        ----------
        active : mapping of (str, str) to str
            Details of the faults that are there now, by name and station.
        """
        for key, detail in active.items():
            if key not in self._faults:
                row = _FAULTS[key[0]]
                values: dict[str, Value] = {"came_utc_ms": self._now_utc_ms(), "name": row.name, "station": key[1]}
                values |= {"code": row.code, "state": int(row.state), "detail": detail or row.text}
                self._faults[key] = values
                self._put("faults", values)
        for key in self._faults.keys() - active.keys():
            self._put("faults", self._faults.pop(key) | {"gone_utc_ms": self._now_utc_ms()})

    def update_alarms(self, active: Set[str], unacknowledged: Set[str]) -> None:
        """Keep what has come, gone and been acknowledged since the last call.

        Parameters
        ----------
        active : set of str
            Names of the alarms that are active now.
        unacknowledged : set of str
            Names of those that nobody has acknowledged, whether they are still active or not.
        """
        for name in active - self._alarms.keys():
            values: dict[str, Value] = {"came_utc_ms": self._now_utc_ms(), "name": name}
            values["product_id"] = self._inputs.product_id
            self._alarms[name] = self._unacknowledged[name] = values
            self._put("alarms", values)
        for name in self._alarms.keys() - active:
            self._change(self._alarms.pop(name), "gone_utc_ms")
        for name in self._unacknowledged.keys() - unacknowledged:
            self._change(self._unacknowledged.pop(name), "acknowledged_utc_ms")

    def set_calibration(self, file: Path | None, sha256: str) -> None:
        """Keep the file that makes millimetres of pixels from now on, if its content is another than before.

        Parameters
        ----------
        file : Path or None
        sha256 : str
            Of the content that the gauge was made from, which may be an older one than the file's; empty: no file.
        """
        if sha256 and sha256 != self.calibration:
            self._put("calibrations", {"found_utc_ms": self._now_utc_ms(), "file": str(file), "sha256": sha256})
        self.calibration = sha256

    def _is_kept(self, message: ReadingMessage, served: Mapping[str, Served]) -> bool:
        names = ("validity", "reason_word", "decision", "bar_sequence")
        state = tuple(served.get(name) for name in names)
        changed, self._before = state != self._before, state
        there = Reason.NO_BAR not in message.reading.reasons
        due_s = self._kept_s + (self._period_s if there else EMPTY_PERIOD_S)
        if not changed and message.exposed_monotonic_s < due_s:
            return False
        self._kept_s = message.exposed_monotonic_s
        return True

    def _count_marks(self, message: ReadingMessage) -> None:
        """Keep how far the still marks have moved: one row a day, brought up to date once an hour."""
        now_ms = self._now_utc_ms()
        day_ms = now_ms - now_ms % MS_PER_DAY
        if day_ms != self._marks_day_ms:
            self.end_day()
            self._marks, self._marks_day_ms, self._marks_kept_ms, self._marks_kept = Mean(), day_ms, now_ms, 0
        self._marks.add(message.reading.marks_moved_px)
        self._marks_simulated = message.simulated
        if now_ms - self._marks_kept_ms >= MARKS_PERIOD_MS or self._marks.count == MARKS_FIRST:
            self._marks_kept_ms = now_ms
            self._keep_marks()

    def end_day(self) -> None:
        """Keep what the still marks have shown since their row was last brought up to date; a few readings are none."""
        enough = self._marks_kept > 0 or self._marks.count >= MARKS_FIRST
        if enough and self._marks.count > self._marks_kept:
            self._keep_marks()

    def _keep_marks(self) -> None:
        self._marks_kept = self._marks.count
        values: dict[str, Value] = {"day_utc_ms": self._marks_day_ms, "readings": self._marks.count}
        values |= {"mean_px": self._marks.mean, "largest_px": self._marks.largest}
        self._put("mark_checks", values | {"simulated": self._marks_simulated})

    def _reading(self, message: ReadingMessage, served: Mapping[str, Served]) -> dict[str, Value]:
        return {
            "exposed_utc_ms": message.exposed_utc_ms,
            "sequence": message.sequence,
            "bar": int(served.get("bar_sequence") or 0),
            "valid": bool(served.get("measurement_valid")),
            **{column: served.get(register) for column, register in _SERVED.items()},
            **{name: getattr(message.reading, name) for name in _FROM_READING},
            "adjustment_mm": message.adjustment_mm,
            "elapsed_ms": message.elapsed_ms,
            "product_id": self._inputs.product_id,
            "simulated": message.simulated,
        }

    def _change(self, values: dict[str, Value], name: str) -> None:
        values[name] = self._now_utc_ms()
        self._put("alarms", values)

    def _put(self, table: str, values: dict[str, Value]) -> None:
        self._put_row(Row(table, {**values, "run_utc_ms": self._run_utc_ms}))

    def _now_utc_ms(self) -> int:
        return round(1000 * self._wall())
