"""Route T on simulated scenes with known truth, each with its own rig and bar.

The rig is the true one here, so what remains is the gauge's own error; calibrated rigs follow in
`test_calibrated_gauge.py`.
"""

import numpy as np
import pytest
from mill_scenes import perfect_rig, random_bar

from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.bars.silhouette import Glow
from appliance.simulation.sensor import Sensor
from appliance.simulation.true_rig import random_rig
from vision.sizing.tangent.gauge import TangentGauge

SEEDS = range(100, 112)


def errors_mm(glow, response="srgb", believed=None):
    readings = []
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        true_rig, bar = random_rig(rng), random_bar(rng)
        pair = Scene(true_rig, seed, sensor=Sensor(response=response), glow=glow).pair(bar, 0)
        reading = TangentGauge(perfect_rig(true_rig, believed or response), 0.0).measure(*pair)
        readings.append((reading.diameter_mm - bar.diameter_mm, reading.expanded_uncertainty_mm))
    return np.array(readings).T


@pytest.mark.parametrize("response", ["srgb", "gamma 2.2", "linear"])
def test_an_evenly_glowing_bar_is_measured_without_bias(response):
    error, _ = errors_mm(Glow(limb_darkening=0.0, unevenness=0.0), response)
    assert abs(error.mean()) < 3 * error.std() / np.sqrt(error.size) + 0.002
    assert np.sqrt(np.mean(error**2)) < 0.01


def test_a_bar_that_is_darker_at_its_limbs_and_on_one_side_stays_within_its_uncertainty():
    error, expanded = errors_mm(Glow())
    assert np.sqrt(np.mean(error**2)) < 0.1
    assert np.all(np.abs(error) <= expanded)


def test_a_response_that_is_not_decoded_makes_bars_too_large():
    error, _ = errors_mm(Glow(), "gamma 2.2", believed="linear")
    assert error.mean() > 0.5
