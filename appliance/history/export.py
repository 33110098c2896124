"""Writes a table of the history as CSV or Parquet, in units and words.

Each time is two columns: `..._utc` and `..._local`, the latter in this computer's time zone with its offset.
"""

import csv
import functools
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from appliance.files import parquet
from appliance.files.atomic_file import whole_file
from appliance.history.tables import Column, Table, Value
from plc.codes import Decision
from vision.reasons import Reason

Exported = dict[str, Any]  # datetime, str, int, float, bool or None, as `column_kinds` says


def column_kinds(table: Table) -> dict[str, str]:
    """Columns of an exported table, and what each holds: `utc`, `text`, `integer`, `number` or `truth`."""
    kinds: dict[str, str] = {}
    for column in table.columns:
        if column.kind == "time":
            name = column.name.removesuffix("_utc_ms")
            kinds |= {f"{name}_utc": "utc", f"{name}_local": "text"}
        else:
            kinds[column.name] = "text" if column.kind in {"decision", "reasons"} else column.kind
    return kinds


def exported(table: Table, row: dict[str, Value]) -> Exported:
    """A row of the history in units and words."""
    values: Exported = {}
    for column in table.columns:
        value = row[column.name]
        if column.kind == "time":
            values |= _times(column.name.removesuffix("_utc_ms"), value)
        else:
            values[column.name] = None if value is None else _in_words(column, value)
    return values


def write_csv(table: Table, rows: Iterable[dict[str, Value]], output: Path) -> int:
    """Write a CSV file; how many rows it has. Raises `OSError`.

    Parameters
    ----------
    table : Table
    rows : iterable of dict
        As the history has them.
    output : Path
    """
    written = 0
    with whole_file(output) as file:
        writer = csv.DictWriter(file, column_kinds(table))
        writer.writeheader()
        for row in rows:
            writer.writerow({name: _as_text(value) for name, value in exported(table, row).items()})
            written += 1
    return written


def write_parquet(table: Table, rows: Iterable[dict[str, Value]], output: Path) -> int:
    """Write a Parquet file; how many rows it has. Raises `OSError`.

    Parameters
    ----------
    table : Table
    rows : iterable of dict
        As the history has them.
    output : Path

    Raises
    ------
    ParquetMissingError
    """
    return parquet.write_parquet(output, column_kinds(table), (exported(table, row) for row in rows))


def _times(name: str, utc_ms: Value) -> Exported:
    if utc_ms is None:
        return {f"{name}_utc": None, f"{name}_local": None}
    when, local = _both_times(float(utc_ms))
    return {f"{name}_utc": when, f"{name}_local": local}


@functools.lru_cache(maxsize=64)  # the run's time stands in every row
def _both_times(utc_ms: float) -> tuple[datetime, str]:
    when = datetime.fromtimestamp(utc_ms / 1000, tz=UTC)
    return when, when.astimezone().isoformat(timespec="milliseconds")


@functools.lru_cache(maxsize=1024)  # few combinations occur, and flags are slow to name
def _reason_names(bits: int) -> str:
    return ";".join(Reason(bits).names)


def _in_words(column: Column, value: float | str) -> float | str | bool:
    if column.kind == "decision":
        return Decision(int(value)).text
    if column.kind == "reasons":
        return _reason_names(int(value))
    return bool(value) if column.kind == "truth" else value


def _as_text(value: datetime | str | float | None) -> object:
    if isinstance(value, datetime):
        return value.isoformat(timespec="milliseconds").replace("+00:00", "Z")
    return str(value).lower() if isinstance(value, bool) else value
