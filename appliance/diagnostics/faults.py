"""The fault table and the one door through which faults come and go.

A fault is trouble with the equipment, not with the bar. It owns the NE 107 class that the PLC reads as
`device_state` and a bit of `fault_word`; it is logged once when it comes and once when it goes. Codes 1xx (cameras) and
2xx (calibration) are reported by a measuring process, the others by the supervisor.
"""

import logging
from collections.abc import Callable, Mapping

from appliance.diagnostics.fault_table import FAULTS, FaultRow
from plc.codes import DeviceState

logger = logging.getLogger("hotgauge.faults")

_ROWS = {row.name: row for row in FAULTS}


class Faults:
    """The faults that are active now, and those that wait to be acknowledged.

    Parameters
    ----------
    product_id : callable
        Gives the mill's number of the product that is measured, for the log.
    """

    def __init__(self, product_id: Callable[[], int] = lambda: 0) -> None:
        self._product_id = product_id
        self._active: dict[tuple[str, str], str] = {}
        self._latched: set[str] = set()

    def report(self, name: str, *, active: bool, detail: str = "", station: str = "") -> None:
        """Say whether a fault is there; only a change is logged.

        Parameters
        ----------
        name : str
            Name in `FAULTS`.
        active : bool
        detail : str
            What exactly is wrong, for the log.
        station : str
            Station that has it; each has its own. Empty for the gauge as a whole.

        Raises
        ------
        ValueError
            `name` is not in the table.
        """
        if name not in _ROWS:
            raise ValueError(f"name: no fault is called {name!r}")
        if active == ((name, station) in self._active):
            return
        row = _ROWS[name]
        if active:
            self._active[name, station] = detail
            self._latched |= {name} if row.latching else set()
            sentence = f"fault {row.code} {name}: {detail or row.text}; {row.remedy}"
        else:
            del self._active[name, station]
            sentence = f"fault {row.code} {name} is over"
        logger.log(row.severity if active else logging.INFO, sentence, extra=self._fields(row, station))

    def report_station(self, station: str, found: Mapping[str, str]) -> None:
        """Say all that a measuring process finds wrong now, by name and detail; what it does not name is over.

        Raises
        ------
        ValueError
            A name is not in the table, or not one that a station tells.
        """
        wrong = [name for name in found if name not in _ROWS or not _ROWS[name].reported_by_station]
        if wrong:
            raise ValueError(f"found: no station tells of {wrong[0]!r}")
        for row in FAULTS:
            if row.reported_by_station:
                self.report(row.name, active=row.name in found, detail=found.get(row.name, ""), station=station)

    def acknowledge(self) -> None:
        """Say that somebody has seen the latching faults; those that are still there end with their cause."""
        self._latched.clear()

    def _fields(self, row: FaultRow, station: str) -> dict[str, object]:
        return {
            "HOTGAUGE_FAULT": row.code,
            "HOTGAUGE_FAULT_NAME": row.name,
            "HOTGAUGE_STATION": station,
            "HOTGAUGE_PRODUCT": self._product_id(),
        }

    @property
    def active(self) -> frozenset[str]:
        """Names of the faults that are there now."""
        return frozenset(name for name, _ in self._active)

    @property
    def details(self) -> Mapping[tuple[str, str], str]:
        """What exactly is wrong, by name and station, of the faults that are there now."""
        return self._active

    def active_at(self, station: str) -> frozenset[str]:
        """Names of the faults that one station has now."""
        return frozenset(name for name, at in self._active if at == station)

    @property
    def word(self) -> int:
        """Bits of `fault_word`: active faults, and latching ones that nobody has acknowledged."""
        return sum(1 << _ROWS[name].bit for name in self.active | self._latched)

    @property
    def state(self) -> DeviceState:
        """NE 107 class of the worst active fault; "maintenance required" while one waits to be acknowledged."""
        latched = [DeviceState.MAINTENANCE_REQUIRED] if self._latched else []
        return max((*latched, *(_ROWS[name].state for name in self.active)), default=DeviceState.GOOD)
