"""Measures a recording frame by frame and writes what it found as JSON lines or CSV."""

import contextlib
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Literal

from tqdm import tqdm

from appliance.cameras.recording.pairs import Recording, read_stamps
from appliance.cameras.source import together
from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import row_writer
from appliance.sizing.reading_rows import COLUMNS, Judge, ReadingRows, unjudged
from appliance.sizing.stereo.gauge import TimedBarsGauge, TimedGauge
from appliance.sizing.stereo.plots import Plots
from appliance.sizing.stereo.rig_file import RigError, load_rig
from appliance.sizing.summary import Summary
from vision.edges.operators import EdgeMethod
from vision.readings import SizeReading
from vision.sent_picture import SentPicture
from vision.sizing.side_by_side import SideBySide
from vision.sizing.virtual_board.gauge import Fusion, VirtualBoardGauge
from vision.sizing.virtual_board.reading import VirtualBoardReading

Method = Literal["tangent", "virtual-board"]
AnyGauge = TimedBarsGauge | TimedGauge[VirtualBoardReading]

FRAME_PERIOD_US = 40_000  # of a recording without time stamps; gaps between bars are told by it
FRAMES_TRIED = 5  # with left and right exchanged, where no frame has a value


def measure_recording(
    recording: Path,
    rig: Path,
    output: Path,
    *,
    judge: Judge = unjudged,
    method: Method = "tangent",
    edges: EdgeMethod = "forest",
    fusion: Fusion = "none",
    plots: Path | None = None,
    ovality_mm: float | None = None,
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
    judge : callable
        Compares each reading with what is wanted.
    method : {"tangent", "virtual-board"}
        Route that gives the diameter: tangent planes checked by virtual boards, or virtual boards (route V) alone.
    edges : str
        Edge detector of route V alone, one of `EDGE_METHODS`.
    fusion : str
        How route V alone makes one picture out of both views, one of `FUSIONS`.
    plots : Path, optional
        Folder for plots of route V alone.
    ovality_mm : float, optional
        Greatest minus least width of a section that the product may have; without it, what is usual.

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
    calibrated = load_rig(rig)

    def make() -> AnyGauge:
        if method == "tangent":
            return TimedBarsGauge(calibrated, str(rig), ovality_mm)
        return TimedGauge(calibrated, str(rig), partial(VirtualBoardGauge, edges=edges, fusion=fusion))

    measure = _Measured(make(), drawing)
    rows, summary = ReadingRows(judge), Summary()
    with contextlib.closing(Recording(recording)) as frames, whole_file(output) as file:
        write = row_writer(output, file, COLUMNS)
        stamps = read_stamps(recording)
        for frame, left, right in tqdm(frames, unit="frame", disable=None):
            stamp = stamps.get(frame)
            readings, elapsed_ms = measure.readings(frame, left, right, stamp)
            for bar, reading in enumerate(readings):
                values = rows.row(frame, reading, elapsed_ms, stamp and stamp[0], bar=bar)
                summary.add(reading, values["decision"])
                write(values)
        cause = _exchanged(frames, make()) if summary.says_nothing else ""
    if drawing is not None:
        drawing.write()
    return summary.lines(cause)


class _Measured:
    """Readings of frames in their order, one for each bar side by side, with the passing bars' own values."""

    def __init__(self, gauge: AnyGauge, drawing: Plots | None) -> None:
        self._gauge = gauge
        self._drawing = drawing
        self._bars = SideBySide()

    def readings(
        self, frame: int, left: SentPicture, right: SentPicture, stamp: tuple[int, int] | None
    ) -> tuple[Sequence[SizeReading], float]:
        """Readings of a frame, and computing time, ms; `stamp` holds the time stamps of both exposures, µs."""
        if isinstance(self._gauge, TimedBarsGauge):
            synchronous = stamp is not None and together(*stamp)
            measured, elapsed_ms = self._gauge.measure_bars(left, right, synchronous=synchronous)
            moment_us = stamp[0] if stamp else frame * FRAME_PERIOD_US
            return self._bars.add(measured, moment_us / 1e6), elapsed_ms
        reading, elapsed_ms = self._gauge.measure(left, right)
        if self._drawing is not None:
            self._drawing.add(frame, reading)
        return (reading.size_reading(),), elapsed_ms


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
