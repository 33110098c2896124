"""Measures a recording of one uncalibrated camera over a conveyor between barriers, frame by frame."""

from functools import partial
from pathlib import Path

from tqdm import tqdm

from appliance.cameras.recording.pictures import PictureRecording, darkest
from appliance.cameras.recording.time_stamps import FrameMoments
from appliance.cameras.section import EmptyLine
from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import row_writer
from appliance.sizing.conveyor.empty_line import TimedConveyorGauge, read_background
from appliance.sizing.conveyor.plots import ConveyorPlots
from appliance.sizing.figures import figure_class
from appliance.sizing.reading_rows import COLUMNS, Judge, ReadingRows, unjudged
from appliance.sizing.summary import Summary
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

RESPONSE_HINT = "  U counts the camera's response as not known: give --response-exponent, 1 for a linear camera"
EMPTY_LINE_CAUSE = "does no frame show the line empty? give a picture of it with --background; are the barriers seen?"


def measure_conveyor(
    recording: Path,
    output: Path,
    reference: ConveyorReference,
    *,
    judge: Judge = unjudged,
    background: Path | None = None,
    compensation_mm: float = 0.0,
    near_columns: tuple[float, float] | None = None,
    response_exponent: float | None = None,
    plots: Path | None = None,
) -> list[str]:
    """Measure every frame; the output appears whole or not at all. Lines of a summary.

    Parameters
    ----------
    recording : Path
        Folder with the pictures of one camera.
    output : Path
        File to write: CSV if its suffix is `.csv`, else JSON lines.
    reference : ConveyorReference
    judge : callable
        Compares each reading with what is wanted.
    background : Path, optional
        Picture of the empty line; None uses the recording's darkest frames.
    compensation_mm : float
        Added to each diameter.
    near_columns : tuple of float, optional
        Columns of the barriers' inner edges in the middle row, where other pairs of edges show.
    response_exponent : float, optional
        Code values follow light to this power; None: not known, which widens U.
    plots : Path, optional
        Folder for plots.

    Raises
    ------
    CameraError
        The recording is missing or cannot be read.
    EmptyLineError
        The background is missing or cannot be read, or differs in size.
    PlotsMissingError
        Plots are wanted and the plotting library is not installed.
    ValueError
        The compensation is not finite, or the exponent not above 0.
    OSError
        `output` cannot be written, or the folder of plots not made.
    """
    if plots is not None:
        figure_class()  # a library that is missing is named before the recording is measured
    frames = PictureRecording(recording)
    empty = EmptyLine(darkest(frames), str(recording)) if background is None else read_background(background)
    make = partial(
        ConveyorGauge,
        reference=reference,
        compensation_mm=compensation_mm,
        near_columns=near_columns,
        response_exponent=response_exponent,
    )
    gauge = TimedConveyorGauge(empty, make)
    drawing = ConveyorPlots(plots, gauge.barriers, reference.spacing_mm) if plots is not None else None
    rows, summary, moments = ReadingRows(judge), Summary(), FrameMoments(frames.numbers)
    with whole_file(output) as file:
        write = row_writer(output, file, COLUMNS)
        for frame, picture in tqdm(frames, unit="frame", total=len(frames), disable=None):
            reading, elapsed_ms = gauge.measure(picture)
            values = rows.row(frame, reading, elapsed_ms, moments.moment_s(frame))
            summary.add(reading, values["decision"])
            write(values)
            if drawing is not None:
                drawing.add(frame, picture.shown, reading)
    if drawing is not None:
        drawing.write()
    lines = summary.lines(EMPTY_LINE_CAUSE if summary.says_nothing and background is None else "")
    return lines if response_exponent is not None or not summary.valid else [*lines, RESPONSE_HINT]
