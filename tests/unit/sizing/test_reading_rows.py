"""Rows of measured recordings: rounding, bars, judgement; and the summary with a likely cause."""

import pytest

from appliance.conformity.row_judge import row_judge
from appliance.conformity.set_points import SetPoints
from appliance.conformity.settings import JudgingSettings
from appliance.sizing.reading_rows import COLUMNS, ReadingRows
from appliance.sizing.summary import LIKELY_CAUSES, Summary
from vision.readings import SizeReading
from vision.reasons import REASONS, Reason

EMPTY = SizeReading(reasons=Reason.NO_BAR)
PERIOD_S = 0.04


def bar(diameter_mm=150.123456, **more):
    values = {"expanded_uncertainty_mm": 0.1234567, "u_edge_mm": 0.0123456, "windows_kept": 20, "windows_total": 20}
    return SizeReading(diameter_mm=diameter_mm, **values | more)


def test_numbers_are_rounded_to_what_is_meaningful_and_nan_is_nothing():
    row = ReadingRows().row(7, bar(), 12.3456, 0.001, time_us=1_000)
    assert list(row) == list(COLUMNS)
    assert (row["diameter_mm"], row["u_edge_mm"], row["elapsed_ms"], row["time_us"]) == (150.123, 0.0123, 12.3, 1000)
    assert row["plane_height_mm"] is None
    assert row["decision"] is row["target_mm"] is None


def bar_numbers(*readings, period_s=PERIOD_S):
    rows = ReadingRows()
    return [rows.row(n, reading, 1.0, period_s * n)["bar_number"] for n, reading in enumerate(readings)]


def test_frames_that_show_a_bar_without_a_gap_have_one_number():
    passed = [EMPTY, bar(), SizeReading(reasons=Reason.FIT_FAILED), bar(), *[EMPTY] * 8, bar(), EMPTY]
    assert bar_numbers(*passed) == [None, 1, 1, 1, *[None] * 8, 2, None]


def test_one_frame_in_which_the_bar_was_missed_begins_no_other_bar():
    assert bar_numbers(bar(), EMPTY, bar()) == [1, None, 1]
    assert bar_numbers(bar(), EMPTY, bar(), period_s=1.0) == [1, None, 2]


def test_rows_of_bars_side_by_side_have_one_number_and_time_that_runs_back_begins_another():
    rows = ReadingRows()
    moments_s = [5.0, 5.0, 5.04, 5.04, 1.0, 1.0]
    numbers = [rows.row(n // 2, bar(), 1.0, moment, bar=n % 2)["bar_number"] for n, moment in enumerate(moments_s)]
    assert numbers == [1, 1, 1, 1, 2, 2]


@pytest.mark.parametrize(
    ("diameter_mm", "decision"), [(150.1, "in"), (150.45, "undecided"), (150.7, "out"), (149.2, "out")]
)
def test_a_reading_is_compared_with_what_is_wanted(diameter_mm, decision):
    points = SetPoints(target_mm=150.0, tolerance_plus_mm=0.5, tolerance_minus_mm=0.5)
    row = ReadingRows(row_judge(points, JudgingSettings())).row(0, bar(diameter_mm), 1.0, 0.0)
    assert row["decision"] == decision
    assert row["deviation_mm"] == pytest.approx(diameter_mm - 150.0, abs=5e-4)
    assert row["target_mm"] == 150.0
    assert row["trust"] == 100.0
    empty = ReadingRows(row_judge(points, JudgingSettings())).row(0, EMPTY, 1.0, 0.0)
    assert (empty["decision"], empty["deviation_mm"], empty["trust"]) == (None, None, 0.0)


def test_a_reading_that_is_not_trusted_is_undecided_as_the_plcs_is():
    points = SetPoints(target_mm=150.0, tolerance_plus_mm=0.5, tolerance_minus_mm=0.5)
    row = ReadingRows(row_judge(points, JudgingSettings())).row(0, bar(150.0, windows_kept=1), 1.0, 0.0)
    assert (row["decision"], row["trust"]) == ("undecided", 5.0)


def summed(*readings, cause=""):
    summary = Summary()
    for reading in readings:
        summary.add(reading)
    return "\n".join(summary.lines(cause))


def test_a_recording_without_a_value_names_its_reason_and_a_likely_cause():
    said = summed(*[EMPTY] * 50)
    assert said.startswith("0 of 50 frames have a value\n")
    assert "no_bar in 50" in said
    assert "left and right exchanged?" in said
    assert "swapped, it works" in summed(*[EMPTY] * 50, cause="swapped, it works")


def test_an_empty_line_between_bars_needs_no_cause():
    said = summed(EMPTY, EMPTY, bar(150.0), bar(150.5))
    assert "2 of 4 frames have a value" in said
    assert "diameter 150.00 to 150.50 mm, mean 150.25 mm; U 0.12 mm" in said
    assert "likely" not in said


def test_doubts_of_values_and_mixed_reasons_are_counted_apart():
    doubted = bar(reasons=Reason.LOW_CONTRAST)
    said = summed(doubted, bar(), SizeReading(reasons=Reason.FIT_FAILED), SizeReading(reasons=Reason.VIEWS_DISAGREE))
    assert "doubts: low_contrast in 1" in said
    assert "without a value: fit_failed in 1, views_disagree in 1" in said


def test_every_reason_that_pictures_can_give_has_a_likely_cause():
    of_the_appliance = {Reason.NO_PAIR, Reason.STALE, Reason.STARTING, Reason.HELD}
    forbidding = {row.flag for row in REASONS if row.forbids_value}
    assert set(LIKELY_CAUSES) == forbidding - of_the_appliance
