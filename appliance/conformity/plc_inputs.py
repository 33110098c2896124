"""What the PLC has written, kept over a restart in one small file.

The file is replaced whole, at most once a second and only when something has changed; the disk is waited for in
a thread. Trouble with the disk is a fault, and what the PLC has written still counts.
"""

import asyncio
import json
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import cast

from appliance.conformity.set_points import SetPoints
from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_file
from plc.registers import REGISTERS
from plc.rows import select

FILE_NAME = "set_points.json"
SAVE_PERIOD_S = 1.0

Written = dict[str, int | bool]
Report = Callable[[str, str], None]
"""Gets the name of a fault, and what exactly is wrong, empty when nothing is any more."""

_NOTHING_SET = SetPoints()
_NOT_KEPT = {"plc_heartbeat"}
_ROWS = {row.name: row for row in select(REGISTERS, "holding", "rw") if row.name not in _NOT_KEPT}


class PlcInputsError(HotgaugeError):
    """The file cannot be used; the message says why."""


def read(file: Path) -> Written:
    """What was kept in a file; nothing if there is no file.

    Raises
    ------
    PlcInputsError
        The file cannot be read, is not what `write` writes, or holds a number that the PLC could not have written.
    """
    try:
        kept: object = json.loads(file.read_bytes())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise PlcInputsError(f"{file}: {error}") from error
    if not isinstance(kept, dict):
        raise PlcInputsError(f"{file}: not a table of set points")
    written = cast("Written", kept)
    wrong = [name for name, number in written.items() if not _is_possible(name, number)]
    if wrong:
        raise PlcInputsError(f"{file}: {wrong[0]} is not what the PLC can have written")
    return written


def _is_possible(name: str, number: object) -> bool:
    if name == "hold":
        return isinstance(number, bool)
    if isinstance(number, bool) or not isinstance(number, int):
        return False
    return name in _ROWS and _ROWS[name].accepts(number)


def write(file: Path, written: Mapping[str, int | bool]) -> None:
    """Replace the file whole, so that a power cut leaves the old one or the new one; raises OSError."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(file) as text:
        json.dump(written, text, indent=1)


class PlcInputs:
    """What the PLC has written, in one place.

    Parameters
    ----------
    folder : Path or None
        Where it is kept; None keeps it in memory only.
    report : callable
        Gets the name of a fault of the disk, and what is wrong, empty when nothing is.
    settings : SetPoints
        What counts as long as the PLC has not set it.

    Attributes
    ----------
    settings : SetPoints
    written : dict of str to int or bool
        Numbers in the words of set points, and levels of commands, by name.
    heartbeat_s : float or None
        Monotonic time at which the PLC last changed its heartbeat; None before the first time.
    """

    def __init__(self, folder: Path | None, report: Report, settings: SetPoints = _NOTHING_SET) -> None:
        self.settings = settings
        self.written: Written = {}
        self.heartbeat_s: float | None = None
        self._file = None if folder is None else folder / FILE_NAME
        self._report = report
        self._saved: Written = {}
        self._changed = asyncio.Event()
        self._one_at_a_time = threading.Lock()

    def load(self) -> None:
        """Take up what was kept; a file that cannot be used is a fault until a new one is written."""
        if self._file is None:
            return
        try:
            self.written = read(self._file)
        except PlcInputsError as error:
            self._report("set_points_unreadable", str(error))
        self._saved = self._to_keep()

    @property
    def points(self) -> SetPoints:
        """Target, tolerances, temperature and grade; what the PLC has set counts more than the settings."""
        return SetPoints.of(self.written).over(self.settings)

    @property
    def held(self) -> bool:
        """Whether the PLC holds the gauge."""
        return bool(self.written.get("hold"))

    @property
    def product_id(self) -> int:
        """The mill's number of the product that is measured."""
        return int(self.written.get("product_id", 0))

    def add(self, changed: Mapping[str, int | bool]) -> None:
        """Add what the PLC has just written."""
        self.written |= changed
        if "plc_heartbeat" in changed:
            self.heartbeat_s = time.monotonic()
        self._changed.set()

    async def keep(self) -> None:
        """Write the file after changes until cancelled."""
        while True:
            await self._changed.wait()
            self._changed.clear()
            await self.save()
            await asyncio.sleep(SAVE_PERIOD_S)

    async def save(self) -> None:
        """Write the file now if it differs; on failure it is tried again with the next round of `keep`."""
        to_keep = self._to_keep()
        if self._file is None or to_keep == self._saved:
            return
        try:
            await asyncio.to_thread(self._write, self._file, to_keep)
        except OSError as error:
            self._report("set_points_not_saved", f"{self._file}: {error.strerror}")
            self._changed.set()
            return
        self._saved = to_keep
        self._report("set_points_not_saved", "")
        self._report("set_points_unreadable", "")

    def _write(self, file: Path, to_keep: Written) -> None:
        with self._one_at_a_time:  # the last save may begin while one is still under way
            write(file, to_keep)

    def _to_keep(self) -> Written:
        return {name: value for name, value in self.written.items() if name in _ROWS or name == "hold"}
