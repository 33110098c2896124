"""Bars side by side keep their slots."""

import math

import pytest

from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.side_by_side import SideBySide

PERIOD_S = 0.04


def bar(offset_mm, diameter_mm=100.0):
    return SizeReading(
        diameter_mm=diameter_mm, expanded_uncertainty_mm=0.1, offset_mm=offset_mm,
        u_edge_mm=0.01, u_calibration_mm=0.02, u_board_mm=0.02, u_light_mm=0.02, u_shape_mm=0.0, u_model_mm=0.02,
    )  # fmt: skip


HIDDEN = SizeReading(reasons=Reason.ONE_CAMERA)


def slots(side_by_side):
    return [one.diameter_mm for one in side_by_side.slots]


def test_bars_are_numbered_from_smaller_x_and_keep_their_slots_while_they_sway():
    passing = SideBySide()
    for frame in range(10):
        result = passing.add((bar(-90.0 - frame, 80.0), bar(90.0 + 2 * frame, 120.0)), PERIOD_S * frame)
    assert [one.diameter_mm for one in result] == [80.0, 120.0]
    assert [one.bar_frames for one in result] == [10, 10]
    assert slots(passing)[:2] == [80.0, 120.0]
    assert passing.slots[2].reasons == Reason.NO_BAR


def test_a_bar_that_is_hidden_has_no_value_and_comes_back_into_its_slot():
    passing = SideBySide()
    passing.add((bar(-90.0, 80.0), bar(90.0, 120.0)), 0.0)
    passing.add((bar(90.0, 120.0), HIDDEN), PERIOD_S)
    assert math.isnan(passing.slots[0].diameter_mm)
    assert slots(passing)[1] == 120.0
    passing.add((bar(-90.0, 80.0), bar(90.0, 120.0)), 2 * PERIOD_S)
    assert slots(passing)[:2] == [80.0, 120.0]


def test_a_bar_that_leaves_frees_its_slot_and_moves_no_other():
    passing = SideBySide()
    passing.add((bar(-90.0, 80.0), bar(90.0, 120.0)), 0.0)
    for frame in range(1, 100):
        passing.add((bar(90.0, 120.0), bar(250.0, 60.0)), PERIOD_S * frame)
    assert slots(passing)[1] == 120.0
    assert 60.0 in slots(passing)
    assert 80.0 not in slots(passing)


@pytest.mark.parametrize("reason", [Reason.NO_BAR, Reason.EDGE_NOT_FOUND, Reason.SEVERAL_BARS])
def test_bars_that_enter_together_after_a_frame_without_a_value_stand_in_the_first_slots(reason):
    passing = SideBySide()
    passing.add((SizeReading(reasons=reason),), 0.0)
    passing.add((bar(-90.0, 80.0), bar(90.0, 120.0)), PERIOD_S)
    assert slots(passing)[:2] == [80.0, 120.0]
    assert {one.reasons for one in passing.slots[2:]} == {Reason.NO_BAR}


def test_one_bar_without_a_place_has_its_mean_as_well():
    passing = SideBySide()
    readings = [passing.add((bar(math.nan),), PERIOD_S * frame)[0] for frame in range(3)]
    assert [one.bar_frames for one in readings] == [1, 2, 3]


def test_more_bars_than_slots_are_measured_but_have_none():
    passing = SideBySide()
    result = passing.add(tuple(bar(100.0 * place) for place in range(5)), 0.0)
    assert len(result) == 5
    assert not any(math.isnan(diameter) for diameter in slots(passing))


EMPTY = SizeReading(reasons=Reason.NO_BAR)


@pytest.mark.parametrize("readings", [(bar(90.0, 120.0),), (bar(-90.0, 80.0), bar(90.0, 120.0))])
def test_a_frame_that_misses_all_bars_says_so_in_every_slot_and_keeps_them(readings):
    passing = SideBySide()
    passing.add(readings, 0.0)
    passing.add((EMPTY,), PERIOD_S)
    assert {one.reasons for one in passing.slots} == {Reason.NO_BAR}
    assert [one.bar_frames for one in passing.add(readings, 2 * PERIOD_S)] == [2] * len(readings)


def test_after_a_gap_other_bars_begin_in_the_first_slots_with_values_of_their_own():
    passing = SideBySide()
    passing.add((bar(-90.0, 80.0), bar(90.0, 120.0)), 0.0)
    for frame in range(1, 10):
        passing.add((EMPTY,), PERIOD_S * frame)
    result = passing.add((bar(90.0, 120.0),), PERIOD_S * 10)
    assert result[0].bar_frames == 1
    assert slots(passing)[0] == 120.0


def test_time_that_runs_back_begins_other_bars():
    passing = SideBySide()
    passing.add((bar(-90.0, 80.0), bar(90.0, 120.0)), 7.0)
    assert passing.add((bar(90.0, 120.0),), 0.0)[0].bar_frames == 1
    assert slots(passing)[0] == 120.0
