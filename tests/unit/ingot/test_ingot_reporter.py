"""What the ingot station reports after its camera was away."""

import numpy as np
import pytest

from appliance.cameras.source import Frame
from appliance.ingot.reporter import UNSEEN_S, IngotReporter
from appliance.ingot.settings import IngotSettings
from vision.readings import OrientationReading

RATE_HZ = 5.0


def report(reporter: IngotReporter, number: int, at_s: float, log_odds: float, center_x: float = 400.0):
    picture = np.zeros((1, 1), np.uint8)
    frame = Frame(picture, sequence=number, exposed_monotonic_s=at_s, exposed_utc_ms=0)
    end = {"center_x": center_x, "center_y": 300.0, "radius": 40.0}
    orientation = "top" if log_odds > 0 else "bottom"
    seen = OrientationReading(
        present=True, orientation=orientation, log_odds=log_odds, ssim_top=0.5, ssim_bottom=0.5, **end
    )
    return reporter.report(frame, seen, 4.0, dropped=0, simulated=True)


@pytest.mark.parametrize(("away_s", "another"), [(20.0, True), (UNSEEN_S + 0.5, True), (0.5, False)])
def test_an_ingot_that_came_while_the_camera_was_away_does_not_inherit_the_verdict_of_the_one_before(away_s, another):
    reporter = IngotReporter(IngotSettings())
    for number in range(12):
        message = report(reporter, number, number / RATE_HZ, log_odds=-8.0)
    assert message.current.orientation == "bottom"
    begun_s = 12 / RATE_HZ + away_s
    for number in range(12, 24):
        message = report(reporter, number, begun_s + (number - 12) / RATE_HZ, log_odds=+8.0, center_x=406.0)
    assert (message.current.orientation == "top") is another
    assert message.current.ingot == (2 if another else 1)
