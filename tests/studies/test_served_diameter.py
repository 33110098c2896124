"""What is claimed of the served diameter of bars under every condition; bounds are 1.3 times what is claimed."""

import json

import pytest

from studies.__main__ import RESULTS
from studies.served_diameter import BARS


@pytest.fixture(scope="module")
def study():
    return json.loads((RESULTS / "served_diameter.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def bars(study):
    return study["summary"]["bars"]


def test_at_least_a_hundred_rigs_were_drawn(study):
    assert len({row["seed"] for row in study["rows"]}) >= 100


def test_no_value_is_wrong(bars):
    assert bars["wrong_values"] == bars["values_without_a_measurable_bar"] == 0


def test_nearly_every_bar_gets_a_value(bars):
    assert bars["availability"] >= 0.97


def test_errors_are_as_small_as_claimed(bars):
    assert bars["rmse_mm"] <= 1.3 * 0.053
    assert bars["worst_mm"] <= 1.3 * 0.17


def test_none_is_large_where_half_of_the_windows_agree(study):
    sure = [row for row in study["rows"] if row["condition"] in BARS and "few_windows" not in row["reasons"]]
    assert max(abs(row.get("error_mm") or 0.0) for row in sure) <= 1.3 * 0.17


def test_route_v_errs_by_no_more_than_is_said_of_it(bars):
    assert bars["virtual_board_rmse_mm"] <= 1.3 * 0.07
    assert bars["virtual_board_worst_mm"] <= 1.3 * 0.62
