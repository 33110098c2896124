"""What is claimed of a line with all effects: served frames, the passing bar, bars side by side, a nudged camera.

Bounds are 1.3 times what docs/methods/real_line.md claims; U holds 93 to 98 % of the values, within one standard error.
"""

import json

import numpy as np
import pytest

from studies.__main__ import RESULTS

LEAST_INSIDE, MOST_INSIDE, LEAST_SERVED = 0.93, 0.98, 0.97
MOST_STANDARD_ERROR = 0.03  # with fewer rigs than these studies draw they would show nothing


def summary(name):
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))["summary"]


@pytest.fixture(scope="module")
def line():
    return summary("real_line")["all"]


def test_the_studies_drew_as_many_lines_bars_and_cameras_as_is_said(line):
    assert line["lines"] >= 500
    assert all(found["pairs"] >= 60 for found in summary("bars_side_by_side").values())
    assert all(found["cameras"] >= 60 for found in summary("nudged_camera").values())


def test_errors_of_frames_and_of_bars_are_as_small_as_claimed(line):
    assert line["rmse_mm"] <= 1.3 * 0.20
    assert line["bar_rmse_mm"] <= 1.3 * 0.17


def test_no_value_is_wrong_and_nearly_every_frame_has_one(line):
    assert line["wrong_values"] == 0
    assert line["served"] >= LEAST_SERVED


@pytest.mark.parametrize("prefix", ["", "bar_"])
def test_the_interval_holds_and_half_of_it_does_not(line, prefix):
    assert line[f"{prefix}inside"] >= LEAST_INSIDE
    assert line[f"{prefix}inside_half"] < LEAST_INSIDE


def holds(found):
    """Whether U holds in 93 to 98 % of the values, as far as the rigs of a study can show it."""
    error = found["inside_standard_error"]
    return error <= MOST_STANDARD_ERROR and LEAST_INSIDE - error <= found["inside"] <= MOST_INSIDE + error


@pytest.mark.parametrize(("count", "worst_mm"), [("1", 0.09), ("2", 0.16), ("3", 0.21), ("4", 0.09)])
def test_bars_side_by_side_are_each_measured_and_none_is_invented(count, worst_mm):
    found = summary("bars_side_by_side")[count]
    assert found["false_values"] == 0
    assert found["worst_mm"] <= 1.3 * worst_mm
    assert holds(found)
    assert found["values"] >= 0.5 * found["bars"]  # where views are oblique, neighbours hide each other


def test_a_camera_turned_by_a_twentieth_of_a_degree_is_corrected():
    turned = summary("nudged_camera")["0.05"]
    assert turned["worst_mm"] <= 1.3 * 0.12
    assert turned["uncorrected_worst_mm"] > 0.3
    assert holds(turned)


def test_a_turn_of_a_fiftieth_of_a_degree_is_told():
    turned = summary("nudged_camera")["0.02"]
    assert turned["told"] >= 0.75 * turned["cameras"]  # a turn about the line of sight moves marks by less than 0.3 px
    assert turned["worst_mm"] <= 1.3 * 0.11
    assert holds(turned)


def test_the_bar_s_value_is_within_0_12_mm_under_shimmer_and_hop():
    rows = json.loads((RESULTS / "real_line.json").read_text(encoding="utf-8"))["rows"]
    mine = [row for row in rows if row.get("bar_error_mm") is not None and {"shimmer", "hop"} & set(row["effects"])]
    mine = [row["bar_error_mm"] for row in mine if not {"oval", "scale"} & set(row["effects"])]
    assert np.sqrt(np.mean(np.square(mine))) <= 0.12
