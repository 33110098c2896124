"""What is claimed of the served diameter, over every condition that the gauge models."""

import json

import pytest

from studies.__main__ import RESULTS


@pytest.fixture(scope="module")
def modelled():
    return json.loads((RESULTS / "served_diameter.json").read_text(encoding="utf-8"))["summary"]["all that is modelled"]


def test_no_value_is_wrong(modelled):
    assert modelled["wrong_values"] == modelled["values_without_a_measurable_bar"] == 0


def test_nearly_every_bar_gets_a_value(modelled):
    assert modelled["availability"] >= 0.97


def test_errors_are_as_small_as_claimed(modelled):
    assert modelled["rmse_mm"] <= 0.10
    assert modelled["worst_mm"] <= 0.30


def test_route_v_stands_beside_it(modelled):
    assert modelled["virtual_board_rmse_mm"] <= 0.40
    assert modelled["virtual_board_worst_mm"] <= 1.5
