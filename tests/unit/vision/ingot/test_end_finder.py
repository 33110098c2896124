"""Ends of ingots found in drawn pictures, and the reason where none is."""

import cv2
import numpy as np
import pytest
from drawn_ingots import CENTROID, CROP, DARK, glare, ingot, line

from vision.ingot.end_finder import Box, EndFinder, EndLimits
from vision.reasons import INGOT_REASONS, IngotReason


@pytest.fixture(scope="module")
def finder():
    return EndFinder(Box(*CROP), Box(*CENTROID))


def reason(finder, picture):
    end, reasons = finder.find(picture)
    assert end is None
    return reasons


def assert_is_at(end, x, y, radius, within=1.0):
    assert (end.center_x, end.center_y, end.radius) == pytest.approx((x, y, radius), abs=within)


def test_a_box_holds_its_first_column_and_row_and_ends_before_the_last_ones():
    box = Box(10, 20, 5, 4)
    assert box.holds(10, 20)
    assert box.holds(14.9, 23.9)
    assert not any(box.holds(x, y) for x, y in ((9.9, 22), (15, 22), (12, 19.9), (12, 24)))


@pytest.mark.parametrize("seed", range(12))
def test_an_end_is_found_where_it_was_drawn(finder, seed):
    rng = np.random.default_rng(seed)
    x, y, radius = rng.uniform(440, 520), rng.uniform(240, 330), rng.uniform(34, 46)
    end, reasons = finder.find(ingot(line(), x, y, radius, length=rng.uniform(1.35, 1.6), lean=rng.uniform(-5, 5)))
    assert_is_at(end, x, y, radius)
    assert end.method == "region"
    assert reasons is IngotReason.NONE


def test_an_end_is_found_in_a_grey_picture(finder):
    grey = np.ascontiguousarray(ingot(line())[..., 2])
    assert_is_at(finder.find(grey)[0], 480, 280, 40)


@pytest.mark.parametrize(
    ("area_px", "fits"),
    [((4300, 4900), False), ((5200, 6500), True), ((12300, 13700), True), ((14500, 17000), False)],
)
def test_a_region_outside_the_dissertation_s_areas_is_no_ingot_and_only_a_circle_is_looked_for(area_px, fits):
    finder = EndFinder(Box(*CROP), Box(*CENTROID), EndLimits(radius_px=(15.0, 90.0)))
    drawn = (ingot(line(), 480, 280, radius, length=1.45) for radius in np.arange(24.0, 70.0, 0.5))
    picture = next(one for one in drawn if area_px[0] < np.count_nonzero(one[..., 2] > 150) < area_px[1])
    end, _ = finder.find(picture)
    assert (end is not None and end.method == "region") == fits


@pytest.mark.parametrize("turn_deg", [-19.0, -11.0, 11.0, 19.0])
def test_an_ingot_is_tilted_from_15_degrees_on(finder, turn_deg):
    turn = cv2.getRotationMatrix2D((480.0, 280.0), turn_deg, 1.0)
    picture = cv2.warpAffine(ingot(line(), length=1.8), turn, (960, 540), borderValue=DARK)
    end, reasons = finder.find(picture)
    assert (end is None) == (abs(turn_deg) > 15.0)
    assert reasons is (IngotReason.TILTED if end is None else IngotReason.NONE)


def test_pixels_that_touch_at_a_corner_belong_together(finder):
    """A crack one pixel wide at 45 degrees: what lies on both sides of it touches at corners only."""
    picture = ingot(line())
    for step in range(-90, 91):
        picture[250 + step, 480 + step] = DARK
    end, reasons = finder.find(picture)
    assert end.method == "region"
    assert_is_at(end, 480, 280, 40)
    assert reasons is IngotReason.NONE


@pytest.mark.parametrize("side", [-1, 1])
def test_glare_that_joins_the_ingot_calls_for_a_circle(finder, side):
    picture = glare(ingot(line()), 480 + side * 75, 300, 45, 22)
    end, reasons = finder.find(picture)
    assert_is_at(end, 480, 280, 40, within=1.5)
    assert end.method == "circle"
    assert reasons is IngotReason.GLARE_JOINED


def test_the_larger_of_two_ends_is_taken_and_said_so(finder):
    picture = ingot(ingot(line(), 430, 260, 34), 530, 300, 42)
    end, reasons = finder.find(picture)
    assert_is_at(end, 530, 300, 42)
    assert reasons is IngotReason.SEVERAL_ENDS


def test_nothing_hot_on_an_empty_line_or_under_glare_alone(finder):
    assert reason(finder, line()) is IngotReason.NOTHING_HOT
    assert reason(finder, glare(line(), 480, 300, 60, 40)) is IngotReason.NOTHING_HOT
    dim = ingot(line(), colour=(20, 45, 80))
    assert reason(finder, dim) is IngotReason.NOTHING_HOT


@pytest.mark.parametrize(
    ("drawn", "wanted"),
    [
        ({"y": 150.0}, IngotReason.HANGING),  # cut by the crop's upper side
        ({"y": 330.0, "length": 2.4}, IngotReason.HANGING),  # on end, in full view
        ({"y": 420.0}, IngotReason.OUTSIDE),  # cut by the lower side
        ({"x": 390.0}, IngotReason.OUTSIDE),  # cut by the left side
        ({"x": 574.0, "radius": 34.0}, IngotReason.OUTSIDE),  # whole, beside where centroids may be
        ({"radius": 28.0}, IngotReason.TOO_SMALL),
        ({"radius": 70.0, "y": 320.0}, IngotReason.TOO_LARGE),
        ({"lean": 40.0, "length": 1.8}, IngotReason.TILTED),
    ],
)
def test_the_reason_says_why_there_is_no_end(finder, drawn, wanted):
    assert reason(finder, ingot(line(), **drawn)) is wanted


def test_a_glowing_box_is_not_taken_for_an_end(finder):
    picture = line()
    picture[230:330, 440:520] = (40, 130, 240)
    assert reason(finder, picture) is IngotReason.NO_CIRCLE


def test_wider_limits_find_a_smaller_end_and_limits_the_wrong_way_round_are_refused(finder):
    small = ingot(line(), radius=28.0)
    wide = EndFinder(Box(*CROP), Box(*CENTROID), EndLimits.wide(960))
    assert_is_at(wide.find(small)[0], 480, 280, 28)
    with pytest.raises(ValueError, match="radius_px"):
        EndLimits(radius_px=(50.0, 40.0))


def test_wrong_calls_name_the_argument(finder):
    with pytest.raises(ValueError, match="picture: a uint8 picture is needed"):
        finder.find(line().astype(float))
    for shape in ((540,), (540, 960, 4)):
        with pytest.raises(ValueError, match="picture"):
            finder.find(np.zeros(shape, np.uint8))
    with pytest.raises(ValueError, match="crop"):
        finder.find(np.zeros((300, 400, 3), np.uint8))
    with pytest.raises(ValueError, match="centroid"):
        EndFinder(Box(*CROP), Box(0, 0, 0, 5))


def test_every_flag_stands_in_the_table_of_reasons():
    assert {row.flag for row in INGOT_REASONS} == set(IngotReason) - {IngotReason.NONE}
    assert all(row.forbids_value == (row.flag < IngotReason.GLARE_JOINED) for row in INGOT_REASONS)
