"""Q_R, its sign, and the loop over the board's height, on outlines and offsets that are known."""

import math

import numpy as np
import pytest

from vision.alignment.height_search import HeightLoop, search_by_offset, search_by_overlap
from vision.alignment.quality import BarOutline, Quality, alignment_quality

ROWS = np.arange(0.0, 101.0)


def outline(first, second):
    return BarOutline(np.array([[first, 0.0], [first, 100.0]]), np.array([[second, 0.0], [second, 100.0]]))


def test_quality_is_the_common_area_over_the_left_one():
    quality = alignment_quality(outline(10, 110), outline(35, 135), ROWS)
    assert quality.percent == pytest.approx(75.0)
    assert quality.offset_px == pytest.approx(-25.0)


def test_quality_is_over_the_left_area_also_where_the_right_one_is_smaller():
    assert abs(alignment_quality(outline(0, 100), outline(25, 75), ROWS).percent) == pytest.approx(50.0)
    assert abs(alignment_quality(outline(25, 75), outline(0, 100), ROWS).percent) == pytest.approx(100.0)


def test_quality_is_positive_when_the_left_view_s_outline_lies_to_the_left():
    assert alignment_quality(outline(10, 110), outline(20, 120), ROWS).percent > 0
    assert alignment_quality(outline(20, 120), outline(10, 110), ROWS).percent < 0


def test_outlines_that_do_not_touch_share_nothing_and_an_empty_one_has_no_quality():
    assert alignment_quality(outline(0, 10), outline(50, 60), ROWS).percent == 0
    assert math.isnan(alignment_quality(outline(10, 10), outline(0, 60), ROWS).percent)


@pytest.mark.parametrize("seed", range(4))
def test_rows_out_of_order_after_t_rl_change_no_quality(seed):
    rows = np.arange(0.0, 101.0, 5.0)
    chain = np.column_stack([10.0 + 0.1 * rows + 9 * np.sin(rows / 7), rows])  # points of a straight one tell nothing
    shuffled = chain[np.random.default_rng(seed).permutation(len(chain))]
    sorted_one, mixed = (BarOutline(first, first + np.array([100.0, 0.0])) for first in (chain, shuffled))
    right = outline(30, 130)
    wanted = alignment_quality(sorted_one, right, ROWS)
    assert alignment_quality(mixed, right, ROWS) == wanted
    assert 75 < abs(wanted.percent) < 95


def board_of(height_mm, truth_mm):
    """A bar of 200 px whose outlines part by half a pixel per mm, a little more the higher the board."""
    off = 0.5 * (height_mm - truth_mm) * (1 + 1e-4 * height_mm)
    return Quality(math.copysign(max(0.0, 100 - abs(off) / 2), off), -off)


def evaluations(loop, truth_mm):
    found = loop.find(lambda height: board_of(height, truth_mm), lambda _: -0.5)
    assert found.height_mm == pytest.approx(truth_mm, abs=0.011)
    return found.evaluations


def test_the_loop_follows_a_bar_in_a_few_boards_and_a_jump_of_its_size_too():
    loop = HeightLoop()
    assert evaluations(loop, 70.0) <= 4
    assert evaluations(loop, 71.5) <= 3
    assert evaluations(loop, 150.0) <= 4


def test_the_loop_searches_all_boards_where_the_slope_leads_nowhere():
    loop = HeightLoop()
    found = loop.find(lambda height: board_of(height, 140.0), lambda _: 1e-4)
    assert found.height_mm == pytest.approx(140.0, abs=0.011)
    assert found.evaluations > 40


@pytest.mark.parametrize("truth_mm", [-100.0, 600.0])
def test_no_height_is_no_height_and_the_loop_keeps_its_last(truth_mm):
    loop = HeightLoop()
    evaluations(loop, 80.0)
    assert math.isnan(loop.find(lambda height: board_of(height, truth_mm), lambda _: -0.5).height_mm)
    assert loop.height_mm == pytest.approx(80.0, abs=0.011)


@pytest.mark.parametrize("search", [search_by_overlap, search_by_offset])
def test_forty_boards_from_the_conveyor_up_to_320_mm_are_tried(search):
    tried = []
    search(lambda height_mm: tried.append(height_mm) or board_of(height_mm, 123.0))
    assert tried == pytest.approx(np.linspace(0.0, 320.0, 40))


def test_both_searches_end_within_half_a_board_of_the_truth():
    for search in (search_by_overlap, search_by_offset):
        assert abs(search(lambda height: board_of(height, 123.0)).height_mm - 123.0) <= 320 / 39 / 2
    assert math.isnan(search_by_offset(lambda _: Quality(math.nan, math.nan)).height_mm)


@pytest.mark.parametrize(("first_row", "last_row"), [(0.0, 40.0), (60.0, 100.0), (20.0, 30.0)])
def test_an_outline_that_ends_within_the_test_rows_goes_on_straight(first_row, last_row):
    def slanted(first, last):
        return BarOutline(*(np.array([[at + 0.3 * row, row] for row in (first, last)]) for at in (10.0, 110.0)))

    whole, part = slanted(0.0, 100.0), slanted(first_row, last_row)
    for pair in ((whole, part), (part, whole)):
        quality = alignment_quality(*pair, ROWS)
        assert abs(quality.percent) == pytest.approx(100.0)
        assert quality.offset_px == pytest.approx(0.0, abs=1e-9)
