"""What is claimed of the served diameter, over every condition that the gauge models."""

import json

import pytest

from studies.__main__ import RESULTS
from studies.served_diameter import MODELLED


@pytest.fixture(scope="module")
def study():
    return json.loads((RESULTS / "served_diameter.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def modelled(study):
    return study["summary"]["all that is modelled"]


def test_no_value_is_wrong(modelled):
    assert modelled["wrong_values"] == modelled["values_without_a_measurable_bar"] == 0


def test_nearly_every_bar_gets_a_value(modelled):
    assert modelled["availability"] >= 0.97


def test_errors_are_as_small_as_claimed(modelled):
    assert modelled["rmse_mm"] <= 0.10


def test_none_is_large_where_half_of_the_windows_agree(study):
    sure = [row for row in study["rows"] if row["condition"] in MODELLED and "few_windows" not in row["reasons"]]
    assert max(abs(row.get("error_mm") or 0.0) for row in sure) <= 0.30


def test_route_v_errs_by_no_more_than_is_said_of_it(modelled):
    assert modelled["virtual_board_rmse_mm"] <= 0.40
    assert modelled["virtual_board_worst_mm"] <= 1.5
