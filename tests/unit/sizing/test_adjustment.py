"""A known error is taken off every value, visibly, and only with all that an auditor asks for."""

import math
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from appliance.sizing.adjustment import Adjustment
from appliance.sizing.published import PUBLISHED
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.passing_bar import PassingBar

WHOLE = {"added_mm": 0.2, "expanded_mm": 0.06, "date": "2026-11-28", "reason": "master 250.00", "who": "A. Smith"}
WHOLE |= {"calibration_sha256": "5e" * 32}
PARTS = {"u_edge_mm": 0.03, "u_calibration_mm": 0.0, "u_board_mm": 0.0, "u_light_mm": 0.0, "u_shape_mm": 0.0}
MEASURED = SizeReading(diameter_mm=249.8, expanded_uncertainty_mm=0.1, u_model_mm=0.04, **PARTS)


def test_diameter_uncertainty_and_reasons_show_it():
    reading = Adjustment(**WHOLE).adjusted(MEASURED)
    assert reading.diameter_mm == pytest.approx(250.0)
    assert reading.expanded_uncertainty_mm == pytest.approx(math.hypot(0.1, 0.06))
    assert reading.reasons == Reason.ADJUSTED
    assert reading.valid


def test_u_stays_twice_the_root_sum_of_squares_of_its_parts():
    reading = Adjustment(**WHOLE).adjusted(MEASURED)
    parts = math.hypot(*(getattr(reading, name) for name in (*PARTS, "u_model_mm")))
    assert reading.expanded_uncertainty_mm == pytest.approx(2 * parts)


def test_the_height_over_the_rollers_does_not_change_with_it():
    lying = replace(MEASURED, axis_height_mm=MEASURED.diameter_mm / 2 + 1.5)
    assert PUBLISHED["hop_height"](Adjustment(**WHOLE).adjusted(lying)) == pytest.approx(1.5)


def test_the_mean_of_a_section_that_turns_has_it_too():
    bars = [(Adjustment(), PassingBar()), (Adjustment(**WHOLE), PassingBar())]
    views_rad = np.deg2rad([-20, 20])
    for frame, angle_rad in enumerate(np.deg2rad(np.linspace(0, 500, 40))):
        left, right = 249.8 + 0.4 * np.cos(angle_rad + 2 * views_rad)
        one = replace(MEASURED, diameter_mm=(left + right) / 2, width_left_mm=left, width_right_mm=right)
        plain, adjusted = (bar.add(known.adjusted(one), 0.04 * frame) for known, bar in bars)
    assert plain.bar_diameter_mm == pytest.approx(249.8, abs=0.01)
    assert adjusted.bar_diameter_mm - plain.bar_diameter_mm == pytest.approx(0.2)
    assert adjusted.bar_ovality_mm == pytest.approx(plain.bar_ovality_mm)
    assert adjusted.bar_ovality_mm == pytest.approx(0.8, abs=0.02)


def test_a_reading_without_a_value_and_an_adjustment_of_nothing_change_nothing():
    empty = SizeReading(reasons=Reason.NO_BAR)
    assert Adjustment(**WHOLE).adjusted(empty) is empty
    assert Adjustment().adjusted(MEASURED) is MEASURED


@pytest.mark.parametrize("missing", ["expanded_mm", "date", "reason", "who", "calibration_sha256"])
def test_an_adjustment_that_does_not_say_all_is_refused(missing):
    with pytest.raises(ValidationError, match=missing):
        Adjustment(**{name: value for name, value in WHOLE.items() if name != missing})


def test_a_date_that_is_none_is_refused():
    with pytest.raises(ValidationError, match="date"):
        Adjustment(**WHOLE | {"date": "yesterday"})


@pytest.mark.parametrize("digest", ["5e", "5E" * 32, "not a digest"])
def test_a_calibration_that_is_no_digest_is_refused(digest):
    with pytest.raises(ValidationError, match="calibration_sha256"):
        Adjustment(**WHOLE | {"calibration_sha256": digest})


@pytest.mark.parametrize(("digest", "refused"), [("5e" * 32, False), ("6e" * 32, True), ("", True)])
def test_it_counts_with_the_calibration_that_it_was_found_with_and_no_other(digest, refused):
    assert bool(Adjustment(**WHOLE).refusal(digest)) == refused
    assert not Adjustment().refusal(digest)
