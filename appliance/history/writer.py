"""The thread that writes the history: it may wait for the disk, those who give it rows never do.

Rows wait in memory while the disk cannot be written, up to a limit; then they are dropped and counted, readings first.
"""

import contextlib
import itertools
import sqlite3
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

from appliance.history import database
from appliance.history.schema import HistoryError
from appliance.history.settings import HistorySettings
from appliance.history.tables import Row, Value

COMMIT_PERIOD_S = 1.0
RETRY_PERIOD_S = 5.0
ALIVE_PERIOD_S = 10.0  # a run that is killed ends, in the history, at most this long before its true end
THINNING_PERIOD_S = 600.0
ROWS_WAITING_MAX = 10_000  # about 15 MB
READINGS_WAITING_MAX = 5_000  # at two readings a second about 40 minutes
ROWS_AT_ONCE = 1000
DAMAGE_REMEMBERED_S = 60.0
STOP_WITHIN_S = 2.0  # the service manager kills after 5 s
MS_PER_DAY = 86_400_000


class HistoryWriter:
    """Writes rows into the history, in a thread of its own.

    Parameters
    ----------
    folder : Path
        Made when it is not there.
    settings : HistorySettings
    run_utc_ms : int
        Start of this run, by which its rows are known.
    version : str
        Version of the software, for the table of runs.
    wall : callable
        Wall time, seconds since 1970.

    Attributes
    ----------
    dropped : int
        Rows that were given up because the disk could not be written for too long.
    trouble : str
        Why nothing can be written now; empty while it can.
    """

    def __init__(
        self,
        folder: Path,
        settings: HistorySettings,
        run_utc_ms: int,
        *,
        version: str,
        wall: Callable[[], float] = time.time,
    ) -> None:
        self.dropped = 0
        self.trouble = ""
        self._file = folder / database.FILE_NAME
        self._settings = settings
        self._run_utc_ms = run_utc_ms
        self._version = version
        self._wall = wall
        self._waiting: deque[Row] = deque()
        self._lock = threading.Lock()  # held for a moment, never while the disk is waited for
        self._stopping = threading.Event()
        self._connection: sqlite3.Connection | None = None
        self._damage = ""
        self._damaged_s = 0.0
        self._alive_s = self._thinned_s = -ALIVE_PERIOD_S
        self._thread = threading.Thread(target=self._run, name="history", daemon=True)

    def start(self) -> None:
        """Begin to write."""
        self._thread.start()

    def stop(self) -> None:
        """Write what waits and end; a disk that does not answer is given up after `STOP_WITHIN_S`."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(STOP_WITHIN_S)

    def put(self, row: Row) -> None:
        """Have a row written; never waits. A row too many is dropped and counted."""
        with self._lock:
            limit = READINGS_WAITING_MAX if row.table == "readings" else ROWS_WAITING_MAX
            if len(self._waiting) >= limit:
                self.dropped += 1
            else:
                self._waiting.append(row)

    @property
    def damage(self) -> str:
        """What was found damaged and set aside within the last minute; empty when nothing was."""
        return self._damage if time.monotonic() - self._damaged_s < DAMAGE_REMEMBERED_S else ""

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                pause_s = COMMIT_PERIOD_S if self._try() else RETRY_PERIOD_S
                self._stopping.wait(pause_s)
            self._alive_s -= ALIVE_PERIOD_S  # the end of this run is to be written
            self._try()
            self._close()
        finally:
            if not self._stopping.is_set():
                self.trouble = "nothing is written any more; send the log to the maker"

    def _try(self) -> bool:
        """Write what waits; whether that could be done."""
        try:
            with database.undecodable_is_damage():
                self._write_waiting()
        except sqlite3.Error as error:
            self._close()
            if database.is_damage(error):
                return self._replace(str(error))
            self.trouble = f"{self._file}: {error}"
        except (OSError, HistoryError) as error:
            self._close()
            self.trouble = str(error)
        else:
            self.trouble = ""
        return not self.trouble

    def _write_waiting(self) -> None:
        if self._connection is not None and not database.is_whole(self._file):
            raise database.damage("the file was overwritten or is gone")
        connection = self._connection = self._connection or self._open()
        self._note_alive(connection)
        while rows := self._oldest():
            database.write(connection, rows)
            with self._lock:
                for _ in rows:
                    self._waiting.popleft()
        self._thin(connection)

    def _open(self) -> sqlite3.Connection:
        connection = database.open_to_write(self._file)
        database.end_earlier_runs(connection, self._run_utc_ms)
        return connection

    def _oldest(self) -> list[Row]:
        with self._lock:
            return list(itertools.islice(self._waiting, ROWS_AT_ONCE))

    def _note_alive(self, connection: sqlite3.Connection) -> None:
        if time.monotonic() - self._alive_s < ALIVE_PERIOD_S:
            return
        values: dict[str, Value] = {
            "started_utc_ms": self._run_utc_ms,
            "alive_utc_ms": round(1000 * self._wall()),
            "version": self._version,
        }
        database.write(connection, [Row("runs", values)])
        self._alive_s = time.monotonic()

    def _thin(self, connection: sqlite3.Connection) -> None:
        if time.monotonic() - self._thinned_s < THINNING_PERIOD_S:
            return
        oldest_utc_ms = round(1000 * self._wall()) - self._settings.days * MS_PER_DAY
        if not database.thin(connection, oldest_utc_ms, self._settings.size_max_mb << 20):
            self._thinned_s = time.monotonic()

    def _replace(self, detail: str) -> bool:
        """Set a damaged file aside, so that the next round makes a fresh one; whether that could be done."""
        try:
            aside = database.set_aside(self._file)
        except OSError as error:
            self.trouble = f"{self._file}: {detail}; it cannot be set aside: {error.strerror}"
            return False
        self._damage = f"{self._file}: {detail}; kept as {aside.name}"
        self._damaged_s = time.monotonic()
        self._alive_s -= ALIVE_PERIOD_S  # the fresh file knows nothing of this run
        return True

    def _close(self) -> None:
        if self._connection is not None:
            with contextlib.suppress(sqlite3.Error):
                self._connection.close()
            self._connection = None
