"""The history of a running appliance: its rows, its thread, its faults. Without a directory nothing is kept."""

import asyncio
import contextlib
import importlib.metadata
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from appliance.conformity.plc_inputs import PlcInputs
from appliance.diagnostics.alarms import Alarms
from appliance.diagnostics.faults import Faults
from appliance.history.recorder import Recorder
from appliance.history.schema import HistoryError
from appliance.history.settings import HistorySettings
from appliance.history.tables import Row
from appliance.history.verified import calibration_due
from appliance.history.writer import HistoryWriter

VERIFICATION_PERIOD_S = 30.0


class HistoryKeeper:
    """Keeps the history while the appliance runs.

    Parameters
    ----------
    settings : HistorySettings
    inputs : PlcInputs
        What the PLC has written.
    trust_min : float
        Mean trust below which a bar is undecided.
    deliver : callable, optional
        Gets each row, too, whether or not a history is kept; must not wait.
    wall : callable
        Wall time, seconds since 1970.

    Attributes
    ----------
    recorder : Recorder
        Gets what is to be kept.
    """

    def __init__(
        self,
        settings: HistorySettings,
        inputs: PlcInputs,
        *,
        trust_min: float,
        deliver: Callable[[Row], None] | None = None,
        wall: Callable[[], float] = time.time,
    ) -> None:
        run_utc_ms = round(1000 * wall())
        self._writer: HistoryWriter | None = None
        if settings.directory is not None:
            version = importlib.metadata.version("hotgauge")
            self._writer = HistoryWriter(settings.directory, settings, run_utc_ms, version=version, wall=wall)
        self._deliver = deliver
        self.recorder = Recorder(self._put, run_utc_ms, settings, inputs, trust_min=trust_min, wall=wall)
        self._folder = settings.directory
        self._due_days = settings.verification_due_days
        self._due = ""
        self._wall = wall

    async def keep(self) -> None:
        """Write until cancelled."""
        if self._writer is not None:
            self._writer.start()
        while True:
            await asyncio.sleep(VERIFICATION_PERIOD_S)
            if self._folder is not None:
                with contextlib.suppress(HistoryError):  # one that cannot be read now does not lift a due date
                    self._due = await asyncio.to_thread(self._find_due, self._folder)

    def _find_due(self, folder: Path) -> str:
        """Whether the calibration in force is verified; `hotgauge verify` is another process."""
        if not self.recorder.calibration:
            return ""
        now = datetime.fromtimestamp(self._wall(), tz=UTC)
        return calibration_due(folder, self.recorder.calibration, self._due_days, now)

    def update(self, faults: Faults, alarms: Alarms) -> None:
        """Keep what has changed in faults and alarms since the last call, and tell of trouble with the disk.

        Parameters
        ----------
        faults : Faults
            Also gets the history's own.
        alarms : Alarms
        """
        if self._writer is not None:
            trouble, damage = self._writer.trouble, self._writer.damage
            faults.report("history_not_written", active=bool(trouble), detail=trouble)
            faults.report("history_damaged", active=bool(damage), detail=damage)
        faults.report("calibration_due", active=bool(self._due), detail=self._due)
        self.recorder.update_faults(faults.details)
        self.recorder.update_alarms(alarms.active, alarms.unacknowledged)

    async def stop(self) -> None:
        """Write what is left; a disk that does not answer is given up after a while."""
        self.recorder.end_bar()
        self.recorder.end_day()
        if self._writer is not None:
            await asyncio.to_thread(self._writer.stop)

    def _put(self, row: Row) -> None:
        if self._writer is not None:
            self._writer.put(row)
        if self._deliver is not None:
            self._deliver(row)
