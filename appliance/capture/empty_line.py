"""`hotgauge capture background`: the line without a bar, by the camera between barriers."""

import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from appliance.cameras.source import Frame
from appliance.capture.believed_pairs import believed
from appliance.capture.console import Console
from appliance.capture.error import CaptureError
from appliance.capture.picture_writer import write_picture
from appliance.sizing.conveyor.settings import ConveyorSettings
from vision.sent_picture import SentPicture

PICTURES = 20  # of which the median is kept: it forgets noise, and what passes
WITHIN_S = 30.0
CHANGED_LEVELS, CHANGED_MOST_SHARE = 12, 0.01  # chosen: of pixels that differ between the first and the last picture


def capture_empty_line(settings: ConveyorSettings, output: Path, console: Console) -> None:
    """Write the median of PICTURES pictures, and say what the gauge makes of them.

    Parameters
    ----------
    settings : ConveyorSettings
    output : Path
        PNG file.
    console : Console

    Raises
    ------
    CaptureError
        Too few pictures, something moves in them, or the gauge cannot use what was taken.
    CameraError
        The camera gives no pictures.
    """
    pictures: list[NDArray[np.uint8]] = []
    with settings.make_source() as source:
        started_s = time.monotonic()
        for frame in believed(source, settings.liveness, WITHIN_S):
            if not isinstance(frame, Frame):
                raise TypeError("a source of single pictures is needed")
            pictures.append(frame.picture)
            console.live(f"{len(pictures)} of {PICTURES} pictures")
            if len(pictures) == PICTURES:
                break
    if len(pictures) < PICTURES:
        raise CaptureError(f"{len(pictures)} of {PICTURES} pictures within {WITHIN_S:g} s; check the camera's rate")
    changed = np.abs(pictures[0].astype(np.int16) - pictures[-1]) > CHANGED_LEVELS
    if changed.mean() > CHANGED_MOST_SHARE:
        raise CaptureError(
            f"{100 * changed.mean():.0f} % of the picture changes within {time.monotonic() - started_s:.0f} s; "
            "take it while the line is empty and nothing moves"
        )
    write_picture(output, SentPicture.of(np.median(pictures, axis=0).astype(np.uint8)))
    line = settings.conveyor.model_copy(update={"background": output})
    check = settings.model_copy(update={"conveyor": line}).check_scale()
    if check.verdict == "BAD":
        raise CaptureError(f"{check.text}; the picture was kept, to be looked at")
    console.say(f"{output}: the line without a bar; {check.name}: {check.text}")
