"""Writes the rows of all recordings as one Parquet file."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from appliance.archives.parts import Rows
from appliance.files.parquet import write_parquet

COUNTS = ("frame", "windows_kept", "windows_total", "time_us", "bar", "bar_number", "bar_frames")
KINDS = {
    **dict.fromkeys(COUNTS, "integer"),
    **dict.fromkeys(("recording", "method", "decision", "error"), "text"),
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
    kinds = {column: KINDS.get(column, "number") for column in ("recording", *columns, "error")}
    write_parquet(output, kinds, ({"recording": name, **row} for name, rows in recordings for row in rows))
