"""The passing bar's value: what frames share stays, the rest averages out, a step in diameter is not smoothed away."""

import math
from dataclasses import replace

import numpy as np
import pytest

from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.passing_bar import PassingBar

SHARED = {"u_calibration_mm": 0.02, "u_board_mm": 0.02, "u_light_mm": 0.02, "u_model_mm": 0.02, "u_shape_mm": 0.0}
PERIOD_S = 0.04


def reading(diameter_mm, own_mm=0.1, **more):
    parts = {**SHARED, "u_edge_mm": own_mm, "u_motion_mm": 0.0}
    parts |= {name: more.pop(name) for name in list(more) if name in parts}
    expanded_mm = 2 * math.hypot(*parts.values())
    return replace(SizeReading(diameter_mm=diameter_mm, expanded_uncertainty_mm=expanded_mm, **parts), **more)


def passed(diameters_mm, own_mm=0.1):
    bar = PassingBar()
    return [bar.add(reading(one, own_mm), PERIOD_S * frame) for frame, one in enumerate(diameters_mm)]


def test_the_value_of_the_first_frame_is_that_of_the_frame():
    first = passed([120.0])[0]
    assert (first.bar_frames, first.bar_diameter_mm) == (1, 120.0)
    assert first.bar_expanded_uncertainty_mm == pytest.approx(first.expanded_uncertainty_mm, rel=0.01)


def test_what_frames_share_does_not_average_out():
    last = passed([120.0 + 0.1 * (-1) ** frame for frame in range(50)])[-1]
    assert last.bar_diameter_mm == pytest.approx(120.0, abs=0.01)
    assert 2 * 0.04 < last.bar_expanded_uncertainty_mm < 2 * 0.05  # four shared parts of 0.02 mm


@pytest.mark.parametrize("correlation", [0.0, 0.7])
def test_the_interval_of_the_bar_holds_with_and_without_correlation(correlation):
    rng = np.random.default_rng(1)
    inside, inside_half = 0, 0
    for _ in range(400):
        noise = [rng.normal(0, 0.1)]
        for _ in range(24):
            noise.append(correlation * noise[-1] + rng.normal(0, 0.1 * math.sqrt(1 - correlation**2)))
        shared = rng.normal(0, 0.04)
        last = passed(120.0 + shared + np.array(noise))[-1]
        inside += abs(last.bar_diameter_mm - 120.0) <= last.bar_expanded_uncertainty_mm
        inside_half += abs(last.bar_diameter_mm - 120.0) <= last.bar_expanded_uncertainty_mm / 2
    assert 0.92 <= inside / 400 <= 0.985
    assert inside_half / 400 < 0.85


@pytest.mark.parametrize("step_mm", [0.8, -0.8, 20.0])
def test_a_step_in_diameter_is_served_whole_in_the_second_frame_after_it(step_mm):
    readings = passed([120.0] * 30 + [120.0 + step_mm] * 3, own_mm=0.03)
    assert readings[29].bar_diameter_mm == pytest.approx(120.0)
    assert readings[31].bar_diameter_mm == pytest.approx(120.0 + step_mm)
    assert readings[31].bar_frames == 2


def test_one_frame_apart_moves_nothing():
    readings = passed([120.0] * 10 + [121.0] + [120.0] * 10, own_mm=0.03)
    assert {round(one.bar_diameter_mm, 6) for one in readings} == {120.0}
    assert readings[-1].bar_frames == 20


def test_a_missed_frame_keeps_the_bar_and_a_gap_begins_another():
    bar = PassingBar()
    bar.add(reading(120.0), 0.0)
    assert math.isnan(bar.add(SizeReading(reasons=Reason.NO_BAR), 0.04).bar_diameter_mm)
    assert bar.add(reading(120.2), 0.08).bar_frames == 2
    bar.add(SizeReading(reasons=Reason.NO_BAR), 0.4)
    assert bar.add(reading(120.2), 0.44).bar_diameter_mm == 120.2


def test_a_long_time_without_a_reading_and_time_that_runs_back_begin_anew():
    bar = PassingBar()
    bar.add(reading(120.2), 0.0)
    assert bar.add(reading(120.0), 5.0).bar_diameter_mm == 120.0
    assert bar.add(reading(120.2), 1.0).bar_diameter_mm == 120.2


def test_a_frame_without_a_value_has_no_value_of_the_bar():
    bar = PassingBar()
    bar.add(reading(120.0), 0.0)
    lost = bar.add(SizeReading(reasons=Reason.EDGE_NOT_FOUND), 0.04)
    assert math.isnan(lost.bar_diameter_mm)
    assert lost.bar_frames == 0
    assert bar.add(reading(120.0), 0.08).bar_frames == 2


def of_widths(left_mm, right_mm, noise_mm=0.02, seed=0):
    """Last reading of a bar whose widths across both views change so; mean of both is the frame's diameter."""
    rng, bar = np.random.default_rng(seed), PassingBar()
    for frame, widths_mm in enumerate(zip(left_mm, right_mm, strict=True)):
        left, right = widths_mm + rng.normal(0, noise_mm, 2)
        value = reading((left + right) / 2, noise_mm, width_left_mm=left, width_right_mm=right, u_shape_mm=0.2)
        last = bar.add(value, PERIOD_S * frame)
    return last


def turning(frames, turn_deg, ovality_mm, seed=0):
    """Widths of an ellipse across two views 40 degrees apart."""
    angle = 2 * np.deg2rad(turn_deg) * np.linspace(0, 1, frames)
    views = (120 + ovality_mm / 2 * np.cos(angle + 2 * np.deg2rad(place)) for place in (-20, 20))
    return of_widths(*views, seed=seed)


@pytest.mark.parametrize("seed", range(5))
def test_a_section_that_turns_shows_its_ovality_and_its_mean_diameter(seed):
    last = turning(40, 250.0, ovality_mm=0.8, seed=seed)
    assert abs(last.bar_ovality_mm - 0.8) <= last.bar_ovality_expanded_uncertainty_mm < 0.1
    assert abs(last.bar_diameter_mm - 120.0) <= last.bar_expanded_uncertainty_mm < 0.15


def test_a_section_that_does_not_turn_keeps_its_doubt_and_has_no_ovality():
    last = turning(40, 0.0, ovality_mm=0.8)
    assert math.isnan(last.bar_ovality_mm)
    assert last.bar_expanded_uncertainty_mm > 0.4


@pytest.mark.parametrize("seed", range(20))
def test_noise_is_no_ovality(seed):
    assert math.isnan(turning(50, 250.0, ovality_mm=0.0, seed=seed).bar_ovality_mm)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "along_mm",
    [
        pytest.param(0.4 * np.sin(2 * np.pi * 1.5 * np.linspace(0, 1, 50)), id="wave of a roll that runs out"),
        pytest.param(np.linspace(-0.4, 0.4, 50), id="taper"),
    ],
)
def test_a_diameter_that_changes_along_the_bar_is_no_ovality_and_the_unseen_shape_stays_in_the_uncertainty(
    along_mm, seed
):
    last = of_widths(120 + along_mm, 120 + along_mm, seed=seed)
    assert last.bar_frames == 50
    assert math.isnan(last.bar_ovality_mm)
    assert last.bar_expanded_uncertainty_mm > 2 * 0.2
