"""Measures a recording of the black box with the settings and the scale that it brings, as they were served."""

from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from appliance.cameras.recording.names import SIDES
from appliance.cameras.recording.pairs import Recording
from appliance.cameras.recording.pictures import PictureRecording
from appliance.cameras.recording.time_stamps import read_stamps
from appliance.cameras.source import Frame, FramePair
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
        for exposed in tqdm(_exposures(recording), unit="frame", disable=None):
            readings, elapsed_ms = gauge.measure_exposed(exposed)
            for reading in readings:
                adjusted = settings.adjustment.adjusted(reading)
                summary.add(adjusted)
                write(exact_row(exposed.sequence, adjusted, elapsed_ms))
    return summary.lines()


def _exposures(recording: Path) -> Iterator[FramePair | Frame]:
    """Exposures of two cameras or of one, as the gauge had them; moments do not count."""
    if not (recording / SIDES[0]).is_dir():
        for number, picture in PictureRecording(recording):
            yield Frame(picture.shown, number, 0.0, 0, sent=picture)
        return
    stamps = read_stamps(recording)
    for number, left, right in Recording(recording):
        stamp = stamps[number]
        yield FramePair(
            left.shown,
            right.shown,
            sequence=number,
            left_us=stamp.left_us,
            right_us=stamp.right_us,
            exposed_monotonic_s=0.0,
            exposed_utc_ms=0,
            stamped=stamp.stamped,
            sent=(left, right),
            range_mm=stamp.range_mm,
        )
