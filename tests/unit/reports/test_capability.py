"""Control charts and capability against a textbook, a handbook and integrals; intervals against many simulated mills.

D. C. Montgomery, Introduction to Statistical Quality Control, 7th edition, and NIST/SEMATECH e-Handbook, section 6.1.6.
"""

import random
import statistics

import pytest
from scipy import integrate

from appliance.reports.capability import capability, centred_interval, nearest_interval
from appliance.reports.control_chart import MEAN_RANGE_D2, RANGE_DEVIATION_D3, control_chart, limits, subgroups


def test_the_constants_are_moments_of_the_range_of_five_normal_numbers():
    pdf, cdf = statistics.NormalDist().pdf, statistics.NormalDist().cdf

    def at_most(width):  # P(range <= width), from the density of the smallest
        return integrate.quad(lambda x: 5 * pdf(x) * (cdf(x + width) - cdf(x)) ** 4, -8, 8)[0]

    mean = integrate.quad(lambda width: 1 - at_most(width), 0, 10)[0]
    square = integrate.quad(lambda width: 2 * width * (1 - at_most(width)), 0, 10)[0]
    assert pytest.approx(mean, abs=1e-5) == MEAN_RANGE_D2
    assert pytest.approx((square - mean**2) ** 0.5, abs=1e-5) == RANGE_DEVIATION_D3


def test_limits_are_those_of_montgomerys_example_6_1():
    """Flow width of resist, 25 samples of five: grand mean 1.5056, mean range 0.32521 micrometres."""
    center, lower, upper, range_center, range_upper = limits(1.5056, 0.32521)
    assert (center, range_center) == (1.5056, 0.32521)
    assert (lower, upper) == (pytest.approx(1.31795, abs=2e-4), pytest.approx(1.69325, abs=2e-4))
    assert range_upper == pytest.approx(0.68749, abs=3e-4)


def test_the_interval_of_cp_is_that_of_montgomerys_example_8_4():
    """20 parts, Cp 2.29: 1.57 to 3.01."""
    assert centred_interval(2.29, 19) == pytest.approx((2.29, 1.57, 3.01), abs=0.006)


def test_the_interval_of_cpk_is_that_of_montgomerys_example_8_5():
    """20 parts, Cpk 1.33: 1.33 (1 -+ 1.96 sqrt(1 / (9 20 1.33^2) + 1 / (2 19)))."""
    half = 1.33 * 1.96 * (1 / (9 * 20 * 1.33**2) + 1 / (2 * 19)) ** 0.5
    assert nearest_interval(1.33, 20, 19) == pytest.approx((1.33, 1.33 - half, 1.33 + half), abs=1e-4)


def test_cp_and_cpk_within_subgroups_are_those_of_montgomerys_example_6_1():
    """The same resist, limits 1.50 -+ 0.50: sigma 0.1398, Cp 1.192; Cpk by its definition is 1.179."""
    shape = with_mean_and_deviation(125, 0.0, 1.0)
    scale = 0.32521 / statistics.fmean(max(group) - min(group) for group in subgroups(shape))
    found = capability([0.0056 + scale * number for number in shape], plus_mm=0.5, minus_mm=0.5)
    assert found.within_mm == pytest.approx(0.1398, abs=5e-5)
    assert found.cp.value == pytest.approx(1.192, abs=1e-3)
    assert found.cpk.value == pytest.approx((2.00 - 1.5056) / (3 * 0.1398), abs=1e-3)


def with_mean_and_deviation(count: int, mean: float, deviation: float) -> list[float]:
    """Numbers of exactly this mean and standard deviation (n - 1)."""
    source = random.Random(3)
    numbers = [source.gauss(0, 1) for _ in range(count)]
    middle = sum(numbers) / count
    spread = (sum((number - middle) ** 2 for number in numbers) / (count - 1)) ** 0.5
    return [mean + deviation * (number - middle) / spread for number in numbers]


def test_indices_are_those_of_the_nist_handbook():
    """Limits 8 and 20, mean 16, s 2: Cp 1.0, Cpk 0.6667 (section 6.1.6); the target is 14 here."""
    found = capability(with_mean_and_deviation(50, 2.0, 2.0), plus_mm=6, minus_mm=6)
    assert found.pp.value == pytest.approx(1.0)
    assert found.ppk.value == pytest.approx(0.6667, abs=1e-4)
    assert found.bars == 50


def test_drift_lowers_what_was_delivered_and_not_what_the_process_can_do():
    source = random.Random(5)
    still = [source.gauss(0, 0.3) for _ in range(500)]
    drifting = [number + k / 250 - 1 for k, number in enumerate(still)]
    one, other = capability(still, 2, 2), capability(drifting, 2, 2)
    assert one.pp.value == pytest.approx(one.cp.value, rel=0.1)
    assert other.cp.value == pytest.approx(one.cp.value, rel=0.03)
    assert other.pp.value < 0.6 * one.pp.value


@pytest.mark.parametrize("name", ["cp", "cpk", "pp", "ppk"])
def test_intervals_hold_the_true_index_in_95_of_100_simulated_shifts(name):
    mean, deviation, tolerance = 0.4, 0.5, 2.0
    true = tolerance / (3 * deviation) if name in {"cp", "pp"} else (tolerance - mean) / (3 * deviation)
    source = random.Random(11)
    shifts = 600
    held = 0
    for _ in range(shifts):
        index = getattr(capability([source.gauss(mean, deviation) for _ in range(60)], tolerance, tolerance), name)
        held += index.low <= true <= index.high
    assert held / shifts == pytest.approx(0.95, abs=0.025)


def test_too_few_bars_and_bars_without_spread_have_no_index():
    assert capability([0.1] * 9, 2, 2) is None
    assert capability([0.1] * 50, 2, 2) is None
    assert control_chart(subgroups([0.1] * 9)) is None


def test_points_beyond_a_limit_are_found_each_in_its_chart():
    source = random.Random(2)
    groups = [[source.gauss(0, 1) for _ in range(5)] for _ in range(30)]
    groups[7] = [5.0, 5.1, 5.2, 4.9, 5.0]
    groups[11] = [-5.0, 5.0, 0.0, 0.0, 0.0]
    chart = control_chart(groups)
    assert chart.means_outside == [7]
    assert chart.ranges_outside == [11]
