"""A path-traced recording coded again as cameras send it; never tuned to."""

import json

import numpy as np
import pytest
from coded_pictures import CODINGS

from appliance.cameras.recording.pairs import Recording
from appliance.sizing.stereo.calibrate_folder import calibrate_folder
from vision.sizing.gauge import Gauge

CLEAN = ("s1_clean", "s5_clean", "s7_clean")


@pytest.fixture(scope="module")
def line_a(recordings, tmp_path_factory):
    """Gauge of a rig that was calibrated from the recording's boards without being told their response."""
    folder = tmp_path_factory.mktemp("line_a")
    for name in ("calibration", "registration"):
        (folder / name).symlink_to(recordings / "line_a" / name)
    board = json.loads((recordings / "line_a" / "board.json").read_text())
    board.pop("response")
    (folder / "board.json").write_text(json.dumps(board))
    return Gauge(calibrate_folder(folder).rig, 0.0)


def frames(folder):
    truth = json.loads((folder / "truth.json").read_text())
    for (_, left, right), row in zip(Recording(folder), truth["frames"], strict=True):
        yield left, right, row.get("diameter_mm", truth["diameter_mm"])


@pytest.mark.parametrize("name", ["jpeg 4:2:0 q75", "h264 crf 23", "h264 crf 28"])
def test_the_recording_coded_again_keeps_its_diameters(line_a, recordings, name):
    coding, errors, expanded = CODINGS[name], [], []
    for scene in CLEAN:
        for left, right, diameter_mm in frames(recordings / "line_a" / "scenes" / scene):
            sent = [coding.sent([picture.shown] * coding.frames) for picture in (left, right)]
            reading = line_a.measure(*sent)
            errors.append(reading.diameter_mm - diameter_mm)
            expanded.append(reading.expanded_uncertainty_mm)
    assert np.sqrt(np.mean(np.square(errors))) <= (0.25 if name == "h264 crf 28" else 0.12)
    assert np.mean(np.abs(errors) <= expanded) >= 0.8  # 6 frames
