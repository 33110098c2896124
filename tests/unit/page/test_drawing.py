"""Charts: what is drawn where."""

import re

import pytest

from appliance.page.drawing import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Frame, Limits, Point, chart

FRAME = Frame(0.0, 100.0, 2.0, [(0.0, "0 s"), (100.0, "100 s")], 'sizes, "mm" <')
NO_LIMITS = Limits(None, None, None)


def lines(svg: str) -> list[list[tuple[float, float]]]:
    found = re.findall(r'<polyline class="size" points="([^"]*)"', svg)
    return [[tuple(map(float, pair.split(","))) for pair in points.split()] for points in found]


def test_points_lie_between_the_ends_in_time_and_larger_sizes_higher():
    svg = chart([Point(0.0, 99.0, 0.1), Point(1.0, 101.0, 0.1), Point(100.0, 100.0, 0.1)], NO_LIMITS, FRAME)
    first, second = lines(svg)
    assert first[0][0] == LEFT
    middle = (TOP + HEIGHT - BOTTOM) / 2
    assert second == 2 * [(WIDTH - RIGHT, pytest.approx(middle, abs=0.1))]  # a dot
    assert first[1][1] < second[0][1] < first[0][1]


def test_points_apart_and_points_around_no_value_are_not_joined():
    points = [Point(0, 100.0, 0), Point(1, 100.1, 0), Point(2, None, None), Point(3, 100.0, 0), Point(9, 100.0, 0)]
    assert [len(line) for line in lines(chart(points, NO_LIMITS, FRAME))] == [2, 2, 2]


def test_the_band_is_u_either_way():
    svg = chart([Point(0, 100.0, 0.5), Point(1, 100.0, 0.5)], NO_LIMITS, FRAME)
    band = re.search(r'class="band" points="([^"]*)"', svg)[1]
    heights = sorted({float(pair.split(",")[1]) for pair in band.split()})
    assert heights == [TOP, HEIGHT - BOTTOM]  # 1 mm is the least that is shown


def test_limits_are_drawn_unless_they_are_another_products():
    points = [Point(0, 100.0, 0.1)]
    assert chart(points, Limits(100.5, 100.0, 101.0), FRAME).count('class="limit"') == 2
    assert 'class="target"' not in chart(points, Limits(250.0, 249.0, 251.0), FRAME)


def test_without_a_value_there_is_no_chart():
    assert chart([], NO_LIMITS, FRAME) == ""
    assert chart([Point(0, None, None)], NO_LIMITS, FRAME) == ""


def test_words_are_escaped():
    assert 'aria-label="sizes, &quot;mm&quot; &lt;"' in chart([Point(0, 100.0, 0.1)], NO_LIMITS, FRAME)
