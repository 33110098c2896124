"""How far what readings do not share averages out: against drawn series, and one rule for both means."""

import math

import numpy as np
import pytest

from vision.readings import SizeReading
from vision.sizing.correlated_mean import mean_variance_factor, own_uncertainty_mm


def series(rng, count, correlation):
    """First-order autoregressions of unit variance, shape (1000, count)."""
    drawn = rng.normal(size=(1000, count))
    for place in range(1, count):
        drawn[:, place] = correlation * drawn[:, place - 1] + math.sqrt(1 - correlation**2) * drawn[:, place]
    return drawn


@pytest.mark.parametrize(("correlation", "count"), [(0.0, 12), (0.4, 40), (0.7, 40), (0.7, 200)])
def test_the_factor_is_that_of_drawn_series(correlation, count):
    drawn = series(np.random.default_rng(1), count, correlation)
    away = drawn - drawn.mean(axis=1, keepdims=True)
    neighbours = np.sum(away[:, 1:] * away[:, :-1], axis=1) / np.sum(away**2, axis=1)
    typical = np.median([mean_variance_factor(float(one), count) for one in neighbours])
    assert typical == pytest.approx(count * drawn.mean(axis=1).var(), rel=0.1)


@pytest.mark.parametrize("neighbours", [-1.0, 0.0, 1.0])
def test_alternating_values_gain_nothing_and_equal_ones_lose_no_more_than_all_of_their_number(neighbours):
    assert 1.0 <= mean_variance_factor(neighbours, 10) <= 10


def test_a_method_that_states_no_motion_has_the_uncertainty_of_its_edges():
    assert own_uncertainty_mm(SizeReading(u_edge_mm=0.03, u_motion_mm=0.04)) == pytest.approx(0.05)
    assert own_uncertainty_mm(SizeReading(u_edge_mm=0.03)) == 0.03
