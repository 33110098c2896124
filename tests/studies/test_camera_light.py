"""What is claimed of pictures as cameras send them, with a response that nobody tells; bounds are 1.3 times that."""

import json

import pytest

from studies.__main__ import RESULTS

LEAST_INSIDE = 0.93
LEAST_TRUST = 50


@pytest.fixture(scope="module")
def study():
    return json.loads((RESULTS / "camera_light.json").read_text(encoding="utf-8"))


def test_as_many_rigs_were_drawn_as_is_said(study):
    assert study["summary"]["rigs"] >= 300


def test_errors_are_as_small_as_claimed_and_far_smaller_than_without_luma_and_measured_response(study):
    found = study["summary"]["all"]
    assert abs(found["bias_mm"]) <= 0.05
    assert found["rmse_mm"] <= 1.3 * 0.13 < found["before"]["rmse_mm"]
    assert study["summary"]["h264 crf 28"]["rmse_mm"] <= 0.25


def test_the_interval_holds_in_every_coding_and_did_not_before(study):
    codings = [found for found in study["summary"].values() if isinstance(found, dict)]
    assert all(found["covered"] >= LEAST_INSIDE for found in codings)
    assert all(found["before"]["covered"] < LEAST_INSIDE for found in codings)
    assert study["summary"]["all"]["covered_by_half_of_it"] < LEAST_INSIDE


def test_a_large_error_is_not_trusted(study):
    values = [one for row in study["rows"] for one in row["codings"].values() if one.get("error_mm") is not None]
    assert max(abs(one["error_mm"]) for one in values if one["trust"] >= LEAST_TRUST) <= 1.3 * 0.38


def test_the_measured_response_moves_an_edge_by_as_little_as_claimed(study):
    response = study["summary"]["all"]["response"]
    assert response["half_level_rmse_px"] <= 0.02
    assert response["covered"] >= LEAST_INSIDE
    assert response["wrong_responses_named"] >= 0.95 * response["wrong_responses"]
