"""Readings of a recording of the master."""

import contextlib
import statistics
from collections.abc import Callable
from pathlib import Path

from appliance.cameras.recording.pairs import Recording
from appliance.sizing.stereo.gauge import rig_file_gauge


def read_master(recording: Path, rig: Path, show: Callable[[int, int], None]) -> tuple[list[float], int, float]:
    """Valid diameters, number of readings without a value, and mean U of the valid ones, mm (NaN without any).

    Parameters
    ----------
    recording : Path
        Folder of a recording of the master.
    rig : Path
        Calibration of the two cameras.
    show : callable
        Gets how many frames are done, of how many.

    Raises
    ------
    CameraError
        The recording is missing or a picture cannot be read.
    RigError
        The rig is missing, malformed, or for pictures of another size.
    """
    gauge = rig_file_gauge(rig, 0.0)
    diameters: list[float] = []
    expanded: list[float] = []
    missing = 0
    with contextlib.closing(Recording(recording)) as frames:
        for done, (_, left, right) in enumerate(frames, start=1):
            reading, _ = gauge.measure(left, right)
            if reading.valid:
                diameters.append(reading.diameter_mm)
                expanded.append(reading.expanded_uncertainty_mm)
            else:
                missing += 1
            show(done, done)
    return diameters, missing, statistics.fmean(expanded) if expanded else float("nan")
