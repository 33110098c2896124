"""Scores of boundaries against people's, on cases counted by hand."""

import numpy as np
import pytest
from edge_evaluation import THRESHOLDS, boundary_counts, boundary_scores, limb_rows, matched
from scipy import sparse
from scipy.sparse.csgraph import maximum_bipartite_matching

SHAPE = (300, 400)  # diagonal 500, so an edge may lie 3.75 pixels from a boundary


def line(column: int, first: int = 0, last: int = 300) -> np.ndarray:
    picture = np.zeros(SHAPE, bool)
    picture[first:last, column] = True
    return picture


def scores(strength: np.ndarray, *boundaries: np.ndarray):
    return boundary_scores([boundary_counts(strength.astype(np.float32), boundaries)])


def test_the_rule_has_33_thresholds_inside_0_and_1():
    assert len(THRESHOLDS) == 33
    assert np.diff(THRESHOLDS) == pytest.approx(THRESHOLDS[0])
    assert THRESHOLDS[-1] == pytest.approx(1 - THRESHOLDS[0])


def test_an_edge_within_reach_counts_and_one_beyond_does_not():
    assert scores(line(103), line(100)).ods == 1
    assert scores(line(104), line(100)).ods == 0


def test_a_boundary_pixel_pays_for_one_edge_pixel_only():
    double = line(99) | line(101)
    counts = boundary_counts(double.astype(np.float32), [line(100)])
    assert counts.found[0] == 600
    assert counts.found_right[0] == 300
    assert counts.wanted_found[0] == 300
    assert scores(double, line(100)).ods == pytest.approx(2 / 3)


def test_greedy_pairs_would_lose_a_partner_that_the_matching_finds():
    one, other = np.zeros((2, 1, 12), bool)
    one[0, [3, 6]] = True  # 3 reaches 0 and 5, 6 reaches 5 only
    other[0, [0, 5]] = True
    of_one, of_other = matched(one, other, 3.0)
    assert of_one.sum() == of_other.sum() == 2


@pytest.mark.parametrize("seed", range(5))
def test_as_many_find_a_partner_as_with_another_algorithm(seed):
    one, other = np.random.default_rng(seed).random((2, 40, 50)) < 0.15
    places = [np.argwhere(mask) for mask in (one, other)]
    near = np.linalg.norm(places[0][:, None] - places[1], axis=2) <= 2.5
    partners = maximum_bipartite_matching(sparse.csr_array(near), perm_type="column")
    of_one, of_other = matched(one, other, 2.5)
    assert of_one.sum() == of_other.sum() == np.count_nonzero(partners >= 0)
    assert not (of_one & ~one).any()
    assert not (of_other & ~other).any()


def test_an_edge_that_one_person_saw_is_right_and_each_persons_boundary_is_wanted():
    counts = boundary_counts(line(100).astype(np.float32), [line(100), line(300)])
    assert counts.found_right[0] == counts.found[0] == 300
    assert counts.wanted[0] == 600
    assert counts.wanted_found[0] == 300


def test_thick_edges_are_thinned_before_they_are_counted():
    thick = line(99) | line(100) | line(101)
    counts = boundary_counts(thick.astype(np.float32), [line(100)])
    assert counts.found[0] <= 302


def test_one_threshold_for_all_is_worse_than_one_for_each_when_pictures_differ():
    weak_truth = 0.3 * line(100) + 0.2 * line(300)
    strong_truth = 0.8 * line(100) + 0.5 * line(300)
    pictures = [boundary_counts(p.astype(np.float32), [line(100)]) for p in (weak_truth, strong_truth)]
    both = boundary_scores(pictures)
    assert both.ois == 1
    assert both.ods == pytest.approx(2 * (2 / 3) / (1 + 2 / 3))  # three lines of which two are right, all found
    assert both.ods_threshold < 0.3


def test_average_precision_is_the_area_under_the_curve():
    fading = np.linspace(0.01, 0.99, 300)[:, None]
    assert scores(fading * line(100), line(100)).ap == pytest.approx(1.0, abs=0.05)
    assert scores(fading * line(100, 150, 300), line(100)).ap == pytest.approx(0.5, abs=0.05)
    assert scores(fading * (line(100) | line(300)), line(100)).ap == pytest.approx(0.5, abs=0.05)


def test_limbs_are_found_within_a_pixel_and_placed_between_pixels():
    x = np.arange(60.0)
    limbs = np.array([[20.3] * 50, [40.6] * 50])
    strength = np.stack([0.8 * np.exp(-((x - 20.1) ** 2) / 4) + 0.5 * np.exp(-((x - 41.0) ** 2) / 4)] * 50)
    strength[7, 30] = 0.3  # inside the bar
    suppressed = np.where((x == 20) | (x == 41), strength, 0)
    suppressed[7, 30] = 0.3
    suppressed[9] = 0
    suppressed[9, 22] = 0.9  # too far from the limb to be it, too near to count as false
    rows = limb_rows(strength.astype(np.float32), suppressed.astype(np.float32), limbs)
    assert rows.found[:, 0] == pytest.approx([0.8, 0.5], abs=0.01)
    assert rows.offset_px[:, 0] == pytest.approx([-0.2, 0.4], abs=0.02)
    assert rows.found[0, 9] == 0
    assert rows.near[0, 9] == pytest.approx(0.9)
    assert np.isnan(rows.offset_px[0, 9])
    assert np.flatnonzero(rows.false).tolist() == [7]
