"""The exposure guard against a bar whose light follows the exposure, as a linear sensor's does."""

import itertools
import math

import pytest

from appliance.cameras.exposure_control import ExposureGuard
from appliance.cameras.settings import ExposureSettings

SETTINGS = ExposureSettings(after_s=10, shortest_us=50, longest_us=2000)
CONTROLLED = SETTINGS.model_copy(update={"control": True})


def test_good_edges_and_frames_without_a_bar_change_nothing():
    guard = ExposureGuard(CONTROLLED, adjustable=True)
    for now in range(100):
        for share, light in ((0.01, 0.4), (math.nan, math.nan)):
            advice = guard.advise(share, light, 500, now)
            assert math.isnan(advice.exposure_us)
            assert not advice.faults


@pytest.mark.parametrize(
    ("share", "light", "fault", "advised"), [(0.2, 0.8, "exposure_high", 400), (0.0, 0.02, "exposure_low", 625)]
)
def test_what_lasts_is_a_fault_that_says_which_exposure_to_try(share, light, fault, advised):
    guard = ExposureGuard(SETTINGS, adjustable=True)
    for tick in range(100):
        assert not guard.advise(share, light, 500, tick / 10).faults
    advice = guard.advise(share, light, 500, 10.05)
    assert f"about {advised} µs instead of 500" in advice.faults[fault]
    assert math.isnan(advice.exposure_us)
    assert not guard.advise(0.0, 0.4, 500, 11.0).faults


def test_two_bright_readings_a_minute_apart_change_no_exposure():
    guard = ExposureGuard(CONTROLLED, adjustable=True)
    assert math.isnan(guard.advise(0.2, 0.8, 500, 0.0).exposure_us)
    advice = guard.advise(0.2, 0.8, 500, 60.0)
    assert math.isnan(advice.exposure_us)
    assert not advice.faults


@pytest.mark.parametrize(("bright_of_five", "is_fault"), [(2, False), (4, True)])
def test_glare_in_most_readings_is_a_fault_and_in_few_it_is_none(bright_of_five, is_fault):
    guard = ExposureGuard(SETTINGS, adjustable=True)
    advices = [guard.advise(0.2 if now % 5 < bright_of_five else 0.0, 0.4, 500, now) for now in range(100)]
    assert any(advice.faults for advice in advices) is is_fault


def test_a_camera_without_a_known_exposure_gets_advice_as_a_factor():
    guard = ExposureGuard(CONTROLLED, adjustable=False)
    advices = [guard.advise(0.2, 0.8, math.nan, now) for now in range(12)]
    assert "0.8 times" in advices[-1].faults["exposure_high"]


@pytest.mark.parametrize(("exposure_us", "share", "light"), [(5000.0, 0.0, 0.01), (20.0, 0.5, 1.0)])
def test_an_exposure_outside_its_bounds_is_never_stepped_the_wrong_way(exposure_us, share, light):
    guard = ExposureGuard(CONTROLLED, adjustable=True)
    advices = [guard.advise(share, light, exposure_us, now) for now in range(30)]
    assert all(math.isnan(advice.exposure_us) for advice in advices)
    assert advices[-1].faults  # too dark although it exposes longer than it may, or too bright although shorter


def test_bounds_that_contradict_each_other_are_refused():
    with pytest.raises(ValueError, match="below shortest_us = 500"):
        ExposureSettings(shortest_us=500, longest_us=100)


@pytest.mark.parametrize("start_us", [60.0, 1900.0])
def test_control_brings_the_edges_back_into_range_slowly_and_stays(start_us):
    exposure_us, changes = start_us, []
    guard = ExposureGuard(CONTROLLED, adjustable=True)
    for now in range(2000):
        light = exposure_us / 1000
        advice = guard.advise(0.3 if light > 0.9 else 0.0, min(light, 1.0), exposure_us, now)
        assert not advice.faults
        if math.isfinite(advice.exposure_us):
            exposure_us = advice.exposure_us
            changes.append(now)
    assert 100 <= exposure_us <= 900
    assert all(later - earlier >= SETTINGS.after_s for earlier, later in itertools.pairwise(changes))
    assert changes[-1] < 500


@pytest.mark.parametrize(("share", "light", "limit"), [(0.5, 1.0, 50.0), (0.0, 0.01, 2000.0)])
def test_control_stops_at_its_limits_and_then_says_so(share, light, limit):
    exposure_us, faults = 500.0, {}
    guard = ExposureGuard(CONTROLLED, adjustable=True)
    for now in range(1000):
        advice = guard.advise(share, light, exposure_us, now)
        exposure_us = advice.exposure_us if math.isfinite(advice.exposure_us) else exposure_us
        faults = advice.faults
    assert exposure_us == limit
    assert faults
