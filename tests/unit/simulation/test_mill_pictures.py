"""Pictures of the simulated mill: bars, light, noise, and the camera's moments."""

import itertools
import math
import time

import numpy as np
import pytest

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.source import CameraError
from appliance.simulation.bars import bars
from appliance.simulation.bars.bars import Bar, bar_at, truth
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.response import encode
from appliance.simulation.sensor import LEVELS, NoiseStock, Sensor
from appliance.simulation.true_rig import default_rig, random_rig

SMALL = (200, 150)


@pytest.fixture(scope="module")
def scene():
    return Scene(default_rig(SMALL), seed=3)


def test_the_same_seed_and_frame_give_the_same_pictures_and_others_do_not(scene):
    bar = bar_at(3, 4)
    again = Scene(default_rig(SMALL), seed=3).pair(bar, 4)
    for picture, same in zip(scene.pair(bar, 4), again, strict=True):
        assert np.array_equal(picture, same)
        assert picture.shape == (150, 200, 3)
        assert picture.dtype == np.uint8
    assert not np.array_equal(scene.pair(bar, 5)[0], again[0])
    assert not np.array_equal(Scene(default_rig(SMALL), seed=4).pair(bar, 4)[0], again[0])


def test_both_cameras_have_their_own_noise(scene):
    left, right = (scene.left.light(None), scene.right.light(None))
    noise = [
        picture.astype(float)[..., 1] - 255 * encode(light[1].astype(float), "srgb")
        for picture, light in zip(scene.pair(None, 1), (left, right), strict=True)
    ]
    assert abs(np.corrcoef(noise[0].ravel(), noise[1].ravel())[0, 1]) < 0.05


def test_the_hot_bar_is_far_brighter_than_everything_that_stands_still(scene):
    bar = Bar(200.0)
    background, light = scene.left.light(None), scene.left.light(bar)
    assert light[2].max() > 8 * background[2].max()
    assert light.max() < 0.9  # red is not clipped
    assert background.min() > 0


def test_red_is_strongest_and_nothing_clips_between_the_coldest_and_the_hottest_bar():
    for temperature_c in bars.TEMPERATURE_C:
        blue, green, red = Bar(100.0, temperature_c=temperature_c).levels
        assert blue < green < red < 0.9
        assert green < 0.55 * red


def test_light_rises_with_temperature_as_planck_says():
    cold, hot = (Bar(100.0, temperature_c=t).levels for t in (1050.0, 1100.0))
    for channel, wavelength_m in enumerate((0.46e-6, 0.54e-6, 0.62e-6)):
        x = [6.62607015e-34 * 299792458 / (wavelength_m * 1.380649e-23 * (t + 273.15)) for t in (1050.0, 1100.0)]
        planck = math.expm1(x[0]) / math.expm1(x[1])
        assert hot[channel] / cold[channel] == pytest.approx(planck, rel=1e-5)


def test_bars_come_and_go_and_change_and_drift_slowly():
    line = [bar_at(1, frame) for frame in range(12 * bars.FRAMES_PER_BAR)]
    shown = [bar for bar in line if bar]
    assert len(line) - len(shown) == 11 * 0.2 * 25 + bars.FRAMES_PER_BAR  # with one pause
    assert len({bar.diameter_mm for bar in shown}) == 12
    for before, after in itertools.pairwise(line):
        if before and after:
            assert before.diameter_mm == after.diameter_mm
            assert abs(before.offset_mm - after.offset_mm) < 3
            assert abs(before.yaw_deg - after.yaw_deg) < 0.1
            assert after.head_mm - before.head_mm == after.tail_mm - before.tail_mm == bars.STEP_MM
    assert all(80 <= bar.diameter_mm <= 300 for bar in shown)


def test_a_line_starts_with_a_bar_and_each_enters_passes_and_leaves():
    rows = [truth(bar_at(4, frame)) for frame in range(200)]
    assert rows[0]["condition"] == "clean"
    stages = [condition for condition, _ in itertools.groupby(row["condition"] for row in rows)]
    assert stages[:5] == ["clean", "bar end", "no bar", "bar end", "clean"]
    for row in rows:
        in_region = row["condition"] == "clean"
        assert (row["diameter_mm"] is not None) >= in_region
        assert row["condition"] != "bar end" or -250 < row["head_y_mm"] < 250 or -250 < row["tail_y_mm"] < 250


