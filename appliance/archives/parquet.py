"""Writes the rows of all recordings as one Parquet file."""

import importlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from appliance.archives.parts import Rows
from appliance.archives.recordings import ArchiveError
from appliance.files.atomic_file import whole_place

INTEGERS = frozenset({"frame", "windows_kept", "windows_total", "time_us", "bar"})
TEXTS = frozenset({"recording", "method", "decision", "error"})
ROWS_IN_A_GROUP = 50_000


def write_archive(output: Path, columns: Sequence[str], recordings: Iterable[tuple[str, Rows]]) -> None:
    """Write the file whole or not at all.

    Parameters
    ----------
    output : Path
    columns : sequence of str
        Of the rows; `recording` is put before them, `error` behind.
    recordings : iterable of (str, list of dict)
        Name of each recording, and its rows.

    Raises
    ------
    ArchiveError
        The library of Parquet files is not installed.
    OSError
        The file cannot be written.
    """
    try:
        pa: Any = importlib.import_module("pyarrow")
        pq: Any = importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        raise ArchiveError("--output: Parquet needs its library; pip install 'hotgauge[parquet]'") from error

    def kind(column: str) -> Any:
        if column in INTEGERS:
            return pa.int64()
        if column in TEXTS:
            return pa.string()
        return {"valid": pa.bool_(), "reasons": pa.list_(pa.string())}.get(column, pa.float64())

    schema = pa.schema([(column, kind(column)) for column in ("recording", *columns, "error")])
    with whole_place(output) as place, pq.ParquetWriter(place, schema) as writer:
        group: Rows = []
        for name, rows in recordings:
            group += [{"recording": name, **row} for row in rows]
            if len(group) >= ROWS_IN_A_GROUP:
                writer.write_table(pa.Table.from_pylist(group, schema=schema))
                group = []
        writer.write_table(pa.Table.from_pylist(group, schema=schema))
