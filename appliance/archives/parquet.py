"""Writes the rows of all recordings as one Parquet file."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from appliance.archives.parts import Rows
from appliance.files.columns import FileColumn
from appliance.files.parquet import write_parquet

RECORDING = FileColumn("recording", "", None, "its path below the folder that was given; stands before the others")
ERROR = FileColumn("error", "", None, "why a recording could not be measured: its only row; stands behind the others")
COUNTS = ("frame", "windows_kept", "windows_total", "time_us", "bar", "bar_number", "bar_frames")
KINDS = {
    **dict.fromkeys(COUNTS, "integer"),
    **dict.fromkeys((RECORDING.name, "method", "decision", ERROR.name), "text"),
    "valid": "truth",
    "reasons": "texts",
}


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
    ParquetMissingError
        The library of Parquet files is not installed.
    OSError
        The file cannot be written.
    """
    kinds = {column: KINDS.get(column, "number") for column in (RECORDING.name, *columns, ERROR.name)}
    write_parquet(output, kinds, ({RECORDING.name: name, **row} for name, rows in recordings for row in rows))
