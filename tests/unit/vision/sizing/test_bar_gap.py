"""When a bar has passed: after a gap, after blindness, where time runs back."""

import pytest

from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.bar_gap import BarGap

BAR = SizeReading(diameter_mm=100.0)
EMPTY = SizeReading(reasons=Reason.NO_BAR)
UNMEASURED = SizeReading(reasons=Reason.EDGE_NOT_FOUND)


def ends(gap: BarGap, *readings: tuple[float, SizeReading]) -> list[float]:
    """Moments at which a bar that was there has passed; the first reading has none before it."""
    return [time_s for time_s, reading in readings if gap.ends_bar(reading, time_s)][1:]


@pytest.mark.parametrize(("empty_s", "passed"), [([0.1, 0.2, 0.29], []), ([0.1, 0.2, 0.31], [0.31])])
def test_readings_without_a_bar_end_it_after_the_gap_and_not_before(empty_s, passed):
    readings = [(0.0, BAR), *((time_s, EMPTY) for time_s in empty_s), (0.35, BAR)]
    assert ends(BarGap(0.3), *readings) == passed


def test_every_reading_that_shows_a_bar_begins_the_gap_anew():
    readings = [(0.0, BAR), (0.2, EMPTY), (0.25, UNMEASURED), (0.5, EMPTY), (0.54, BAR), (0.8, EMPTY)]
    assert ends(BarGap(0.3), *readings) == []


@pytest.mark.parametrize(
    ("gap_s", "next_s", "passed"), [(0.3, 1.9, []), (0.3, 2.1, [2.1]), (5.0, 4.9, []), (5.0, 5.1, [5.1])]
)
def test_a_time_without_any_reading_ends_a_bar_once_it_is_longer_than_two_seconds_and_than_the_gap(
    gap_s, next_s, passed
):
    assert ends(BarGap(gap_s), (0.0, BAR), (next_s, BAR)) == passed


@pytest.mark.parametrize("last", [BAR, EMPTY])
def test_time_that_runs_back_ends_the_bar_though_the_last_reading_showed_none(last):
    assert ends(BarGap(0.3), (0.0, BAR), (0.2, last), (0.1, BAR), (0.14, BAR)) == [0.1]


def test_bars_side_by_side_in_one_frame_have_one_moment_and_end_nothing():
    assert ends(BarGap(0.3), (0.0, BAR), (0.0, BAR), (0.04, BAR), (0.04, BAR)) == []
