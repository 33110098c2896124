"""No wrong value in more than 1,000 frames without a measurable bar, and what this rests on can fail."""

import json

import numpy as np
import pytest

from studies.__main__ import RESULTS
from studies.no_measurable_bar import run
from studies.served_diameter import is_wrong
from vision.sizing.region_grid import Outline, RegionGrid

DRAWN_AGAIN = [{"case": name, "seed": seed} for name in ("no bar", "two bars") for seed in (500, 501)]


@pytest.fixture(scope="module")
def rows():
    return json.loads((RESULTS / "no_measurable_bar.json").read_text(encoding="utf-8"))["rows"]


def test_no_value_of_a_frame_without_a_measurable_bar_is_wrong(rows):
    assert len(rows) >= 1000
    assert not [row for row in rows if is_wrong(row)]


def test_whatever_is_no_value_says_why(rows):
    assert all(row["reasons"] for row in rows if not row["valid"])


def test_a_frame_with_nothing_to_measure_is_served_as_no_value():
    assert not any(run(case)["valid"] for case in DRAWN_AGAIN)


def test_a_mask_that_always_says_that_there_is_one_bar_gives_wrong_values(monkeypatch):
    found = RegionGrid.bars

    def one_bar(grid, image, decode):
        return found(grid, image, decode)[:1] or [Outline(np.array([0.0, -90.0]), np.array([0.0, 90.0]))]

    monkeypatch.setattr(RegionGrid, "bars", one_bar)
    assert any(is_wrong(run(case)) for case in DRAWN_AGAIN)


def test_frozen_pictures_would_be_measured_if_nobody_looked_whether_they_live(rows):
    assert "wrong" in {row["gauge_alone"] for row in rows if row["case"] == "frozen"}
