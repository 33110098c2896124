"""In 10,000 frames nothing that was seen before makes a value that a search of the frame alone would refuse."""

import json

import pytest
from calibrated_rigs import rig_with_marks

from studies.__main__ import RESULTS
from studies.frames_before import FRAMES, alone, compared, shown
from vision.sizing.gauge import Gauge
from vision.sizing.region_grid import RegionGrid

SEED = 701


@pytest.fixture(scope="module")
def rows():
    return json.loads((RESULTS / "frames_before.json").read_text(encoding="utf-8"))["rows"]


def test_no_frame_before_makes_a_value_that_a_search_refuses_or_another_value(rows):
    assert FRAMES * len(rows) >= 10_000
    assert sum(row["values"] for row in rows) >= 5_000
    assert not any(row["values_that_a_search_refuses"] or row["values_that_are_missed"] for row in rows)
    assert max(row["apart_mm"] for row in rows) == 0.0


def test_a_gauge_that_looked_only_where_the_bar_was_would_serve_values_that_a_search_refuses(monkeypatch):
    names = ("clean", "swapped")
    searched = [alone(SEED, name) for name in names]
    found, kept = RegionGrid.bars, {}

    def tracked(grid, image, decode):
        return kept.setdefault(grid, found(grid, image, decode))

    monkeypatch.setattr(RegionGrid, "bars", tracked)
    running = Gauge(rig_with_marks(SEED), 0.0)
    readings = [(running.measure(*shown(SEED, name)), other) for name, other in zip(names, searched, strict=True)]
    assert readings[0][0].valid
    assert compared(readings)["values_that_a_search_refuses"] == 1
