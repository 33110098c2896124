"""Rows of readings with all their digits: of the black box, whose recordings are measured again to the last bit."""

import math
from collections.abc import Sequence
from dataclasses import asdict

from appliance.files.row_writer import Row, Value
from appliance.sizing.reading_rows import READING_COLUMNS
from appliance.sizing.trust import trust_percent
from vision.readings import SizeReading

EXACT_COLUMNS = ("frame", *(column.name for column in READING_COLUMNS), "marks_moved_px", "elapsed_ms")


def exact_row(frame: int, reading: SizeReading, elapsed_ms: float) -> Row:
    """Row of one reading, not rounded; None for no value.

    Parameters
    ----------
    frame : int
        Number of the frame.
    reading : SizeReading
    elapsed_ms : float
        Computing time.
    """
    found: dict[str, Value] = asdict(reading) | {
        "frame": frame,
        "valid": reading.valid,
        "trust": trust_percent(reading),
        "reasons": reading.reasons.names,
        "elapsed_ms": elapsed_ms,
    }
    return {name: _or_none(found[name]) for name in EXACT_COLUMNS}


def exact_rows(frame: int, readings: Sequence[SizeReading], elapsed_ms: float) -> list[Row]:
    """Rows of one exposure, one for each bar that lies beside another; see `exact_row`.

    Parameters
    ----------
    frame : int
    readings : sequence of SizeReading
    elapsed_ms : float
    """
    return [exact_row(frame, reading, elapsed_ms) for reading in readings]


def _or_none(value: Value) -> Value:
    return None if isinstance(value, float) and not math.isfinite(value) else value
