"""Rows of the file that `measure` writes, one for each reading."""

import math
from dataclasses import asdict

from appliance.files.row_writer import Row, Value
from appliance.sizing.trust import trust_percent
from vision.readings import SizeReading

READING_FIELDS = (
    "diameter_mm", "expanded_uncertainty_mm", "diameter_virtual_board_mm", "weighted_deviation_mm", "trust",
    "valid", "reasons", "windows_kept", "windows_total", "alignment_quality", "plane_height_mm",
    "axis_height_mm", "u_edge_mm", "u_calibration_mm", "u_board_mm", "u_light_mm", "u_shape_mm", "u_model_mm",
    "offset_mm", "method", "u_motion_mm", "wander_px", "camber_mm", "u_camber_mm", "bar_frames", "bar_diameter_mm",
    "bar_expanded_uncertainty_mm", "bar_ovality_mm", "bar_ovality_expanded_uncertainty_mm",
)  # fmt: skip
COLUMNS = ("frame", "bar", *READING_FIELDS, "elapsed_ms")


def row(frame: int, reading: SizeReading, elapsed_ms: float, *, bar: int = 0) -> Row:
    """Row of one reading; None for no value.

    Parameters
    ----------
    frame : int
        Number of the frame.
    reading : SizeReading
    elapsed_ms : float
        Computing time.
    bar : int
        Number of the bar, from smaller x, where there are several side by side.
    """
    found = asdict(reading) | {
        "valid": reading.valid,
        "trust": trust_percent(reading),
        "reasons": reading.reasons.names,
    }
    values: Row = {name: _or_none(found[name]) for name in READING_FIELDS}
    return {"frame": frame, "bar": bar} | values | {"elapsed_ms": round(elapsed_ms, 3)}


def _or_none(value: Value) -> Value:
    return None if isinstance(value, float) and not math.isfinite(value) else value
