"""Which windows are discarded, for Sigmas that are known."""

import numpy as np
import pytest

from vision.sizing.virtual_board.weighted_deviation import trusted_windows


@pytest.mark.parametrize("sigma_mm", [0.0, 1e-9, 0.05])
def test_windows_that_are_all_alike_are_all_kept(sigma_mm):
    assert trusted_windows(np.full(20, sigma_mm)).all()


@pytest.mark.parametrize(("factor", "kept"), [(2.4, True), (2.6, False)])
def test_among_like_windows_one_may_be_two_and_a_half_times_as_uncertain(factor, kept):
    sigma_mm = np.full(20, 0.05)
    sigma_mm[3] *= factor
    trusted = trusted_windows(sigma_mm)
    assert trusted[3] == kept
    assert trusted.sum() == 19 + kept


def test_a_window_without_a_diameter_is_not_trusted_and_alone_none_is():
    assert trusted_windows(np.array([0.05, np.nan, 0.05])).tolist() == [True, False, True]
    assert not trusted_windows(np.full(5, np.nan)).any()
