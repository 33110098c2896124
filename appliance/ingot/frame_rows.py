"""Rows of the file that `orient` writes: one for each picture, one for each ingot."""

import math

from appliance.files.row_writer import Row, Value
from vision.ingot.sequential_decision import IngotDecision
from vision.readings import OrientationReading

FRAME_FIELDS = ("present", "orientation", "ssim_top", "ssim_bottom", "center_x", "center_y", "radius", "reasons")
INGOT_FIELDS = ("ingot", "orientation", "first_frame", "decided_frame", "confidence")
COLUMNS: tuple[str, ...] = tuple(dict.fromkeys(("frame", *FRAME_FIELDS, *INGOT_FIELDS)))


def frame_row(frame: int, reading: OrientationReading) -> Row:
    """Row of one reading; None for no value.

    Parameters
    ----------
    frame : int
        Number of the frame.
    reading : OrientationReading
    """
    values: Row = {"frame": frame} | {name: _or_none(getattr(reading, name)) for name in FRAME_FIELDS}
    return values | {"reasons": reading.reasons.names}


def ingot_row(decision: IngotDecision) -> Row:
    """Row of one ingot."""
    values: Row = {name: _or_none(getattr(decision, name)) for name in INGOT_FIELDS}
    return values | {"confidence": round(decision.confidence, 3)}


def _or_none(value: Value) -> Value:
    if not isinstance(value, float):
        return value
    return round(value, 4) if math.isfinite(value) else None
