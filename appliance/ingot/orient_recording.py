"""Reads the orientation of ingots in a recording and writes frames and ingots as JSON lines or CSV."""

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import TextIO

from tqdm import tqdm

from appliance.cameras.recording.pictures import PictureRecording
from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import Row, row_writer
from appliance.ingot.annotated_pictures import Plot
from appliance.ingot.frame_rows import FRAME_COLUMNS, INGOT_COLUMNS, frame_row, ingot_row
from appliance.ingot.learning import Confirmation, Learning
from appliance.ingot.reader_setup import decision_rule, load_view, make_reader
from appliance.ingot.settings import IngotSettings
from appliance.ingot.summary import Summary
from vision.ingot.sequential_decision import IngotFollower


def orient_recording(
    recording: Path,
    references: Path,
    output: Path,
    settings: IngotSettings,
    *,
    plot: Path | None = None,
    learn: Confirmation | None = None,
) -> list[str]:
    """Read every picture of a recording; the output appears whole or not at all. Lines of a summary.

    Parameters
    ----------
    recording : Path
        Folder with the pictures of one camera.
    references : Path
        Folder with `top.png`, `bottom.png` and perhaps `roi.json`.
    output : Path
        File to write: JSON lines of frames and ingots; with the suffix `.csv` frames alone, and ingots in
        `ingots_file`.
    settings : IngotSettings
        Classifier, limits, regions and rule of decision.
    plot : Path or None
        Folder for annotated frames and a strip of the ends.
    learn : {"agreement", "top", "bottom"}, optional
        Learn references from ingots whose pictures agree, or that an operator says are all of one kind.

    Raises
    ------
    CameraError
        The recording is missing or a picture cannot be read.
    ReferencesError
        References, regions or limits cannot be used.
    OSError
        A file cannot be written.
    """
    view = load_view(references)
    frames = PictureRecording(recording)
    pictures = Plot(plot) if plot is not None else None
    learning = Learning(references, settings, learn) if learn is not None else None
    summary = Summary()
    with contextlib.ExitStack() as files:
        write_frame, write_ingot = _writers(output, files)
        follower = IngotFollower(decision_rule(settings.decision))
        reader = None
        for frame, sent in tqdm(frames, unit="frame", disable=None):
            picture = sent.shown
            reader = reader or make_reader(settings, view, picture)
            reading = reader.read(picture)
            summary.add_frame(reading)
            write_frame(frame_row(frame, reading))
            for decision in follower.add(frame, reading):
                summary.add_ingot(decision)
                write_ingot(ingot_row(decision))
            if learning is not None and learning.add(frame, picture, reading, follower.current):
                view, reader = load_view(references), None
            if pictures is not None:
                pictures.add(frame, picture, reading, follower.current)
        for decision in follower.end():
            summary.add_ingot(decision)
            write_ingot(ingot_row(decision))
    if pictures is not None:
        pictures.write_strip()
    return [*summary.lines(), *([learning.line] if learning is not None else [])]


def ingots_file(output: Path) -> Path:
    """File of the ingots beside a CSV file of the frames: `ends-ingots.csv` beside `ends.csv`."""
    return output.with_name(f"{output.stem}-ingots{output.suffix}")


def _writers(output: Path, files: contextlib.ExitStack) -> tuple[Callable[[Row], None], Callable[[Row], None]]:
    """Functions that write a frame's row and an ingot's: into one file of JSON lines, or into two of CSV."""
    frames: TextIO = files.enter_context(whole_file(output))
    write_frame = row_writer(output, frames, [column.name for column in FRAME_COLUMNS])
    if output.suffix.lower() != ".csv":
        return write_frame, write_frame
    ingots: TextIO = files.enter_context(whole_file(ingots_file(output)))
    return write_frame, row_writer(output, ingots, [column.name for column in INGOT_COLUMNS])
