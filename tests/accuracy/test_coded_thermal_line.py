"""The path-traced thermal recording, coded again as cameras send it: values and their uncertainty; never tuned to.

Its barriers stand out of the rollers by 20 code values, fewer than H.264 keeps whole from CRF 23 on.
"""

import json

import numpy as np
import pytest
from coded_pictures import DEEPER_CODINGS, all_sent

from appliance.cameras.recording.pictures import PictureRecording
from vision.reasons import Reason
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

EXPONENT = 0.8  # of its response, as its description has it


@pytest.fixture(scope="module")
def line(recordings):
    folder = recordings / "thermal_line"
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    return truth, [picture.shown for _, picture in PictureRecording(folder / "frames")]


def measured(line, name):
    """Readings of the frames with a bar, and the truth in mm."""
    truth, pictures = line
    coding = DEEPER_CODINGS[name]
    if coding.kind == "jpeg":  # as colours, sent at half resolution
        pictures = [np.repeat(picture[:, :, None], 3, axis=2) for picture in pictures]
    sent = all_sent(pictures, coding)
    empty = sum(frame.get("empty", False) for frame in truth["frames"])
    reference = ConveyorReference(truth["barrier_mm"], truth["barrier_upper_inner_edge_mm"])
    gauge = ConveyorGauge(sent[:empty], reference, response_exponent=EXPONENT)
    return [gauge.measure(picture) for picture in sent[empty:]], truth["diameter_mm"]


@pytest.mark.parametrize("name", ["png 16 bit", "jpeg 4:2:0 q90", "jpeg 4:2:0 q75", "h264 crf 18"])
def test_the_thermal_recording_coded_again_is_measured_within_its_uncertainty(line, name):
    readings, truth_mm = measured(line, name)
    valid = [reading for reading in readings if reading.valid]
    error_mm = np.array([reading.diameter_mm - truth_mm for reading in valid])
    assert len(valid) >= 9
    assert np.all(np.abs(error_mm) <= [reading.expanded_uncertainty_mm for reading in valid])
    assert np.sqrt(np.mean(error_mm**2)) <= 0.8  # 0.64 mm without compression


@pytest.mark.parametrize("name", ["h264 crf 23", "h264 crf 28"])
def test_barriers_of_which_a_coder_keeps_too_little_give_no_value(line, name):
    readings, _ = measured(line, name)
    assert all(reading.reasons & (Reason.BARRIER_BENT | Reason.BARRIER_HIDDEN) for reading in readings)
    assert not any(reading.valid for reading in readings)
