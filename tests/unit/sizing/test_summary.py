"""The summary that `measure` prints, where values state no uncertainty."""

import math

from appliance.sizing.summary import Summary
from vision.readings import SizeReading
from vision.reasons import Reason


def summary(*expanded_mm):
    told = Summary()
    for number, expanded in enumerate(expanded_mm):
        reading = SizeReading(
            diameter_mm=100.0 + number, expanded_uncertainty_mm=expanded, reasons=Reason.UNCERTAINTY_UNKNOWN
        )
        told.add(reading, None)
    return told.lines("")


def test_u_is_not_known_where_no_value_states_one():
    assert any(line.endswith("mean 100.50 mm; U not known") for line in summary(math.nan, math.nan))


def test_the_median_of_u_is_of_the_values_that_state_one():
    assert any(line.endswith("U 0.30 mm (median)") for line in summary(math.nan, 0.2, 0.3, 0.9))
