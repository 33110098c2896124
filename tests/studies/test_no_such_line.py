"""No picture without a line between barriers gives a value or an error; and what keeps them out can fail."""

import json

import pytest

from studies.__main__ import RESULTS
from studies.no_such_line import SIZES, cases, outcome, run
from vision.sizing.conveyor import barriers
from vision.sizing.conveyor.barriers import LEAST_SIDE_PX

SHOWN = ("itself", "striped", "elsewhere")


@pytest.fixture(scope="module")
def rows():
    return json.loads((RESULTS / "no_such_line.json").read_text(encoding="utf-8"))["rows"]


def test_two_hundred_pictures_have_a_reason_or_a_sentence_each_and_no_value(rows):
    assert len(rows) == len(cases()) >= 200
    assert all(row[name] and row[name] != "value" for row in rows for name in SHOWN)


def test_tiny_pictures_and_false_colours_are_refused_in_a_sentence(rows):
    tiny = [row for row in rows if row["kind"] == "uniform" and min(SIZES[row["number"] // 3]) < LEAST_SIDE_PX]
    coloured = [row for row in rows if row["kind"] == "palette"]
    assert len(tiny) >= 10
    assert all(row["itself"] == row["striped"] for row in tiny + coloured)
    assert all(row["itself"].startswith("picture: pictures of") for row in tiny)
    assert all(row["itself"].startswith("picture: the camera's pictures are") for row in coloured)


def test_an_error_that_is_no_sentence_to_the_user_is_not_taken_for_one():
    def measure():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        outcome(measure)


def test_edges_that_cross_would_be_barriers_if_nobody_asked_where_they_meet(rows, monkeypatch):
    crossing = [row for row in rows if row["kind"] == "two_edges"]
    assert all(row["itself"] == ["edge_not_found", "barrier_hidden"] for row in crossing)
    monkeypatch.setattr(barriers, "_meet_beyond", lambda *_: True)
    again = [run({name: row[name] for name in ("kind", "number")}) for row in crossing[:6]]
    assert any(row["itself"] != ["edge_not_found", "barrier_hidden"] for row in again)
