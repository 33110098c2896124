"""Writes rows as CSV if the file's suffix is `.csv`, else as JSON lines."""

import csv
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TextIO

Value = float | int | bool | str | list[str] | None
Row = dict[str, Value]


def row_writer(output: Path, file: TextIO, columns: Sequence[str]) -> Callable[[Row], None]:
    """Return a function that writes one row.

    Parameters
    ----------
    output : Path
        Name that the file will have: CSV if its suffix is `.csv`, else JSON lines.
    file : text file, open for writing
    columns : sequence of str
        Columns of a CSV file; a row may lack some. JSON lines hold the columns of each row.

    Raises
    ------
    ValueError
        The function that is returned was given a column that a CSV file lacks, or a number that JSON lacks (NaN).
    """
    return _csv_writer(file, columns) if output.suffix.lower() == ".csv" else _json_lines_writer(file)


def _json_lines_writer(file: TextIO) -> Callable[[Row], None]:
    def write(values: Row) -> None:
        file.write(json.dumps(values, allow_nan=False) + "\n")

    return write


def _csv_writer(file: TextIO, columns: Sequence[str]) -> Callable[[Row], None]:
    writer = csv.DictWriter(file, columns)
    writer.writeheader()

    def write(values: Row) -> None:
        writer.writerow({name: _as_text(value) for name, value in values.items()})

    return write


def _as_text(value: Value) -> Value:
    if isinstance(value, list):
        return ";".join(value)
    return str(value).lower() if isinstance(value, bool) else value
