"""Measures a recording of the black box with the settings and the scale that it brings, as they were served."""

from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from appliance.cameras.recording.names import SIDES
from appliance.cameras.recording.pairs import Recording
from appliance.cameras.recording.pictures import PictureRecording
from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import row_writer
from appliance.sizing.exact_rows import EXACT_COLUMNS, exact_row
from appliance.sizing.recorded_settings import recorded_gauge
from appliance.sizing.summary import Summary


def measure_black_box(recording: Path, output: Path) -> list[str]:
    """Measure every frame, not rounded; the output appears whole or not at all. Lines of a summary.

    Parameters
    ----------
    recording : Path
        Folder that the black box of a sizing station wrote.
    output : Path
        File to write: CSV if its suffix is `.csv`, else JSON lines.

    Raises
    ------
    CameraError
        A file of the recording cannot be read.
    ScaleError
        Its rig or its empty line cannot be used.
    OSError
        `output` cannot be written.
    """
    settings, gauge = recorded_gauge(recording)
    summary = Summary()
    with whole_file(output) as file:
        write = row_writer(output, file, EXACT_COLUMNS)
        for frame, pictures in tqdm(_frames(recording), unit="frame", disable=None):
            reading, elapsed_ms = gauge.measure(*pictures)
            adjusted = settings.adjustment.adjusted(reading)
            summary.add(adjusted)
            write(exact_row(frame, adjusted, elapsed_ms))
    return summary.lines()


def _frames(recording: Path) -> Iterator[tuple[int, tuple[object, ...]]]:
    """Number and pictures of each exposure, of two cameras or of one."""
    if (recording / SIDES[0]).is_dir():
        pairs = Recording(recording)
        for frame, left, right in pairs:
            yield frame, (left, right)
        return
    for frame, picture in PictureRecording(recording):
        yield frame, (picture,)
