"""Set points and commands that the PLC has written, kept over a restart in one small file.

The file is replaced whole, at most once a second and only after changes, by a thread, so that a slow disk delays no
publication. A disk that fails is a fault; the values in memory still count.
"""

import asyncio
import json
import logging
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
HOLD_RIGHTS = "hold_rights"  # key of the file: who might write, and so release, when the PLC began to hold
SAVE_PERIOD_S = 1.0  # chosen: shortest time between two writes

Written = dict[str, int | bool]
Kept = Mapping[str, int | bool | str]
Report = Callable[[str, str], None]
"""Receives the name of a fault and its detail; an empty detail ends the fault."""

logger = logging.getLogger("hotgauge.set_points")

_NOTHING_SET = SetPoints()
_NOT_KEPT = {"plc_heartbeat"}
_ROWS = {row.name: row for row in select(REGISTERS, "holding", "rw") if row.name not in _NOT_KEPT}


class PlcInputsError(HotgaugeError):
    """The file of set points cannot be used; the message says why."""


def read(file: Path) -> Kept:
    """Read the set points and commands of a file; nothing if there is no file.

    Raises
    ------
    PlcInputsError
        The file cannot be read, has not the form that `write` gives it, or holds a number outside a set point's bounds.
    """
    try:
        kept: object = json.loads(file.read_bytes())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise PlcInputsError(f"{file}: {error}") from error
    if not isinstance(kept, dict):
        raise PlcInputsError(f"{file}: not a table of set points")
    written = cast("dict[str, int | bool | str]", kept)
    wrong = [name for name, number in written.items() if not _is_possible(name, number)]
    if wrong:
        raise PlcInputsError(f"{file}: {wrong[0]} is not what the PLC can have written")
    return written


def _is_possible(name: str, number: object) -> bool:
    if name == "hold":
        return isinstance(number, bool)
    if name == HOLD_RIGHTS:
        return isinstance(number, str)
    if isinstance(number, bool) or not isinstance(number, int):
        return False
    return name in _ROWS and _ROWS[name].accepts(number)


def write(file: Path, written: Kept) -> None:
    """Replace the file whole: a power cut leaves the old file or the new one.

    Parameters
    ----------
    file : Path
        Its folder is made if it is missing.
    written : mapping of str to int, bool or str
        Numbers of set points and levels of commands, by name, and the rights under which a hold was begun.

    Raises
    ------
    OSError
        The file or its folder cannot be written.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(file) as text:
        json.dump(written, text, indent=1)


class PlcInputs:
    """Set points, commands and heartbeat that the PLC has written.

    Parameters
    ----------
    folder : Path or None
        Folder of the file; None keeps the values in memory only.
    report : callable
        Receives the name of a fault of the disk and its detail; an empty detail ends the fault.
    settings : SetPoints
        What counts as long as the PLC has not set it.
    rights : str
        Who may write, in words. A hold that was begun under other rights is not taken over: nobody could release it.

    Attributes
    ----------
    settings : SetPoints
    written : dict of str to int or bool
        Unscaled numbers of set points and levels of commands, by name.
    heartbeat_s : float or None
        Monotonic time at which the PLC last changed its heartbeat; None before the first time.
    """

    def __init__(
        self, folder: Path | None, report: Report, settings: SetPoints = _NOTHING_SET, rights: str = ""
    ) -> None:
        self.settings = settings
        self._rights = rights
        self.written: Written = {}
        self.heartbeat_s: float | None = None
        self._file = None if folder is None else folder / FILE_NAME
        self._report = report
        self._saved: Kept | None = {}
        self._changed = asyncio.Event()
        self._one_at_a_time = threading.Lock()

    def load(self) -> None:
        """Read the file; one that cannot be used is a fault until the next save, which `keep` begins with."""
        if self._file is None:
            return
        try:
            self._saved = read(self._file)
        except PlcInputsError as error:
            self._report("set_points_unreadable", str(error))
            self._saved = None
            self._changed.set()
            return
        self.written = {name: value for name, value in self._saved.items() if not isinstance(value, str)}
        if self._saved.get(HOLD_RIGHTS, self._rights) != self._rights:
            logger.warning("plc.writes or plc.writers has changed while the PLC held the gauge: the hold is not kept")
            self.written["hold"] = False
            self._changed.set()

    @property
    def points(self) -> SetPoints:
        """Target, tolerances, temperature and grade; what the PLC has set counts more than the settings."""
        return SetPoints.from_words(self.written).over(self.settings)

    @property
    def held(self) -> bool:
        """Whether the PLC holds the gauge."""
        return bool(self.written.get("hold"))

    @property
    def product_id(self) -> int:
        """The mill's number of the product being measured."""
        return int(self.written.get("product_id", 0))

    def add(self, changed: Mapping[str, int | bool]) -> None:
        """Add values that the PLC has just written, by name."""
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
        """Write the file now if values have changed; `keep` repeats a write that failed."""
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

    def _write(self, file: Path, to_keep: Kept) -> None:
        with self._one_at_a_time:  # the save at shutdown may overlap with one of `keep`
            write(file, to_keep)

    def _to_keep(self) -> Kept:
        kept = {name: value for name, value in self.written.items() if name in _ROWS or name == "hold"}
        return kept | {HOLD_RIGHTS: self._rights} if self.held and self._rights else kept
