"""A history as a mill would leave it: bars, ingots, alarms, faults, through the recorder, in fast time."""

import random
from collections.abc import Callable
from datetime import datetime

from messages import reading, verdict

from appliance.conformity.plc_inputs import PlcInputs
from appliance.history.recorder import Recorder
from appliance.history.settings import HistorySettings
from appliance.history.tables import Row
from plc.codes import Decision
from plc.security.roles import Client, Role
from vision.reasons import Reason

BAR_PERIOD_S = 40.0
RATE_HZ = 10.0
READINGS_OF_A_BAR = 150
HEAD_READINGS = 10  # and as many of the tail
TOLERANCE_MM = 2.0
TARGETS_MM = (150.0, 250.0)
BETWEEN_BARS_SCATTER_MM = 0.5
WITHIN_A_BAR_SCATTER_MM = 0.15
WEAR_MM_PER_BAR = 0.001

_READINGS = {
    reasons: reading(reasons=reasons).reading
    for reasons in (Reason.NONE, Reason.NO_BAR, Reason.BAR_HEAD, Reason.BAR_TAIL)
}


class MillHistory:
    """Feeds a recorder as a mill with 10 readings a second and a bar every 40 s would.

    Parameters
    ----------
    put : callable
        Gets each row of the history.
    start : datetime
        With a time zone.
    seed : int
    """

    def __init__(self, put: Callable[[Row], None], start: datetime, seed: int = 1) -> None:
        self.now_s = start.timestamp()
        self.random = random.Random(seed)
        self.inputs = PlcInputs(None, lambda *_: None)
        self.run_utc_ms = round(1000 * self.now_s)
        self.recorder = Recorder(
            put, self.run_utc_ms, HistorySettings(), self.inputs, trust_min=50.0, wall=lambda: self.now_s
        )
        self._put = put
        self._template = reading(simulated=False)
        self._sequence = self._bar = 0

    def run(self, hours: float) -> None:
        """Let so many hours pass."""
        for _ in range(round(hours * 3600 / BAR_PERIOD_S)):
            end_s = self.now_s + BAR_PERIOD_S
            if self._bar % 600 == 0:
                self._set(TARGETS_MM[self._bar // 600 % len(TARGETS_MM)])
            if self._bar % 100 == 50:
                self._break()
            self._roll()
            self.now_s = end_s
            if self._bar % 20 == 0:
                self._lay_ingot()
        values: dict = {"started_utc_ms": self.run_utc_ms, "alive_utc_ms": round(1000 * self.now_s), "version": "0.1.0"}
        self._put(Row("runs", values))

    def _set(self, target_mm: float) -> None:
        self.target_mm = target_mm
        written = {"target_diameter": round(100 * target_mm), "product_id": 70000 + round(target_mm)}
        tolerance = {"tolerance_plus": round(100 * TOLERANCE_MM), "tolerance_minus": round(100 * TOLERANCE_MM)}
        self.inputs.add(written | tolerance)
        self.recorder.add_writes(written | tolerance, Client("10.0.0.5", Role.ENGINEER))

    def _break(self) -> None:
        """Let a camera be lost for a minute, and an alarm with it."""
        self.recorder.update_faults({("camera_lost", "sizing"): "left: no pictures"})
        self.recorder.update_alarms({"alarm_camera"}, {"alarm_camera"})
        self.now_s += 30
        self.recorder.update_faults({})
        self.recorder.update_alarms(set(), {"alarm_camera"})
        self.recorder.update_alarms(set(), set())

    def _roll(self) -> None:
        """Let one bar pass."""
        self._bar += 1
        worn_mm = WEAR_MM_PER_BAR * (self._bar % 600)
        bar_mm = self.target_mm + worn_mm + self.random.gauss(0, BETWEEN_BARS_SCATTER_MM)
        for number in range(READINGS_OF_A_BAR):
            reasons = Reason.NONE
            if number < HEAD_READINGS:
                reasons = Reason.BAR_HEAD
            elif number >= READINGS_OF_A_BAR - HEAD_READINGS:
                reasons = Reason.BAR_TAIL
            self._read(bar_mm + self.random.gauss(0, WITHIN_A_BAR_SCATTER_MM), reasons)
        self.recorder.end_bar()
        self._read(None, Reason.NO_BAR)

    def _read(self, diameter_mm: float | None, reasons: Reason) -> None:
        self._sequence += 1
        self.now_s += 1 / RATE_HZ
        changes = {
            "sequence": self._sequence,
            "exposed_monotonic_s": self.now_s,
            "exposed_utc_ms": round(1000 * self.now_s),
            "reading": _READINGS[reasons],
        }
        served: dict = {"bar_sequence": self._bar, "validity": 0, "reason_word": int(reasons)}
        if diameter_mm is not None:
            deviation_mm = diameter_mm - self.target_mm
            inside_mm = TOLERANCE_MM - abs(deviation_mm)
            decision = Decision.IN if inside_mm >= 0.12 else Decision.OUT if inside_mm <= -0.12 else Decision.UNDECIDED
            served |= {
                "measurement_valid": True, "validity": 2 if reasons else 1, "diameter": diameter_mm, "trust": 92.0,
                "expanded_uncertainty": 0.12, "diameter_virtual_board": diameter_mm, "weighted_deviation": 0.11,
                "deviation": deviation_mm, "decision": int(decision), "windows_kept": 23, "windows_total": 25,
            }  # fmt: skip
        self.recorder.add_reading(self._template.model_copy(update=changes), served)

    def _lay_ingot(self) -> None:
        end = self.random.choices(("bottom", "top", "undecided"), (95, 4, 1))[0]
        self.recorder.add_verdict(
            verdict(ingot=self._bar, orientation=end, told_utc_ms=round(1000 * self.now_s)), self._bar, simulated=False
        )
