"""Measures a recording frame by frame and writes what it found as JSON lines or CSV."""

import contextlib
from collections.abc import Callable
from pathlib import Path

from tqdm import tqdm

from appliance.cameras.recording.pairs import Recording
from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import row_writer
from appliance.sizing.reading_rows import COLUMNS, row
from appliance.sizing.stereo.gauge import Measures, TimedGauge
from appliance.sizing.stereo.plots import Plots
from appliance.sizing.stereo.rig_file import load_rig
from vision.calibration.rig import Rig
from vision.readings import SizeReading
from vision.sizing.gauge import Gauge
from vision.sizing.virtual_board.reading import VirtualBoardReading


def measure_recording(
    recording: Path,
    rig: Path,
    output: Path,
    make: Callable[[Rig], Measures[SizeReading | VirtualBoardReading]] = Gauge,
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
    make : callable
        Makes the gauge from the rig.
    plots : Path, optional
        Folder for plots of route V alone.

    Raises
    ------
    CameraError
        The recording is missing or a picture cannot be read.
    RigError
        The rig is missing, malformed, or for pictures of another size.
    PlotsMissingError
        `plots` is given and the plotting library is not installed.
    OSError
        `output` cannot be written, or the folder of plots not made.
    """
    drawing = Plots(plots) if plots is not None else None
    gauge = TimedGauge(load_rig(rig), str(rig), make)
    with contextlib.closing(Recording(recording)) as frames, whole_file(output) as file:
        write = row_writer(output, file, COLUMNS)
        for frame, left, right in tqdm(frames, unit="frame", disable=None):
            reading, elapsed_ms = gauge.measure(left, right)
            if isinstance(reading, VirtualBoardReading):
                if drawing is not None:
                    drawing.add(frame, reading, gauge.aligned_pair)
                reading = reading.size_reading()
            write(row(frame, reading, elapsed_ms))
    if drawing is not None:
        drawing.write()
