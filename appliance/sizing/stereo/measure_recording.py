"""Measures a recording frame by frame and writes what it found as JSON lines or CSV."""

import contextlib
import math
from collections.abc import Callable
from pathlib import Path

from tqdm import tqdm

from appliance.cameras.recording.pairs import Recording
from appliance.cameras.recording.time_stamps import FrameMoments, read_stamps
from appliance.cameras.source import together
from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import row_writer
from appliance.sizing.reading_rows import COLUMNS, Judge, ReadingRows, unjudged
from appliance.sizing.stereo.fitted_tilt import fitted_along_line
from appliance.sizing.stereo.gauge import Measures, TimedGauge
from appliance.sizing.stereo.plots import Plots
from appliance.sizing.stereo.rig_file import RigError, load_rig
from appliance.sizing.stereo.served_plots import ServedPlots
from appliance.sizing.summary import Summary
from vision.calibration.rig import Rig
from vision.readings import SizeReading
from vision.sizing.gauge import Gauge
from vision.sizing.side_by_side import SideBySide
from vision.sizing.virtual_board.reading import VirtualBoardReading

AnyGauge = TimedGauge[SizeReading | VirtualBoardReading]

TANGENT = "tangent"
FRAMES_TRIED = 5  # with left and right exchanged, where no frame has a value


def measure_recording(
    recording: Path,
    rig: Path,
    output: Path,
    make: Callable[[Rig], Measures[SizeReading | VirtualBoardReading]] = Gauge,
    *,
    judge: Judge = unjudged,
    plots: Path | None = None,
    tilt_deg: float = 0.0,
) -> list[str]:
    """Measure every frame of a recording; the output appears whole or not at all. Lines of a summary.

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
    judge : callable
        Compares each reading with what is wanted.
    plots : Path, optional
        Folder for plots.
    tilt_deg : float
        Rise of the line along y against the boards; NaN: fitted from the bars.

    Raises
    ------
    CameraError
        The recording is missing or a picture cannot be read.
    RigError
        The rig is missing, malformed, or for pictures of another size; no bar shows the tilt that is to be fitted.
    PlotsMissingError
        `plots` is given and the plotting library is not installed.
    OSError
        `output` cannot be written, or the folder of plots not made.
    """
    drawing = Plots(plots) if plots is not None else None
    served = ServedPlots(plots) if plots is not None else None
    calibrated, told = load_rig(rig).along_line(0.0 if math.isnan(tilt_deg) else tilt_deg), []
    if math.isnan(tilt_deg):
        calibrated = fitted_along_line(calibrated, recording)
        told = [f"the line rises by {calibrated.tilt_deg:.2f} degrees along y against the boards"]
    gauge = AnyGauge(calibrated, str(rig), make)
    rows, summary, passing = ReadingRows(judge), Summary(), SideBySide()
    with contextlib.closing(Recording(recording)) as frames, whole_file(output) as file:
        write = row_writer(output, file, COLUMNS)
        stamps = read_stamps(recording)
        moments = FrameMoments(frames.numbers, stamps)
        for frame, left, right in tqdm(frames, unit="frame", disable=None):
            stamp = stamps.get(frame)
            synchronous = stamp is not None and stamp.stamped and together(stamp.left_us, stamp.right_us)
            measured, elapsed_ms = gauge.measure_bars(left, right, synchronous=synchronous)
            moment_s = moments.moment_s(frame)
            readings = passing.add([_size_reading(frame, one, gauge, drawing) for one in measured], moment_s)
            for bar, reading in enumerate(readings):
                values = rows.row(frame, reading, elapsed_ms, moment_s, time_us=stamp and stamp.left_us, bar=bar)
                summary.add(reading, values["decision"])
                if served is not None and reading.method == TANGENT:
                    served.add(frame, reading, values)
                write(values)
        cause = _exchanged(frames, AnyGauge(calibrated, str(rig), make)) if summary.says_nothing else ""
    if drawing is not None and served is not None:
        drawing.write()
        served.write()
    return told + summary.lines(cause)


def _size_reading(
    frame: int, reading: SizeReading | VirtualBoardReading, gauge: AnyGauge, drawing: Plots | None
) -> SizeReading:
    if isinstance(reading, SizeReading):
        return reading
    if drawing is not None:
        drawing.add(frame, reading, gauge.aligned_pair)
    return reading.size_reading()


def _exchanged(frames: Recording, gauge: AnyGauge) -> str:
    """Sentence if frames without a value have one once left and right are exchanged; else nothing."""
    places = [len(frames) * part // FRAMES_TRIED for part in range(FRAMES_TRIED)]
    found = [frame for place in dict.fromkeys(places) if (frame := frames.read(place)) is not None]
    try:
        valid = sum(gauge.measure(right, left)[0].valid for _, left, right in found)
    except RigError:  # cameras of unlike size
        return ""
    if 2 * valid < len(found) or not valid:
        return ""
    return f"left and right are exchanged: so exchanged, {valid} of {len(found)} frames that were tried have a value"
