"""Fits how much the line rises against the registration boards, from the bars of a recording."""

import contextlib
import math
import statistics
from pathlib import Path

from appliance.cameras.recording.pairs import Recording
from appliance.sizing.stereo.rig_file import RigError
from vision.calibration.rig import Rig
from vision.sizing.virtual_board.bar_tilt import bar_tilt_deg
from vision.sizing.virtual_board.gauge import VirtualBoardGauge

FRAMES_FITTED = 9  # chosen: spread over the recording; their median is the tilt
ROUNDS = 2  # the second one measures on boards that are turned already, and adds what is left


def fitted_along_line(rig: Rig, recording: Path) -> Rig:
    """The rig in the frame of the line on which the recording's bars lie.

    Parameters
    ----------
    rig : Rig
        In the boards' frame.
    recording : Path
        Folder of a recording.

    Raises
    ------
    CameraError
        The recording is missing or a picture cannot be read.
    RigError
        No frame shows a bar whose tilt can be told.
    """
    with contextlib.closing(Recording(recording)) as frames:
        places = dict.fromkeys(len(frames) * part // FRAMES_FITTED for part in range(FRAMES_FITTED))
        pairs = [frame[1:] for place in places if (frame := frames.read(place)) is not None]
    for _ in range(ROUNDS):
        gauge = VirtualBoardGauge(rig, edges="sobel")  # each point moves to half level: the detector matters little
        tilts: list[float] = []
        for pair in pairs:
            gauge.measure(*pair)
            if gauge.last_pair is not None and math.isfinite(tilt_deg := bar_tilt_deg(gauge.last_pair)):
                tilts.append(tilt_deg)
        if not tilts:
            raise RigError(f"{recording}: no frame shows how the bar lies on the line; give --board-tilt in degrees")
        rig = rig.along_line(rig.tilt_deg + statistics.median(tilts))
    return rig
