"""Pictures that show no bar to be measured, or not what the rig was calibrated for: no value, or a right one."""

import cv2
import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.simulation.bars.study_scenes import draw
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.tangent.gauge import TangentGauge

SEEDS = (20_001, 20_002)


def blurred(picture, sigma_px):
    return cv2.GaussianBlur(picture, (0, 0), sigma_px)


def brighter(picture, factor):
    return np.clip(picture * float(factor), 0, 255).astype(np.uint8)


CASES = {
    "swapped": lambda left, right, _end: (right, left),
    "blurred": lambda left, right, _end: (blurred(left, 6), blurred(right, 6)),
    "overexposed": lambda left, right, _end: (brighter(left, 6), brighter(right, 6)),
    "one view empty": lambda left, right, _end: (left, np.full_like(right, 20)),
    "one view of a bar that leaves": lambda _left, right, end: (end[0], right),
    "left frozen while the bar moved across": lambda left, right, _end: (left, np.roll(right, 40, axis=1)),
}


@pytest.fixture(scope="module", params=SEEDS)
def seen(request):
    clean, end = draw("clean", request.param), draw("bar-end", request.param)
    gauge = TangentGauge(perfect_rig(clean.rig, clean.response), 0.0)
    return gauge, clean, (end.left, end.right)


def is_wrong(reading: SizeReading, truth_mm: float) -> bool:
    return reading.valid and abs(reading.diameter_mm - truth_mm) > max(2 * reading.expanded_uncertainty_mm, 1.0)


@pytest.mark.parametrize("case", CASES)
def test_no_wrong_value_is_served(seen, case):
    gauge, clean, end = seen
    reading = gauge.measure(*CASES[case](clean.left, clean.right, end))
    assert not is_wrong(reading, clean.truth["diameter_mm"])
    assert reading.valid or reading.reasons.forbids_value


@pytest.mark.parametrize("condition", ["no-bar", "one-blind", "two-bars"])
def test_a_frame_without_a_measurable_bar_is_served_as_no_value(seen, condition):
    gauge, clean, _ = seen
    scene = draw(condition, clean.truth["seed"])
    assert not gauge.measure(scene.left, scene.right).valid


def test_a_foreign_rig_serves_nothing_wrong():
    clean, other = (draw("clean", seed) for seed in SEEDS)
    gauge = TangentGauge(perfect_rig(other.rig, clean.response), 0.0)
    assert not is_wrong(gauge.measure(clean.left, clean.right), clean.truth["diameter_mm"])


def test_a_bar_that_covers_less_than_half_of_the_region_is_too_short():
    # an end of a bar moves through the region; where it covers half of it, the value ends
    for seed in range(20_010, 20_013):
        scene = draw("bar-end", seed)
        covered = scene.truth["bars"][0]["covered_part"]
        reading = TangentGauge(perfect_rig(scene.rig, scene.response), 0.0).measure(scene.left, scene.right)
        assert reading.valid == (covered >= 0.5) or abs(covered - 0.5) < 0.02
        assert not (reading.valid and covered < 0.98) or reading.reasons & (Reason.BAR_HEAD | Reason.BAR_TAIL)
