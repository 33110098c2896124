"""A rig calibrated from pictures of boards and one calibrated from projected corners measure the same."""

import json

import numpy as np
import pytest

from studies.__main__ import RESULTS
from studies.rendered_boards import CONDITIONS


@pytest.fixture(scope="module")
def rows():
    return json.loads((RESULTS / "rendered_boards.json").read_text(encoding="utf-8"))["rows"]


@pytest.mark.parametrize("condition", CONDITIONS)
def test_both_calibrations_agree_within_their_uncertainties(rows, condition):
    assert len(rows) >= 12
    in_u = np.array([row[f"{condition}_difference_mm"] / row[f"{condition}_u_difference_mm"] for row in rows])
    assert np.sqrt(np.mean(in_u**2)) < 1 + 2 / np.sqrt(2 * len(in_u))  # 1 within two of its standard errors
    assert np.abs(in_u).max() < 3.5


@pytest.mark.parametrize("condition", CONDITIONS)
def test_values_of_a_rig_from_pictures_are_covered(rows, condition):
    covered = [abs(row[f"{condition}_error_rendered_mm"]) <= row[f"{condition}_expanded_rendered_mm"] for row in rows]
    assert np.mean(covered) >= 0.8


@pytest.mark.parametrize(("condition", "rmse_mm", "worst_mm"), [("clean", 0.059, 0.12), ("scale", 0.085, 0.15)])
def test_errors_of_a_rig_from_pictures_are_as_small_as_claimed(rows, condition, rmse_mm, worst_mm):
    error_mm = np.array([row[f"{condition}_error_rendered_mm"] for row in rows])
    assert np.sqrt(np.mean(error_mm**2)) <= 1.3 * rmse_mm
    assert np.abs(error_mm).max() <= 1.3 * worst_mm
