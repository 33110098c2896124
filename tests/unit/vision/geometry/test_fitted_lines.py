"""Lines through points of which many lie elsewhere: the line that was drawn is found, far from the origin too."""

import numpy as np
import pytest

from vision.geometry.consensus_line import consensus_line
from vision.geometry.robust_line import robust_line

ROWS = np.linspace(300.0, 700.0, 81)


@pytest.mark.parametrize(("slope", "intercept"), [(0.2, 40.0), (-0.35, 900.0), (0.0, 10.0)])
def test_the_line_on_which_two_points_of_five_agree_is_found_and_the_points_are_named(slope, intercept):
    chance = np.random.default_rng(1)
    column = slope * ROWS + intercept + chance.uniform(-0.2, 0.2, ROWS.size)
    wrong = chance.permutation(ROWS.size) < 0.6 * ROWS.size
    column[wrong] += chance.choice([-1, 1], wrong.sum()) * chance.uniform(20, 200, wrong.sum())
    line, agrees = consensus_line(ROWS, column, 0.5)
    assert line[0] == pytest.approx(slope, abs=1e-3)
    assert line[0] * 500 + line[1] == pytest.approx(slope * 500 + intercept, abs=0.1)
    assert np.array_equal(agrees, ~wrong)


def test_of_fewer_than_two_points_there_is_no_line():
    for count in (0, 1):
        line, agrees = consensus_line(ROWS[:count], ROWS[:count], 0.5)
        assert np.isnan(line).all()
        assert not agrees.any()


@pytest.mark.parametrize(("slope", "start"), [(0.2, 40.0), (-0.35, 900.0)])
def test_a_fifth_of_wrong_points_bends_no_line(slope, start):
    chance = np.random.default_rng(2)
    column = slope * ROWS + start + chance.normal(0, 0.1, ROWS.size)
    column[chance.permutation(ROWS.size) < ROWS.size // 5] += 30.0
    line = robust_line(ROWS, column)
    assert line[0] == pytest.approx(slope, abs=1e-3)
    assert line[0] * 500 + line[1] == pytest.approx(slope * 500 + start, abs=0.1)
