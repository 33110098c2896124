"""The alarm table and the state of each alarm, after ISA-18.2 (IEC 62682).

An alarm is active or not, and acknowledged or not; it is shown to the PLC as long as it is active or
unacknowledged. Faults say what is wrong with the gauge; alarms call an operator.
"""

from collections.abc import Iterable, Set
from typing import Literal, NamedTuple

from plc.registers import REGISTERS

Priority = Literal["low", "medium", "high"]


class AlarmRow(NamedTuple):
    """One row of the alarm table.

    Attributes
    ----------
    name : str
        Coil of the register map.
    priority : {"low", "medium", "high"}
        By how soon somebody must act.
    causes : tuple of str
        Names in the fault table, or a condition of the process: `wrong_orientation`, `out_of_tolerance`,
        `low_trust`, `plc_silent`.
    on_delay_s, off_delay_s : float
        Time that the cause must last before the alarm is active, and be gone before it is not.
    text : str
        What the operator reads.
    remedy : str
        What to do about it.
    """

    name: str
    priority: Priority
    causes: tuple[str, ...]
    on_delay_s: float
    off_delay_s: float
    text: str
    remedy: str


ALARMS: tuple[AlarmRow, ...] = (
    AlarmRow(
        "alarm_wrong_orientation",
        "high",
        ("wrong_orientation",),
        0.0,
        1.0,
        "an ingot lies with its top towards the line",
        "stop the line before the first stand and turn the ingot",
    ),
    AlarmRow(
        "alarm_out_of_tolerance",
        "high",
        ("out_of_tolerance",),
        0.5,
        1.0,
        "the bar is out of tolerance",
        "check target_diameter and the grade, then adjust the stands",
    ),
    AlarmRow(
        "alarm_low_trust",
        "medium",
        ("low_trust",),
        1.0,
        1.0,
        "a bar is there, but its diameter cannot be trusted",
        "look for steam, scale or light on the bar and for dirt on the cameras' windows",
    ),
    AlarmRow(
        "alarm_camera",
        "high",
        (
            "camera_lost",
            "camera_frozen",
            "pair_out_of_step",
            "picture_blank",
            "picture_size_changed",
            "camera_clock_wrong",
        ),
        0.0,
        1.0,
        "a camera is lost or cannot be believed",
        "check power and cables of both cameras; fault_word says what is wrong",
    ),
    AlarmRow(
        "alarm_stale",
        "medium",
        ("reading_stale",),
        0.0,
        1.0,
        "the newest reading is too old",
        "wait ten seconds; if it comes back, the computer is overloaded",
    ),
    AlarmRow(
        "alarm_calibration",
        "medium",
        ("rig_unusable", "references_unusable", "empty_line_unusable", "calibration_due"),
        0.0,
        1.0,
        "the calibration is missing or due",
        "calibrate the cameras with the board; between barriers, take a new picture of the empty line",
    ),
    AlarmRow(
        "alarm_plc_silent",
        "low",
        ("plc_silent",),
        0.0,
        1.0,
        "the PLC's heartbeat stands still",
        "check that the PLC runs and writes plc_heartbeat",
    ),
    AlarmRow(
        "alarm_internal",
        "high",
        ("station_restarting", "station_failing", "not_measuring"),
        0.0,
        1.0,
        "the gauge itself has failed",
        "wait ten seconds; if it comes back, send the log to the maker",
    ),
)

_ADDRESS = {row.name: row.address for row in REGISTERS if "coil" in row.tables}


class _State:
    """State of one alarm."""

    def __init__(self, row: AlarmRow) -> None:
        self._row = row
        self._differs_since_s: float | None = None
        self.active = False
        self.acknowledged = True

    def update(self, now_s: float, *, cause: bool) -> None:
        if cause == self.active:
            self._differs_since_s = None
            return
        if self._differs_since_s is None:
            self._differs_since_s = now_s
        delay_s = self._row.on_delay_s if cause else self._row.off_delay_s
        if now_s - self._differs_since_s >= delay_s:
            self._differs_since_s = None
            self.active = cause
            self.acknowledged = self.acknowledged and not cause


class Alarms:
    """The alarms of the gauge."""

    def __init__(self) -> None:
        self._states = {row: _State(row) for row in ALARMS}
        self._suppressed = False

    def update(self, causes: Set[str], now_s: float, *, suppressed: bool) -> None:
        """Say what is there now.

        Parameters
        ----------
        causes : set of str
            Active faults and conditions, as in `AlarmRow.causes`.
        now_s : float
            Monotonic time.
        suppressed : bool
            While true no alarm comes and none is shown; what was unacknowledged before is shown again after.
        """
        self._suppressed = suppressed
        for row, state in self._states.items():
            state.update(now_s, cause=not (suppressed or causes.isdisjoint(row.causes)))

    def acknowledge(self) -> None:
        """Acknowledge every alarm that is there now."""
        for state in self._states.values():
            state.acknowledged = True

    @property
    def word(self) -> int:
        """Bits of `alarm_word`: bit n is alarm coil n."""
        return sum(1 << _ADDRESS[row.name] for row in self._shown())

    def _shown(self) -> Iterable[AlarmRow]:
        if self._suppressed:
            return ()
        return (row for row, state in self._states.items() if state.active or not state.acknowledged)
