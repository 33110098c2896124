"""The file of the history, an SQLite database in WAL mode: opened, written, thinned by age and size, set aside.

A commit is on the disk when it returns (`synchronous = FULL`): neither `kill -9` nor a power cut takes it back.
"""

import contextlib
import sqlite3
import time
from collections.abc import Generator, Sequence
from pathlib import Path

from appliance.history.schema import migrate
from appliance.history.tables import TABLES, VERIFICATIONS, Row

FILE_NAME = "history.db"
HEADER = b"SQLite format 3\0"
BUSY_S = 5.0  # a reader of exports holds no lock that writing needs; another writer, as `hotgauge verify`, does shortly
DELETED_AT_ONCE = 5000  # rows; one transaction of this size takes about 20 ms
FREED_AT_ONCE = 2000  # pages of 4 KiB
JOURNAL_MAX_BYTES = 16 << 20

_DAMAGE = {sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB}


def is_damage(error: sqlite3.Error) -> bool:
    """Whether an error says that the file itself is damaged, and not that it cannot be reached or written."""
    return (getattr(error, "sqlite_errorcode", 0) & 0xFF) in _DAMAGE


@contextlib.contextmanager
def undecodable_is_damage() -> Generator[None]:
    """Raise the `sqlite3.DatabaseError` that SQLite meant where Python cannot decode its message of damaged bytes."""
    try:
        yield
    except UnicodeDecodeError as error:
        raise damage("what it says of its tables is damaged") from error


def open_to_write(file: Path) -> sqlite3.Connection:
    """Open the file, make it if it is not there, and bring it to the newest version.

    Parameters
    ----------
    file : Path

    Raises
    ------
    sqlite3.Error
        It cannot be opened, or is damaged (`is_damage`).
    OSError
        Its folder cannot be made.
    HistoryError
        A newer version of the software has written it.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    connection = sqlite3.connect(file, timeout=BUSY_S, isolation_level=None, check_same_thread=False)
    try:
        connection.execute("PRAGMA auto_vacuum = INCREMENTAL")
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute(f"PRAGMA journal_size_limit = {JOURNAL_MAX_BYTES}")
        _check(connection)
        migrate(connection, str(file))
    except BaseException:
        connection.close()
        raise
    return connection


def damage(detail: str) -> sqlite3.DatabaseError:
    """The error that SQLite itself raises for a damaged file."""
    error = sqlite3.DatabaseError(detail)
    error.sqlite_errorcode = sqlite3.SQLITE_CORRUPT
    return error


def _check(connection: sqlite3.Connection) -> None:
    found = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if found != "ok":
        raise damage(found)


def is_whole(file: Path) -> bool:
    """Whether the file still begins as a database does; SQLite itself looks only at the pages that it needs."""
    try:
        with file.open("rb") as start:
            return start.read(len(HEADER)) == HEADER
    except OSError:
        return False


def set_aside(file: Path) -> Path:
    """Rename a damaged file and what belongs to it, so that a fresh one can be made; raises `OSError`."""
    stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())
    aside = file.with_name(f"{file.stem}.damaged-{stamp}-{time.monotonic_ns() % 1000:03}{file.suffix}")
    for ending in ("-wal", "-shm", ""):
        with contextlib.suppress(FileNotFoundError):
            file.with_name(file.name + ending).rename(aside.with_name(aside.name + ending))
    return aside


def write(connection: sqlite3.Connection, rows: Sequence[Row]) -> None:
    """Write rows in one transaction, all or none; raises `sqlite3.Error`."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        for row in rows:
            names = ", ".join(row.values)
            marks = ", ".join("?" * len(row.values))
            connection.execute(f"REPLACE INTO {row.table} ({names}) VALUES ({marks})", tuple(row.values.values()))
        connection.execute("COMMIT")
    except BaseException:
        with contextlib.suppress(sqlite3.Error):
            connection.execute("ROLLBACK")
        raise


def end_earlier_runs(connection: sqlite3.Connection, run_utc_ms: int) -> None:
    """Let alarms and faults that an earlier run left open end when that run was last alive."""
    for table in ("alarms", "faults"):
        connection.execute(
            f"UPDATE {table} SET gone_utc_ms = max(came_utc_ms, coalesce("
            "(SELECT alive_utc_ms FROM runs WHERE started_utc_ms = run_utc_ms), 0)) "
            "WHERE gone_utc_ms IS NULL AND run_utc_ms <> ?",
            (run_utc_ms,),
        )


def used_bytes(connection: sqlite3.Connection) -> int:
    """Size of what the file holds, without its free pages."""
    pages, free, size = (
        connection.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_count", "freelist_count", "page_size")
    )
    return (pages - free) * size


def thin(connection: sqlite3.Connection, oldest_utc_ms: int, size_max_bytes: int) -> bool:
    """Delete some of what is too old or too much, and give its room back to the disk.

    Parameters
    ----------
    connection : sqlite3.Connection
    oldest_utc_ms : int
        Rows from before this moment are deleted; verifications stay, for a calibration is due by the last of them.
    size_max_bytes : int
        While the file holds more, the oldest readings are deleted, and when there are none the oldest bars.

    Returns
    -------
    bool
        Whether there is more to delete; a call takes tens of milliseconds, so that rows are written in between.
    """
    before = connection.total_changes
    for table in TABLES:
        if table is not VERIFICATIONS:
            _delete_oldest(connection, table.name, table.time, oldest_utc_ms)
    if used_bytes(connection) > size_max_bytes:
        by_worth = (table for table in TABLES if table.name in {"readings", "bars"})
        for table in by_worth:
            if _delete_oldest(connection, table.name, table.time, None):
                break
    connection.executescript(f"PRAGMA incremental_vacuum({FREED_AT_ONCE})")  # `execute` would free one page
    return connection.total_changes > before


def _delete_oldest(connection: sqlite3.Connection, table: str, time_column: str, before_utc_ms: int | None) -> bool:
    """Delete the oldest rows, at most `DELETED_AT_ONCE`, from before a moment or whatever they are from."""
    condition = "" if before_utc_ms is None else f"WHERE {time_column} < {before_utc_ms}"
    newest = connection.execute(
        f"SELECT max({time_column}) FROM "
        f"(SELECT {time_column} FROM {table} {condition} ORDER BY {time_column} LIMIT {DELETED_AT_ONCE})"
    ).fetchone()[0]
    if newest is None:
        return False
    connection.execute(f"DELETE FROM {table} WHERE {time_column} <= ?", (newest,))
    return True
