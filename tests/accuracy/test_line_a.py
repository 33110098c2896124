"""The product's own way on a path-traced recording: calibrate the folder, measure its scenes, compare with truth.

Bounds of errors are 1.3 times what the README claims. Nothing of the gauge was set by looking at these pictures' truth.
"""

import json
from functools import partial

import numpy as np
import pytest

from appliance.sizing.stereo.calibrate_folder import calibrate_folder
from appliance.sizing.stereo.measure_recording import measure_recording
from appliance.sizing.stereo.rig_file import save_rig
from vision.sizing.gauge import Gauge

SCENES = {
    "clean": ("s1_clean", "s3_clean", "s5_clean", "s7_clean"),
    "scale": ("s2_scale", "s4_scale", "s6_scale", "s8_scale"),
}


@pytest.fixture(scope="module")
def rig(recordings, tmp_path_factory):
    path = tmp_path_factory.mktemp("line_a") / "rig.json"
    save_rig(calibrate_folder(recordings / "line_a").rig, path)
    return path


@pytest.fixture(scope="module")
def measured(recordings, rig):
    """Per condition: error and expanded uncertainty of every frame, mm, and the parts of its uncertainty."""
    return {
        condition: [row for name in names for row in rows(recordings / "line_a" / "scenes" / name, rig)]
        for condition, names in SCENES.items()
    }


def rows(scene, rig):
    output = rig.with_name(f"{scene.name}.jsonl")
    measure_recording(scene, rig, output, partial(Gauge, ovality_mm=0.0))  # the recording's bars are round
    diameter_mm = json.loads((scene / "truth.json").read_text())["diameter_mm"]
    readings = [json.loads(line) for line in output.read_text().splitlines()]
    assert [reading["frame"] for reading in readings] == [0, 1]
    return [reading | {"truth_mm": diameter_mm} for reading in readings]


def errors_mm(readings):
    return np.array([reading["diameter_mm"] - reading["truth_mm"] for reading in readings])


@pytest.mark.parametrize("condition", SCENES)
def test_every_frame_gets_a_value(measured, condition):
    assert all(reading["valid"] for reading in measured[condition])


@pytest.mark.parametrize(("condition", "rmse_mm", "worst_mm"), [("clean", 0.032, 0.050), ("scale", 0.084, 0.17)])
def test_errors_are_as_small_as_claimed(measured, condition, rmse_mm, worst_mm):
    error = errors_mm(measured[condition])
    assert np.sqrt(np.mean(error**2)) <= 1.3 * rmse_mm
    assert np.abs(error).max() <= 1.3 * worst_mm


@pytest.mark.parametrize("condition", SCENES)
def test_the_stated_uncertainty_covers_the_error(measured, condition):
    expanded = np.array([reading["expanded_uncertainty_mm"] for reading in measured[condition]])
    assert np.all(np.abs(errors_mm(measured[condition])) <= expanded)


def test_a_clean_bar_s_uncertainty_is_useful(measured):
    assert np.median([reading["expanded_uncertainty_mm"] for reading in measured["clean"]]) <= 0.25


def test_the_axis_lies_half_a_diameter_above_the_rollers(measured):
    for reading in measured["clean"]:
        assert reading["axis_height_mm"] == pytest.approx(reading["truth_mm"] / 2, abs=1.0)
