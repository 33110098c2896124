"""Route V on simulated scenes and on the path-traced recording; the rig is the true one, or the recording's own."""

import json
from dataclasses import replace

import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.cameras.recording.pairs import Recording
from appliance.simulation.bars.study_scenes import draw
from appliance.sizing.stereo.calibrate_folder import calibrate_folder
from vision.reasons import Reason
from vision.sizing.virtual_board.gauge import VirtualBoardGauge
from vision.sizing.virtual_board.reading import AS_PRINTED, Corrections

SEEDS = range(300, 304)


def gauge_of(scene, **options):
    rig = replace(perfect_rig(scene.rig, scene.response), region_y_mm=tuple(scene.rig.region_y_mm))
    return VirtualBoardGauge(rig, **options)


@pytest.mark.parametrize("condition", ["clean", "scale", "haze"])
def test_bars_are_measured_within_the_promise(condition):
    for seed in SEEDS:
        scene = draw(condition, seed)
        reading = gauge_of(scene).measure(scene.left, scene.right)
        assert reading.valid
        assert abs(reading.diameter_mm - scene.truth["diameter_mm"]) < (0.3 if condition != "scale" else 1.5)


def test_as_printed_is_far_off_and_says_no_uncertainty():
    scene = draw("clean", 300)
    reading = gauge_of(scene, corrections=AS_PRINTED, edges="sobel").measure(scene.left, scene.right)
    assert abs(reading.diameter_mm - scene.truth["diameter_mm"]) > 2
    assert np.isnan(reading.expanded_uncertainty_mm)


def test_the_same_frame_gives_the_same_bits_twice_and_after_another_bar():
    scene, other = draw("clean", 301), draw("scale", 301)
    gauge = gauge_of(scene)
    first = gauge.measure(scene.left, scene.right)
    gauge.measure(other.left, other.right)
    again = gauge.measure(scene.left, scene.right)
    assert first.diameter_mm == gauge_of(scene).measure(scene.left, scene.right).diameter_mm
    assert again.diameter_mm == pytest.approx(first.diameter_mm, abs=0.01)
    assert np.array_equal(again.window_diameters_mm, first.window_diameters_mm) or again.plane_height_mm != (
        first.plane_height_mm
    )


@pytest.mark.parametrize(
    ("condition", "reason"),
    [("no-bar", Reason.NO_BAR), ("two-bars", Reason.SEVERAL_BARS), ("one-blind", Reason.ONE_CAMERA)],
)
def test_without_a_measurable_bar_there_is_no_value_and_the_board_is_held(condition, reason):
    scene, bar = draw(condition, 302), draw("clean", 302)
    gauge = gauge_of(bar)
    assert gauge.measure(scene.left, scene.right).reasons == reason
    gauge.measure(bar.left, bar.right)
    height_mm = gauge._loop.height_mm
    held = gauge.measure(scene.left, scene.right)
    assert held.reasons == reason | Reason.BOARD_HELD
    assert not held.valid
    assert gauge._loop.height_mm == height_mm


@pytest.mark.parametrize("options", [{"edges": "sobl"}, {"fusion": "fft9"}])
def test_an_unknown_option_is_named(options):
    scene = draw("clean", 300)
    with pytest.raises(ValueError, match=next(iter(options))):
        gauge_of(scene, **options)


def test_corrections_that_need_each_other_are_refused_apart():
    with pytest.raises(ValueError, match="robust_lines"):
        Corrections(turned_rows=False)
    with pytest.raises(ValueError, match="half_level"):
        Corrections(robust_lines=False)


def test_the_recording_is_measured_within_the_promise(recordings):
    gauge = VirtualBoardGauge(calibrate_folder(recordings / "line_a").rig)
    errors = []
    for scene in sorted((recordings / "line_a" / "scenes").iterdir()):
        truth_mm = json.loads((scene / "truth.json").read_text())["diameter_mm"]
        for _, left, right in Recording(scene):
            reading = gauge.measure(left, right)
            assert reading.valid, (scene.name, reading.reasons.names)
            errors.append(reading.diameter_mm - truth_mm)
    assert np.sqrt(np.mean(np.square(errors))) <= 0.4
    assert np.abs(errors).max() <= 1.5
    assert len(errors) == 16