def test_an_end_that_covers_less_than_half_of_the_region_has_no_diameter():
    assert truth(Bar(100.0, head_mm=1.0))["diameter_mm"] == 100.0
    assert truth(Bar(100.0, head_mm=-1.0))["diameter_mm"] is None
    assert truth(Bar(100.0, tail_mm=1.0))["diameter_mm"] is None
    assert truth(Bar(100.0, tail_mm=-1.0))["condition"] == "bar end"
    assert truth(Bar(100.0, tail_mm=251.0))["condition"] == "no bar"
    assert truth(Bar(100.0, head_mm=-1.0), (-250.0, 0.0))["diameter_mm"] == 100.0


def test_a_bar_lies_on_the_rollers_and_its_truth_says_where():
    bar = Bar(123.0, offset_mm=7.0, yaw_deg=-1.24)
    row = truth(bar)
    assert row["diameter_mm"] == 123.0
    assert row["axis_point_mm"] == [7.0, 0.0, 61.5]
    assert row["axis_direction"] == pytest.approx([-0.021640, 0.999766, 0.0], abs=1e-6)
    assert truth(None)["diameter_mm"] is None


def test_a_frame_in_a_gap_shows_the_empty_line(scene):
    assert np.array_equal(scene.left.light(None), scene.left.background)
    frame = bars.FRAMES_PER_BAR - bars.FIRST_FRAME - 1
    assert bar_at(3, frame) is None
    assert scene.pair(None, frame)[0].max() < 90


def test_a_bar_beside_the_picture_leaves_the_background_alone(scene):
    assert np.array_equal(scene.left.light(Bar(80.0, offset_mm=4000.0)), scene.left.background)


def test_every_bar_of_the_line_fits_into_both_pictures_of_every_rig():
    for seed in range(50):
        rig = random_rig(np.random.default_rng(seed))
        corners = np.array([(x, y, z) for x in (-210, 210) for y in (-250, 250) for z in (0, 300)], dtype=float)
        for camera in rig.cameras:
            assert camera.sees(corners, margin_px=0)
            assert camera.centre_mm[2] > 300


def test_random_rigs_differ_as_mills_do():
    rigs = [random_rig(np.random.default_rng(seed)) for seed in range(100)]
    baselines = [np.linalg.norm(rig.left.centre_mm - rig.right.centre_mm) for rig in rigs]
    distances = [np.linalg.norm(rig.left.centre_mm) for rig in rigs]
    assert min(baselines) < 700
    assert max(baselines) > 2100
    assert min(distances) < 1900
    assert max(distances) > 3700
    assert all(rig.left.centre_mm[0] < rig.right.centre_mm[0] for rig in rigs)


def test_pixels_far_outside_the_lens_model_are_a_wrong_call():
    with pytest.raises(ValueError, match="pixels"):
        default_rig().left.rays(np.array([[1e5, 1e5]]))


def test_noise_has_the_variance_of_shot_and_read_noise():
    sensor = Sensor(response="linear", full_well_electrons=8000, read_noise_electrons=16)
    light = np.array([0.0, 0.1, 0.8], np.float32)
    electrons = light * 8000.0
    assert sensor.noise(light) * 8000 == pytest.approx(np.sqrt(electrons + 16**2), rel=1e-5)


def test_noise_in_the_pictures_is_white_and_as_large_as_stated():
    sensor = Sensor(response="linear", full_well_electrons=3000, read_noise_electrons=20)
    scene = Scene(default_rig(SMALL), seed=2, sensor=sensor)
    bar = Bar(250.0)
    light = scene.left.light(bar)
    bright = light[2] > 0.4
    pictures = np.stack([scene.pair(bar, frame)[0][..., 2] for frame in range(60)]).astype(float) / 255
    residual = (pictures - light[2])[:, bright]
    expected = np.sqrt(light[2][bright] / 3000 + (20 / 3000) ** 2 + 1 / (12 * 255**2))
    assert np.sqrt((residual**2).mean()) == pytest.approx(np.sqrt((expected**2).mean()), rel=0.03)
    assert abs(residual.mean()) < 0.0005
    step = residual - residual.mean(axis=0)
    assert abs(np.corrcoef(step[:-1].ravel(), step[1:].ravel())[0, 1]) < 0.05


