"""Measures a recording frame by frame and writes what it found as JSON lines or CSV."""

import contextlib
import csv
import json
import math
import os
from collections.abc import Callable, Generator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Literal, TextIO, cast

from tqdm import tqdm

from appliance.cameras.recording import Recording
from appliance.gauging import TimedGauge
from appliance.judging import trust_percent
from appliance.plots import Plots
from appliance.rigs import load_rig
from vision.edges.operators import EdgeMethod
from vision.readings import SizeReading
from vision.sizing.gauge import Gauge
from vision.sizing.virtual_board import Fusion, VirtualBoardGauge
from vision.sizing.virtual_board_reading import VirtualBoardReading

READING_FIELDS = (
    "diameter_mm", "expanded_uncertainty_mm", "diameter_virtual_board_mm", "weighted_deviation_mm", "trust",
    "valid", "reasons", "windows_kept", "windows_total", "alignment_quality", "plane_height_mm",
    "axis_height_mm", "u_edge_mm", "u_calibration_mm", "u_board_mm", "u_light_mm", "u_shape_mm", "u_model_mm",
    "offset_mm", "method",
)  # fmt: skip

Value = float | int | bool | str | list[str] | None
Row = dict[str, Value]


Method = Literal["tangent", "virtual-board"]


def measure_recording(
    recording: Path,
    rig: Path,
    output: Path,
    *,
    method: Method = "tangent",
    edges: EdgeMethod = "forest",
    fusion: Fusion = "none",
    plots: Path | None = None,
) -> None:
    """Measure every frame of a recording; the output appears whole or not at all.

    Parameters
    ----------
    recording : Path
        Folder of a recording.
    rig : Path
        Calibration from `hotgauge calibrate`.
    output : Path
        File to write: CSV if its suffix is `.csv`, else JSON lines.
    method : {"tangent", "virtual-board"}
        Route that gives the diameter; the first is judged by the second, the second stands alone.
    edges : str
        Edge detector of route V alone, one of `EDGE_METHODS`.
    fusion : str
        How route V alone makes one picture out of both views, one of `FUSIONS`.
    plots : Path, optional
        Folder for plots of route V alone.

    Raises
    ------
    CameraError
        The recording is missing or a picture cannot be read.
    RigError
        The rig is missing, malformed, or for pictures of another size.
    PlotsMissingError
        Plots are wanted and the plotting library is not installed.
    OSError
        `output` cannot be written, or the folder of plots not made.
    """
    drawing = Plots(plots) if plots is not None else None
    gauge: TimedGauge[SizeReading | VirtualBoardReading] = TimedGauge(
        load_rig(rig),
        str(rig),
        Gauge if method == "tangent" else partial(VirtualBoardGauge, edges=edges, fusion=fusion),
    )
    with contextlib.closing(Recording(recording)) as frames, whole_file(output) as file:
        write = row_writer(output, file)
        for frame, left, right in tqdm(frames, unit="frame", disable=None):
            reading, elapsed_ms = gauge.measure(left, right)
            if isinstance(reading, VirtualBoardReading):
                if drawing is not None:
                    drawing.add(frame, reading)
                reading = reading.size_reading()
            write(row(frame, reading, elapsed_ms))
    if drawing is not None:
        drawing.write()


def row(frame: int, reading: SizeReading, elapsed_ms: float) -> Row:
    """One reading as it stands in the file; None where there is no value."""
    found = asdict(reading) | {
        "valid": reading.valid,
        "trust": trust_percent(reading),
        "reasons": reading.reasons.names,
    }
    values: Row = {name: _or_none(found[name]) for name in READING_FIELDS}
    return {"frame": frame} | values | {"elapsed_ms": round(elapsed_ms, 3)}


def _or_none(value: Value) -> Value:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def row_writer(output: Path, file: TextIO) -> Callable[[Row], None]:
    """What writes rows to a file that will have this name: CSV if its suffix is `.csv`, else JSON lines."""
    return _csv_writer(file) if output.suffix.lower() == ".csv" else _json_lines_writer(file)


def _json_lines_writer(file: TextIO) -> Callable[[Row], None]:
    def write(values: Row) -> None:
        file.write(json.dumps(values, allow_nan=False) + "\n")

    return write


def _csv_writer(file: TextIO) -> Callable[[Row], None]:
    writer = csv.DictWriter(file, ["frame", *READING_FIELDS, "elapsed_ms"])
    writer.writeheader()

    def write(values: Row) -> None:
        valid, reasons = str(values["valid"]).lower(), ";".join(cast("list[str]", values["reasons"]))
        writer.writerow(values | {"valid": valid, "reasons": reasons})

    return write


@contextlib.contextmanager
def whole_file(path: Path) -> Generator[TextIO]:
    """A text file to write that appears under its name only when all of it is written; raises `OSError`."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("x", encoding="utf-8", newline="") as file:
            yield file
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
