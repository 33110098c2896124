"""What a PLC that never stops polling saw, told second by second."""

import threading
import time
from typing import NamedTuple

from modbus_wire import Wire
from plc_view import look

from appliance.diagnostics.fault_table import FAULTS
from plc.registers import ALARMS, REGISTERS

POLL_S = 0.02
BITS = {row.name: row.bit for row in FAULTS}
ALARM_BITS = {row.name: row.address for row in REGISTERS if row.tables[0] == "coil" and row.address in ALARMS}


class Seen(NamedTuple):
    """One look of the PLC."""

    at_s: float
    waited_s: float
    state: int
    validity: int
    alarms: frozenset[str]
    faults: frozenset[str]
    age_ms: float | None
    diameter_mm: float | None
    expanded_mm: float | None

    def __str__(self) -> str:
        age = "none" if self.age_ms is None else f"{self.age_ms:.0f} ms"
        names = ", ".join(sorted(self.faults)) or "none"
        alarms = ", ".join(sorted(self.alarms)) or "none"
        return f"state {self.state}, validity {self.validity}, age {age}, faults {names}, alarms {alarms}"


class Polling:
    """Polls every 20 ms from a thread, on one connection that stays open."""

    def __init__(self, wire: Wire) -> None:
        self.seen: list[Seen] = []
        self.lost: Exception | None = None
        self._wire = wire
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> "Polling":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def since(self, moment_s: float, until_s: float = float("inf")) -> list[Seen]:
        return [seen for seen in list(self.seen) if moment_s <= seen.at_s < until_s]

    def first(self, moment_s: float, wanted, within_s: float) -> Seen:
        """First look from a moment on that is as wanted; fails when there is none in time."""
        while True:
            now_s = time.monotonic()
            for seen in self.since(moment_s):
                if wanted(seen):
                    assert seen.at_s - moment_s <= within_s, self.told(moment_s)
                    return seen
            assert self.lost is None, f"the connection was lost: {self.lost!r}{self.told(moment_s - within_s)}"
            assert now_s < moment_s + within_s + 1, f"never seen: {self.told(moment_s)}"
            time.sleep(POLL_S)

    def told(self, moment_s: float) -> str:
        """One line for each second."""
        looks = {int(seen.at_s - moment_s): seen for seen in self.since(moment_s)}
        return "".join(f"\n{second:4d} s: {seen}" for second, seen in looks.items())

    def _run(self) -> None:
        try:
            while not self._over.wait(POLL_S):
                self.seen.append(glance(self._wire))
        except OSError as error:
            self.lost = error


def glance(wire: Wire) -> Seen:
    asked_s = time.monotonic()
    block = look(wire)
    at_s = time.monotonic()
    word = block["fault_word"]
    return Seen(
        at_s,
        at_s - asked_s,
        block["device_state"],
        block["validity"],
        frozenset(name for name, bit in ALARM_BITS.items() if block["alarm_word"] >> bit & 1),
        frozenset(name for name, bit in BITS.items() if word >> bit & 1),
        block["measurement_age"],
        block["diameter"],
        block["expanded_uncertainty"],
    )
