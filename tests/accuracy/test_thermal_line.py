"""The thermal recording of another maker's line: judged here, and never tuned to."""

import json

import numpy as np
import pytest

from appliance.cameras.recording.pictures import PictureRecording
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

EXPONENT = 0.8  # of its response, as its description has it
MOST_RMSE_MM = 1.5


@pytest.fixture(scope="module")
def line(recordings):
    folder = recordings / "thermal_line"
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    pictures = [picture for _, picture in PictureRecording(folder / "frames")]
    empty = [frame.get("empty", False) for frame in truth["frames"]]
    return truth, [[one for one, none in zip(pictures, empty, strict=True) if none is kind] for kind in (True, False)]


@pytest.mark.parametrize("barriers_height", [True, False])
@pytest.mark.parametrize("empty_frames", [True, False])
def test_nine_of_ten_frames_have_values_inside_their_uncertainty(line, empty_frames, barriers_height):
    truth, (empty, shown) = line
    reference = ConveyorReference(
        truth["barrier_mm"], truth["barrier_upper_inner_edge_mm"] if barriers_height else None
    )
    gauge = ConveyorGauge(empty if empty_frames else shown, reference, response_exponent=EXPONENT)
    valid = [reading for picture in shown if (reading := gauge.measure(picture)).valid]
    error_mm = np.array([reading.diameter_mm - truth["diameter_mm"] for reading in valid])
    assert len(valid) >= 9
    assert np.all(np.abs(error_mm) <= [reading.expanded_uncertainty_mm for reading in valid])
    if barriers_height:
        assert np.sqrt(np.mean(error_mm**2)) <= MOST_RMSE_MM
