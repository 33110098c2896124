"""Measures a recording frame by frame and writes what it found as JSON lines or CSV."""

import contextlib
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Literal

from tqdm import tqdm

from appliance.cameras.recording.pairs import Recording, read_stamps
from appliance.cameras.source import together
from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import Row, row_writer
from appliance.sizing.reading_rows import COLUMNS, row
from appliance.sizing.stereo.gauge import TimedBarsGauge, TimedGauge, rig_file_gauge
from appliance.sizing.stereo.plots import Plots
from appliance.sizing.stereo.rig_file import load_rig
from vision.edges.operators import EdgeMethod
from vision.sent_picture import SentPicture
from vision.sizing.side_by_side import SideBySide
from vision.sizing.virtual_board.gauge import Fusion, VirtualBoardGauge
from vision.sizing.virtual_board.reading import VirtualBoardReading

Method = Literal["tangent", "virtual-board"]
Frames = Iterable[tuple[int, SentPicture, SentPicture]]

FRAME_PERIOD_US = 40_000  # of a recording whose time stamps are missing; gaps between bars are told by it


def measure_recording(
    recording: Path,
    rig: Path,
    output: Path,
    *,
    method: Method = "tangent",
    edges: EdgeMethod = "forest",
    fusion: Fusion = "none",
    plots: Path | None = None,
    ovality_mm: float | None = None,
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
    with contextlib.closing(Recording(recording)) as frames, whole_file(output) as file:
        write = row_writer(output, file, COLUMNS)
        shown = tqdm(frames, unit="frame", disable=None)
        if method == "tangent":
            _measure_bars(shown, rig_file_gauge(rig, ovality_mm), write, read_stamps(recording))
        else:
            make = partial(VirtualBoardGauge, edges=edges, fusion=fusion)
            gauge = TimedGauge[VirtualBoardReading](load_rig(rig), str(rig), make)
            _measure_virtual_boards(shown, gauge, write, Plots(plots) if plots is not None else None)


def _measure_bars(
    frames: Frames,
    gauge: TimedBarsGauge,
    write: Callable[[Row], None],
    stamps: Mapping[int, tuple[int, int]] | None,
) -> None:
    bars = SideBySide()
    for frame, left, right in frames:
        left_us, right_us = (stamps or {}).get(frame, (frame * FRAME_PERIOD_US, None))
        synchronous = right_us is not None and together(left_us, right_us)
        readings, elapsed_ms = gauge.measure_bars(left, right, synchronous=synchronous)
        for number, reading in enumerate(bars.add(readings, left_us / 1e6)):
            write(row(frame, reading, elapsed_ms, bar=number))


def _measure_virtual_boards(
    frames: Frames, gauge: TimedGauge[VirtualBoardReading], write: Callable[[Row], None], drawing: Plots | None
) -> None:
    for frame, left, right in frames:
        reading, elapsed_ms = gauge.measure(left, right)
        if drawing is not None:
            drawing.add(frame, reading)
        write(row(frame, reading.size_reading(), elapsed_ms))
    if drawing is not None:
        drawing.write()
