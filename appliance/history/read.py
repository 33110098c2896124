"""Reads the history, while it is written or after, without ever writing to it."""

import contextlib
import sqlite3
from collections.abc import Generator, Iterator
from datetime import datetime
from pathlib import Path

from appliance.history.database import FILE_NAME, undecodable_is_damage
from appliance.history.schema import HistoryError, check_readable
from appliance.history.tables import Table, Value

ROWS_AT_ONCE = 5000


def moment(text: str) -> datetime:
    """A moment as people write it, with the offset of this computer's time zone where it names none.

    Parameters
    ----------
    text : str
        ISO 8601, as `2026-11-28`, `2026-11-28T22:00` or `2026-11-28T21:00Z`.

    Raises
    ------
    ValueError
        It is none.
    """
    return datetime.fromisoformat(text).astimezone()


def to_ms(when: datetime) -> int:
    """Milliseconds since 1970 UTC."""
    return round(1000 * when.timestamp())


class History:
    """A history that is open to be read.

    Parameters
    ----------
    connection : sqlite3.Connection
    file : Path
        Its name, for sentences.
    """

    def __init__(self, connection: sqlite3.Connection, file: Path) -> None:
        self._connection = connection
        self._file = file

    def rows(self, table: Table, start: datetime, end: datetime) -> Iterator[dict[str, Value]]:
        """Rows of a table whose time is not before `start` and before `end`, in the order of time.

        Parameters
        ----------
        table : Table
        start, end : datetime
            With a time zone.

        Raises
        ------
        HistoryError
            The file is damaged.
        """
        condition = f"{table.time} >= ? AND {table.time} < ?"
        return self._select(table, condition, to_ms(start), to_ms(end))

    def lasting(self, table: Table, end_column: str, start: datetime, end: datetime) -> Iterator[dict[str, Value]]:
        """Rows that have begun before `end` and not ended before `start`, as alarms, faults and runs.

        Parameters
        ----------
        table : Table
        end_column : str
            Column of the row's end; one without an end goes on.
        start, end : datetime
            With a time zone.

        Raises
        ------
        HistoryError
            The file is damaged.
        """
        condition = f"{table.time} < ? AND ({end_column} IS NULL OR {end_column} >= ?)"
        return self._select(table, condition, to_ms(end), to_ms(start))

    def newest(self, table: Table, end: datetime) -> dict[str, Value] | None:
        """The last row from before `end`; None when there is none. Raises `HistoryError` for a damaged file."""
        condition = f"{table.time} < ?"
        rows = self._select(table, condition, to_ms(end), order=f"{table.time} DESC LIMIT 1")
        return next(rows, None)

    def _select(self, table: Table, condition: str, *values: int, order: str = "") -> Iterator[dict[str, Value]]:
        names = [column.name for column in table.columns]
        words = f"SELECT {', '.join(names)} FROM {table.name} WHERE {condition} ORDER BY {order or table.time}"
        try:
            with undecodable_is_damage():
                cursor = self._connection.execute(words, values)
                while rows := cursor.fetchmany(ROWS_AT_ONCE):
                    yield from (dict(zip(names, row, strict=True)) for row in rows)
        except sqlite3.Error as error:
            raise HistoryError(f"{self._file}: {error}; start the gauge, which sets a damaged file aside") from error


@contextlib.contextmanager
def open_to_read(folder: Path) -> Generator[History]:
    """Open the history of a folder.

    Parameters
    ----------
    folder : Path
        As in `history.directory`.

    Raises
    ------
    HistoryError
        There is none, it cannot be read, or another version has written it.
    """
    file = folder / FILE_NAME
    if not file.is_file():
        raise HistoryError(f"{file}: there is no history; set history.directory and run the gauge")
    connection: sqlite3.Connection | None = None
    try:
        connection = sqlite3.connect(f"{file.absolute().as_uri()}?mode=ro", uri=True)
        with undecodable_is_damage():
            check_readable(connection, str(file))
        yield History(connection, file)
    except sqlite3.Error as error:
        raise HistoryError(f"{file}: {error}; read it as the user of the service, or start the gauge") from error
    finally:
        if connection is not None:
            connection.close()
