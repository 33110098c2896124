"""Measures a recording of one uncalibrated camera over a conveyor between barriers, frame by frame."""

import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from appliance.cameras.picture_recording import PictureRecording
from appliance.cameras.recording import read_picture
from appliance.cameras.source import CameraError
from appliance.measure import row, row_writer, whole_file
from vision.calibration.conveyor_view import ConveyorReference
from vision.sizing.conveyor import ConveyorGauge

Picture = NDArray[np.uint8]

EMPTY_MOST = 20  # pictures of the empty line that are averaged
SAME_LIGHT = 0.005  # of full scale: how far mean light of empty pictures differs; a bar adds more


def measure_conveyor(
    recording: Path,
    output: Path,
    reference: ConveyorReference,
    *,
    background: Path | None = None,
    compensation_mm: float = 0.0,
) -> None:
    """Measure every frame; the output appears whole or not at all.

    Parameters
    ----------
    recording : Path
        Folder with the pictures of one camera.
    output : Path
        File to write: CSV if its suffix is `.csv`, else JSON lines.
    reference : ConveyorReference
    background : Path, optional
        Picture of the empty line; without it the recording's darkest frames are taken for empty.
    compensation_mm : float
        Added to every diameter.

    Raises
    ------
    CameraError
        The recording or the background is missing or cannot be read, or they differ in size.
    ValueError
        The compensation is not finite.
    OSError
        `output` cannot be written.
    """
    frames = PictureRecording(recording)
    empty = darkest(frames) if background is None else [_background(background, frames)]
    gauge = ConveyorGauge(empty, reference, compensation_mm)
    with whole_file(output) as file:
        write = row_writer(output, file)
        for frame, picture in tqdm(frames, unit="frame", total=len(frames), disable=None):
            started_s = time.perf_counter()
            reading = gauge.measure(picture)
            write(row(frame, reading, 1000 * (time.perf_counter() - started_s)))


def darkest(frames: PictureRecording) -> list[Picture]:
    """Pictures of the empty line among those of a recording: a hot bar makes all others brighter."""
    light = np.array([float(picture.mean()) / 255 for _, picture in frames])
    chosen = np.flatnonzero(light <= light.min() + SAME_LIGHT)[:EMPTY_MOST]
    pictures = [frames.read(int(position)) for position in chosen]
    return [found[1] for found in pictures if found is not None]


def _background(path: Path, frames: PictureRecording) -> Picture:
    if not path.is_file():
        raise CameraError(f"{path}: no such picture; give a picture of the empty line")
    picture, first = read_picture(path), frames.read(0)
    if first is not None and picture.shape[:2] != first[1].shape[:2]:
        raise CameraError(f"{path}: another size than the recording's pictures; give a picture of this camera")
    return picture
