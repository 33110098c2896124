"""The gauge between barriers in the codings of cameras: its uncertainty holds in each, and JPEG costs nothing."""

import json

import pytest

from studies.__main__ import RESULTS
from studies.coded_conveyor import KNOWN, NAMES, SEEDS


@pytest.fixture(scope="module")
def summary():
    return json.loads((RESULTS / "coded_conveyor.json").read_text(encoding="utf-8"))["summary"]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("known", KNOWN)
@pytest.mark.parametrize("line", SEEDS)
def test_u_holds_in_every_coding(summary, line, known, name):
    found = summary[f"{line}, {known}"][name]
    assert found["valid"] >= 0.9 * found["lines"]
    assert found["inside"] >= 0.93


@pytest.mark.parametrize("name", ["png 16 bit", "jpeg 4:2:0 q90"])
@pytest.mark.parametrize("known", KNOWN)
@pytest.mark.parametrize("line", SEEDS)
def test_deep_pictures_and_fine_jpeg_are_as_good_as_png(summary, line, known, name):
    found = summary[f"{line}, {known}"][name]
    assert found["worse"] <= 0.01 + 2 * found["u_worse"]
