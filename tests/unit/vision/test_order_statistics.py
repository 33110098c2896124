"""Medians and quantiles against numpy's, bit by bit."""

import math

import numpy as np
import pytest

from vision.order_statistics import column_medians, median, median_without_nan, quantiles

COUNTS = (1, 2, 3, 4, 5, 16, 85, 341, 2048)


@pytest.mark.parametrize("count", COUNTS)
def test_medians_are_numpys(count):
    values = np.random.default_rng(count).normal(size=(count, 7))
    assert median(values[:, 0]) == np.median(values[:, 0])
    assert median(values) == np.median(values)
    assert np.array_equal(column_medians(values), np.median(values, axis=0))


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("share", [0.0, 0.25, 0.4, 0.5, 0.9, 1.0])
def test_quantiles_are_numpys(count, share):
    rng = np.random.default_rng(count)
    values, codes = rng.normal(size=count), rng.integers(0, 256, (count, 3), np.uint8)
    assert quantiles(values, (share,)) == [np.quantile(values, share)]
    middle, wanted = quantiles(codes, (0.5, share))
    assert np.array_equal(middle, np.median(codes, axis=0))
    assert np.array_equal(wanted, np.quantile(codes, share, axis=0))


def test_nan_is_passed_on_or_left_out():
    values = np.array([[3.0, 1.0], [np.nan, 2.0], [1.0, 4.0]])
    assert math.isnan(median(values[:, 0]))
    assert np.array_equal(column_medians(values), [np.nan, 2.0], equal_nan=True)
    assert median_without_nan(values[:, 0]) == 2.0
    assert median_without_nan(values) == 2.0


def test_without_any_number_a_median_is_nan():
    assert math.isnan(median(np.empty(0)))
    assert math.isnan(median_without_nan(np.full(3, np.nan)))


def test_a_share_of_a_black_background_is_infinite_and_raises_nothing():
    with np.errstate(divide="ignore"):
        assert median(np.full(5, 0.4)) / median(np.zeros(5)) == np.inf
