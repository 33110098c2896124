"""The path-traced thermal recording, coded again as cameras send it: values and their uncertainty; never tuned to."""

import json

import numpy as np
import pytest
from coded_pictures import DEEPER_CODINGS, all_sent

from appliance.cameras.recording.pictures import PictureRecording
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

EXPONENT = 0.8  # of its response, as its description has it
MOST_RMSE_MM = {"png 16 bit": 1.0, "jpeg 4:2:0 q75": 1.0, "h264 crf 23": 1.5, "h264 crf 28": 2.5}


@pytest.fixture(scope="module")
def line(recordings):
    folder = recordings / "thermal_line"
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    return truth, [picture.shown for _, picture in PictureRecording(folder / "frames")]


@pytest.mark.parametrize("name", MOST_RMSE_MM)
def test_the_thermal_recording_coded_again_is_measured_within_its_uncertainty(line, name):
    truth, pictures = line
    coding = DEEPER_CODINGS[name]
    if coding.kind == "jpeg":
        pictures = [
            np.repeat(picture[:, :, None], 3, axis=2) for picture in pictures
        ]  # colours, sent at half resolution
    sent = all_sent(pictures, coding)
    empty = sum(frame.get("empty", False) for frame in truth["frames"])
    reference = ConveyorReference(truth["barrier_mm"], truth["barrier_upper_inner_edge_mm"])
    gauge = ConveyorGauge(sent[:empty], reference, response_exponent=EXPONENT)
    readings = [gauge.measure(picture) for picture in sent[empty:]]
    error_mm = np.array([reading.diameter_mm for reading in readings]) - truth["diameter_mm"]
    expanded_mm = np.array([reading.expanded_uncertainty_mm for reading in readings])
    assert all(reading.valid for reading in readings)
    assert np.all(np.abs(error_mm) <= expanded_mm)
    assert np.sqrt(np.mean(error_mm**2)) <= MOST_RMSE_MM[name]
