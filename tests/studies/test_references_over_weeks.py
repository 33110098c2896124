"""What is claimed of references that learn: they do no harm, and bring back what a new camera costs `dual`."""

import json

import pytest

from studies.__main__ import RESULTS
from studies.references_over_weeks import LINES, WAYS

WITHIN_PERCENT = 0.5  # of 200 pictures of a line: one
LEAST_GAIN_PERCENT = 5.0


@pytest.fixture(scope="module")
def rows():
    return json.loads((RESULTS / "references_over_weeks.json").read_text(encoding="utf-8"))["rows"]


@pytest.mark.parametrize("way", WAYS[1:])
def test_no_line_does_worse_than_with_the_commissioned_references_also_when_one_word_in_twenty_is_wrong(rows, way):
    assert len(rows) == sum(LINES.values())
    assert min(row[way]["all"] - row["none"]["all"] for row in rows) >= -WITHIN_PERCENT


def test_an_operator_brings_back_what_a_new_camera_costs_dual(rows):
    gains = [
        row["operator"]["with_the_new_camera"] - row["none"]["with_the_new_camera"]
        for row in rows
        if row["classifier"] == "dual"
    ]
    assert sum(gains) / len(gains) >= LEAST_GAIN_PERCENT
