"""Lines between barriers, our own kinds and those of other makers: how many have a value, and U holds in each kind."""

import json

import pytest

from studies import conveyor, conveyor_elsewhere
from studies.__main__ import RESULTS

KINDS = [
    *(("conveyor", line, given) for line in conveyor.SEEDS for given in conveyor.KNOWN),
    *(("conveyor_elsewhere", line, given) for line in conveyor_elsewhere.SEEDS for given in conveyor.KNOWN),
    ("conveyor_elsewhere", "rollers", "barrier_height_without_an_empty_picture"),
]


@pytest.fixture(scope="module")
def summaries():
    return {
        name: json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))["summary"]
        for name in ("conveyor", "conveyor_elsewhere")
    }


@pytest.mark.parametrize(("study", "line", "given"), KINDS)
def test_lines_of_each_kind_have_values_whose_uncertainty_holds(summaries, study, line, given):
    found = summaries[study][line][given]
    assert found["valid"] >= 0.97 * found["lines"]
    assert found["inside"] >= 0.93
    assert found["errors_over_twice_expanded"] == 0


def test_three_hundred_lines_were_drawn_and_half_of_them_are_of_other_makers(summaries):
    own, elsewhere = (
        sum(kind["with_heights"]["lines"] for name, kind in found.items() if not name.startswith("experiment"))
        for found in summaries.values()
    )
    assert own + elsewhere >= 300
    assert elsewhere >= 150
