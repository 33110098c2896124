"""Every reason for no value, provoked; and that nothing wrong is served."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from mill_scenes import perfect_rig, random_bar

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig, random_rig
from vision.reasons import REASONS, Reason
from vision.sizing.tangent.gauge import TangentGauge

BAR = Bar(diameter_mm=150.0, offset_mm=12.0, yaw_deg=0.7)


@pytest.fixture(scope="module")
def scene():
    return Scene(default_rig(), seed=4)


@pytest.fixture(scope="module")
def gauge():
    return TangentGauge(perfect_rig(default_rig()))


@pytest.fixture(scope="module")
def pair(scene):
    return scene.pair(BAR, 0)


@pytest.fixture(scope="module")
def empty(scene):
    return scene.pair(None, 1)


def brighter(picture, factor):
    return np.clip(picture * float(factor), 0, 255).astype(np.uint8)


def test_a_bar_is_measured_and_its_place_told(gauge, pair):
    reading = gauge.measure(*pair)
    assert reading.valid
    assert reading.reasons == Reason.NONE
    assert reading.diameter_mm == pytest.approx(150.0, abs=0.15)
    assert reading.axis_height_mm == pytest.approx(75.0, abs=0.5)
    assert reading.offset_mm == pytest.approx(12.0, abs=0.5)
    assert reading.windows_kept == reading.windows_total == 25
    assert reading.trust_limit == pytest.approx(100.0)


def test_edges_in_one_window_alone_give_no_value_since_they_show_no_scatter(gauge, pair, monkeypatch):
    monkeypatch.setattr("vision.sizing.tangent.gauge.WINDOW_MM", 600.0)
    reading = gauge.measure(*pair)
    assert Reason.NO_WINDOWS in reading.reasons
    assert not reading.valid
    assert np.isnan(reading.diameter_mm)


@pytest.mark.parametrize("length_mm", [4.0, 12.0, 60.0])
def test_a_region_of_few_millimetres_gives_no_value_and_raises_nothing(pair, length_mm):
    short = replace(perfect_rig(default_rig()), region_y_mm=(-length_mm / 2, length_mm / 2))
    reading = TangentGauge(short).measure(*pair)
    assert not reading.valid
    assert reading.reasons.forbids_value


def test_grey_pictures_are_measured_as_well(gauge, pair):
    reading = gauge.measure(*(np.ascontiguousarray(picture[:, :, 2]) for picture in pair))
    assert reading.diameter_mm == pytest.approx(150.0, abs=0.15)


def test_the_same_pair_gives_the_same_reading(gauge, pair):
    assert gauge.measure(*pair) == gauge.measure(*pair)


def test_u_is_twice_the_root_sum_of_squares_of_its_parts(gauge, pair):
    reading = gauge.measure(*pair)
    parts = [
        reading.u_edge_mm,
        reading.u_calibration_mm,
        reading.u_board_mm,
        reading.u_light_mm,
        reading.u_shape_mm,
        reading.u_model_mm,
    ]
    assert reading.expanded_uncertainty_mm == pytest.approx(2 * np.sqrt(np.sum(np.square(parts))))


def test_an_empty_line_is_no_bar(gauge, empty):
    assert gauge.measure(*empty).reasons == Reason.NO_BAR


def test_darkness_and_noise_are_no_bar(gauge):
    black = np.zeros((600, 800, 3), np.uint8)
    assert gauge.measure(black, black).reasons == Reason.NO_BAR
    noise = np.random.default_rng(0).integers(0, 256, black.shape, dtype=np.uint8)
    assert not gauge.measure(noise, noise).valid


@pytest.mark.parametrize("blind", [0, 1])
def test_a_bar_in_one_view_only_is_said_so(gauge, pair, empty, blind):
    views = [empty[index] if index == blind else pair[index] for index in range(2)]
    assert gauge.measure(*views).reasons == Reason.ONE_CAMERA


def test_two_bars_are_said_so(gauge, scene):
    one, other = (scene.pair(Bar(80.0, offset_mm=x), 0) for x in (-90.0, 90.0))
    both = [np.maximum(a, b) for a, b in zip(one, other, strict=True)]
    assert gauge.measure(*both).reasons == Reason.SEVERAL_BARS


def test_a_white_picture_is_no_bar(gauge):
    white = np.full((600, 800, 3), 255, np.uint8)
    assert gauge.measure(white, white).reasons == Reason.NO_BAR


def test_edges_that_every_channel_lost_are_no_value(gauge, pair):
    clipped = [np.where(picture.max(axis=2, keepdims=True) > 110, 255, picture).astype(np.uint8) for picture in pair]
    reading = gauge.measure(*clipped)
    assert Reason.EDGES_CLIPPED in reading.reasons
    assert not reading.valid


def test_a_clipped_channel_is_left_for_the_next_one(gauge, pair):
    reading = gauge.measure(*(brighter(picture, 1.5) for picture in pair))
    assert reading.valid
    # a gain on code values is not a gain on light, which the response alone explains to 0.3 mm
    assert reading.diameter_mm == pytest.approx(150.0, abs=0.3)


def test_a_blurred_limb_of_low_contrast_is_flagged(gauge, scene, pair, empty):
    haze = [cv2.addWeighted(a, 0.25, np.full_like(a, 150), 0.75, 0) for a in pair]
    reading = gauge.measure(*haze)
    assert not reading.valid or Reason.LOW_CONTRAST in reading.reasons


def test_a_view_that_moved_sideways_is_not_believed(gauge, pair):
    reading = gauge.measure(pair[0], np.roll(pair[1], 25, axis=1))
    assert not reading.valid
    assert reading.reasons & (Reason.IMPLAUSIBLE | Reason.VIEWS_DISAGREE)


def test_a_view_that_turned_is_not_believed(gauge, pair):
    turn = cv2.getRotationMatrix2D((400, 300), 3.0, 1.0)
    reading = gauge.measure(pair[0], cv2.warpAffine(pair[1], turn, (800, 600)))
    assert not reading.valid


@pytest.mark.parametrize("seed", range(4))
def test_swapped_cameras_and_foreign_rigs_serve_nothing_wrong(seed):
    rng = np.random.default_rng(seed)
    true_rig, bar = random_rig(rng), random_bar(rng)
    left, right = Scene(true_rig, seed).pair(bar, 0)
    for measured in (
        TangentGauge(perfect_rig(true_rig)).measure(right, left),
        TangentGauge(perfect_rig(random_rig(rng))).measure(left, right),
    ):
        wrong_mm = max(2 * measured.expanded_uncertainty_mm, 1.0)
        assert not measured.valid or abs(measured.diameter_mm - bar.diameter_mm) <= wrong_mm


def test_without_a_value_every_number_is_nan_and_a_reason_forbids_it(gauge, empty):
    reading = gauge.measure(*empty)
    assert reading.reasons.forbids_value
    assert np.isnan([reading.diameter_mm, reading.expanded_uncertainty_mm, reading.axis_height_mm]).all()


def test_pictures_of_another_size_are_refused_with_both_sizes(gauge):
    wrong = np.zeros((480, 640, 3), np.uint8)
    with pytest.raises(ValueError, match=r"left.*640 x 480.*800 x 600"):
        gauge.measure(wrong, wrong)


@pytest.mark.parametrize("picture", [np.zeros((600, 800), np.float32), np.zeros((600, 800, 4), np.uint8)])
def test_pictures_of_another_type_are_refused(gauge, picture):
    with pytest.raises(ValueError, match=r"^left: .*(uint8|shape)"):
        gauge.measure(picture, picture)


def test_a_rig_without_world_frame_is_refused():
    with pytest.raises(ValueError, match="registration"):
        TangentGauge(replace(perfect_rig(default_rig()), has_world=False))


def test_a_camera_that_looks_away_is_refused():
    rig = perfect_rig(default_rig())
    turn = np.diag([1.0, -1.0, -1.0])
    away = replace(rig.left, R=turn @ rig.left.R, t=turn @ rig.left.t)
    with pytest.raises(ValueError, match="measuring region"):
        TangentGauge(replace(rig, left=away))


def test_the_table_of_reasons_has_one_row_per_flag():
    assert [row.flag for row in REASONS] == sorted(flag for flag in Reason if flag)
    assert all(row.text for row in REASONS)


def test_flags_that_forbid_a_value_stand_in_the_low_half_of_the_word():
    assert all((row.flag < 1 << 16) == row.forbids_value for row in REASONS)
