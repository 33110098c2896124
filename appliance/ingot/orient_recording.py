"""Reads the orientation of ingots in a recording and writes frames and ingots as JSON lines or CSV."""

from pathlib import Path

from tqdm import tqdm

from appliance.cameras.recording.pictures import PictureRecording
from appliance.files.atomic_file import whole_file
from appliance.files.row_writer import row_writer
from appliance.ingot.annotated_pictures import Plot
from appliance.ingot.frame_rows import COLUMNS, frame_row, ingot_row
from appliance.ingot.reader_setup import decision_rule, load_view, make_reader
from appliance.ingot.settings import IngotSettings
from vision.ingot.sequential_decision import IngotFollower


def orient_recording(
    recording: Path, references: Path, output: Path, settings: IngotSettings, plot: Path | None = None
) -> None:
    """Read every picture of a recording; the output appears whole or not at all.

    Parameters
    ----------
    recording : Path
        Folder with the pictures of one camera.
    references : Path
        Folder with `top.png`, `bottom.png` and perhaps `roi.json`.
    output : Path
        File to write: CSV if its suffix is `.csv`, else JSON lines.
    settings : IngotSettings
        Classifier, limits, regions and rule of decision.
    plot : Path or None
        Folder for annotated frames and a strip of the ends.

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
    with whole_file(output) as file:
        write = row_writer(output, file, COLUMNS)
        follower = IngotFollower(decision_rule(settings.decision))
        reader = None
        for frame, picture in tqdm(frames, unit="frame", disable=None):
            reader = reader or make_reader(settings, view, picture)
            reading = reader.read(picture)
            write(frame_row(frame, reading))
            for decision in follower.add(frame, reading):
                write(ingot_row(decision))
            if pictures is not None:
                pictures.add(frame, picture, reading, follower.current)
        for decision in follower.end():
            write(ingot_row(decision))
    if pictures is not None:
        pictures.write_strip()
