"""Writes rows as a Parquet file, some at a time."""

import importlib
import itertools
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_place

ROWS_IN_A_GROUP = 50_000  # what is held in memory at once


class ParquetMissingError(HotgaugeError):
    """The library that writes Parquet is not installed; the message says what to do."""


def write_parquet(output: Path, kinds: Mapping[str, str], rows: Iterable[Mapping[str, Any]]) -> int:
    """Write a Parquet file whole or not at all; how many rows it has. Raises `OSError`.

    Parameters
    ----------
    output : Path
    kinds : mapping of str to str
        Columns, and what each holds: `utc` (datetime), `text`, `texts`, `integer`, `number` or `truth`.
    rows : iterable of mapping

    Raises
    ------
    ParquetMissingError
    """
    try:  # here and not at the top: a quarter of a second that only Parquet is worth
        pa: Any = importlib.import_module("pyarrow")
        pq: Any = importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        words = "Parquet needs pyarrow, which is not installed; pip install pyarrow, or write CSV"
        raise ParquetMissingError(f"{output}: {words}") from error
    types: dict[str, Any] = {
        "utc": pa.timestamp("ms", tz="UTC"),
        "text": pa.string(),
        "texts": pa.list_(pa.string()),
        "integer": pa.int64(),
        "number": pa.float64(),
        "truth": pa.bool_(),
    }
    schema = pa.schema([(name, types[kind]) for name, kind in kinds.items()])
    written, waiting = 0, iter(rows)
    with whole_place(output) as place, pq.ParquetWriter(place, schema) as writer:
        while group := list(itertools.islice(waiting, ROWS_IN_A_GROUP)):
            writer.write_table(pa.Table.from_pylist(group, schema=schema))
            written += len(group)
    return written