def test_noise_cut_at_any_place_has_the_shape_of_a_picture():
    stock = NoiseStock((3, 4, 5), seed=1)
    last = stock.cut(NoiseStock.EXTRA - 1)
    assert last.shape == (3, 4, 5)
    assert not np.array_equal(last, stock.cut(0))


def srgb_to_linear(value):
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(
    ("response", "decode"), [("srgb", srgb_to_linear), ("linear", lambda v: v), ("gamma 2.2", lambda v: v**2.2)]
)
def test_decoding_a_picture_gives_the_light_back(response, decode):
    table = Sensor(response=response).table()
    light = np.linspace(0, 1, LEVELS + 1)
    half_a_level = np.maximum(decode((table + 0.5) / 255) - decode(table / 255.0), 0) * 1.01 + 2e-4
    assert np.all(np.abs(decode(table / 255.0) - light) <= half_a_level)
    assert (table[0], table[-1]) == (0, 255)


@pytest.fixture(scope="module")
def source():
    with MillSource(seed=5, rate_hz=0) as opened:
        yield opened


def test_the_mill_as_a_camera_says_that_it_is_simulated_and_what_is_true(source):
    pair = source.next(0.0)
    assert source.simulated
    assert pair.left.shape == pair.right.shape == (600, 800, 3)
    assert pair.truth == truth(bar_at(5, pair.sequence))
    assert pair.dropped == 0


def test_the_mill_in_real_time_drops_what_nobody_took(source):
    with MillSource(seed=5, rate_hz=10) as camera:
        first = camera.next(1.0)
        time.sleep(0.55)
        second = camera.next(1.0)
    assert first.sequence == first.dropped == 0
    assert second.sequence >= 5
    assert second.dropped == second.sequence - 1
    assert second.left_us == second.sequence * 100_000
    assert second.exposed_monotonic_s - first.exposed_monotonic_s == pytest.approx(0.1 * second.sequence)


def test_the_mill_delivers_no_pair_before_its_moment(source):
    with MillSource(seed=5, rate_hz=5) as camera:
        for _ in range(4):
            pair = camera.next(1.0)
            assert time.monotonic() >= pair.exposed_monotonic_s


def test_without_a_rate_every_frame_comes_in_order(source):
    first = source.next(5.0).sequence
    assert [source.next(5.0).sequence for _ in range(20)] == list(range(first + 1, first + 21))


def test_a_prepared_loop_keeps_any_rate_and_goes_on_counting(source):
    with MillSource(seed=5, rate_hz=0, prepared_frames=3) as camera:
        pairs = [camera.next(1.0) for _ in range(7)]
    assert [pair.sequence for pair in pairs] == list(range(7))
    assert np.array_equal(pairs[1].left, pairs[4].left)
    assert not np.array_equal(pairs[1].left, pairs[2].left)
    assert pairs[5].truth == truth(bar_at(5, 2))
    with MillSource(seed=5, rate_hz=50, prepared_frames=3) as camera:
        started = time.monotonic()
        last = [camera.next(1.0) for _ in range(25)][-1]
        assert last.sequence == pytest.approx(50 * (time.monotonic() - started), abs=3)


def take_all(camera):
    for _ in range(50):
        camera.next(5.0)


def test_a_drawing_process_that_ends_is_a_camera_error():
    with MillSource(seed=5, rate_hz=0) as camera:
        camera._renderer._process.kill()
        with pytest.raises(CameraError, match="started again"):
            take_all(camera)


def test_the_mill_observes_the_same_boards_every_time(source):
    first, again = source.observe_boards(), MillSource(seed=5, rate_hz=0).observe_boards()
    assert np.array_equal(first.low[0], again.low[0])
    assert len(first.calibration) == 15


def test_the_next_exposure_is_never_further_away_than_one_period():
    camera = MillSource(seed=5, rate_hz=10)
    camera._start_s = time.monotonic() - 123.456
    assert 0 < camera._until_due_s() <= 0.1
