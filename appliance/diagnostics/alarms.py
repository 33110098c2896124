"""The alarm table and the state of each alarm, after ISA-18.2 (IEC 62682).

An alarm is active or not, and acknowledged or not; it is shown to the PLC as long as it is active or
unacknowledged. Faults say what is wrong with the gauge; alarms call an operator.

An alarm that comes and goes (ISA-18.2 calls it chattering) calls nobody any more. The third time within half a minute
its off-delay is half a minute, until it has ended: so no alarm is shown anew more than three times in half a minute.
An operator can shelve an alarm: it is not shown until a set time has passed, and then at once if it is still there.
"""

import math
from collections import deque
from collections.abc import Iterable, Set
from typing import Literal, NamedTuple

from appliance.diagnostics.fault_table import FAULTS
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
    conditions : tuple of str
        Conditions of the process that cause it, beside the faults whose row names it: `wrong_orientation`,
        `out_of_tolerance`, `low_trust`, `plc_silent`.
    on_delay_s, off_delay_s : float
        Time that the cause must last before the alarm is active, and be gone before it is not.
    text : str
        What the operator reads.
    remedy : str
        What to do about it.
    """

    name: str
    priority: Priority
    conditions: tuple[str, ...]
    on_delay_s: float
    off_delay_s: float
    text: str
    remedy: str

    @property
    def causes(self) -> tuple[str, ...]:
        """Conditions of the process and names in the fault table that make this alarm active."""
        return (*self.conditions, *(fault.name for fault in FAULTS if fault.alarm == self.name))


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
        "look for steam, scale or light on the bar and for dirt on the cameras' windows; if it is on for every bar, "
        "set sizing.ovality_mm or the tolerances: without them U is too large to be trusted",
    ),
    AlarmRow(
        "alarm_camera",
        "high",
        (),
        0.0,
        1.0,
        "a camera is lost or cannot be believed",
        "check power and cables of both cameras; fault_word says what is wrong",
    ),
    AlarmRow(
        "alarm_stale",
        "medium",
        (),
        0.0,
        1.0,
        "the newest reading is too old",
        "wait ten seconds; if it comes back, the computer is overloaded",
    ),
    AlarmRow(
        "alarm_calibration",
        "medium",
        (),
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
        (),
        0.0,
        1.0,
        "the gauge itself has failed",
        "wait ten seconds; if it comes back, send the log to the maker",
    ),
)

CHATTER_TIMES = 3
CHATTER_S = 30.0

_ADDRESS = {row.name: row.address for row in REGISTERS if "coil" in row.tables}


class _State:
    """State of one alarm."""

    def __init__(self, row: AlarmRow) -> None:
        self._row = row
        self.causes = frozenset(row.causes)
        self._differs_since_s: float | None = None
        self._came_s: deque[float] = deque(maxlen=CHATTER_TIMES)
        self.active = False
        self.acknowledged = True
        self.shelved_until_s = -math.inf

    def update(self, now_s: float, *, cause: bool) -> None:
        if cause == self.active:
            self._differs_since_s = None
            return
        if self._differs_since_s is None:
            self._differs_since_s = now_s
        delay_s = self._row.on_delay_s if cause else self._off_delay_s
        if now_s - self._differs_since_s >= delay_s:
            self._differs_since_s = None
            self.active = cause
            self.acknowledged = self.acknowledged and not cause
            if cause:
                self._came_s.append(now_s)

    @property
    def _off_delay_s(self) -> float:
        came_s = self._came_s
        chatters = len(came_s) == CHATTER_TIMES and came_s[-1] - came_s[0] <= CHATTER_S
        return CHATTER_S if chatters else self._row.off_delay_s


class Alarms:
    """The alarms of the gauge."""

    def __init__(self) -> None:
        self._states = {row: _State(row) for row in ALARMS}
        self._suppressed = False
        self._now_s = -math.inf

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
        self._now_s = now_s
        for state in self._states.values():
            state.update(now_s, cause=not (suppressed or causes.isdisjoint(state.causes)))

    def acknowledge(self) -> None:
        """Acknowledge every alarm that is shown now; while alarms are suppressed nobody has seen any."""
        if self._suppressed:
            return
        for state in self._states.values():
            state.acknowledged = True

    def shelve(self, name: str, until_s: float) -> None:
        """Show an alarm no more until a moment; one that has passed shows it again.

        Parameters
        ----------
        name : str
            Its coil.
        until_s : float
            Monotonic time.

        Raises
        ------
        ValueError
            There is no such alarm.
        """
        for row, state in self._states.items():
            if row.name == name:
                state.shelved_until_s = until_s
                return
        raise ValueError(f"name: no alarm is called {name!r}")

    @property
    def word(self) -> int:
        """Bits of `alarm_word`: bit n is alarm coil n."""
        return sum(1 << _ADDRESS[row.name] for row in self._shown())

    @property
    def active(self) -> frozenset[str]:
        """Names of the alarms that are active."""
        return frozenset(row.name for row, state in self._states.items() if state.active)

    @property
    def unacknowledged(self) -> frozenset[str]:
        """Names of the alarms that nobody has acknowledged, whether they are still active or not."""
        return frozenset(row.name for row, state in self._states.items() if not state.acknowledged)

    @property
    def shelved_word(self) -> int:
        """Bits of `alarms_shelved`: alarms that are not shown now, whether they are there or not."""
        return sum(1 << _ADDRESS[row.name] for row, state in self._states.items() if self._is_shelved(state))

    def _is_shelved(self, state: _State) -> bool:
        return self._now_s < state.shelved_until_s

    def _shown(self) -> Iterable[AlarmRow]:
        if self._suppressed:
            return ()
        there = ((row, state) for row, state in self._states.items() if state.active or not state.acknowledged)
        return (row for row, state in there if not self._is_shelved(state))
