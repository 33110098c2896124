"""Algorithms 8, 9 and 10 on boundaries that are drawn by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.cluster.vq import kmeans2
from skimage.filters import threshold_otsu

from vision.edges.binary import denoised
from vision.edges.operators import detect_edges
from vision.edges.thinning import ridges
from vision.geometry.robust_line import robust_line
from vision.sizing.virtual_board import aligned_pair
from vision.sizing.virtual_board.aligned_pair import AlignedPair
from vision.sizing.virtual_board.boundaries_of_interest import boundaries_of_interest, hot_mask
from vision.sizing.virtual_board.parameters import PRINTED_PARAMETERS, SERVED_PARAMETERS, Parameters
from vision.sizing.virtual_board.random_regression import (
    RandomLines,
    WindowPoints,
    random_regression,
    two_sides,
    windowed,
)
from vision.sizing.virtual_board.weighted_deviation import (
    similarity_ratio,
    trusted_windows,
    weighted_deviation,
    window_statistics,
)

RNG = np.random.default_rng(3)


def bar_picture(noise=2.0):
    """A bright upright bar, columns 40 to 99, on a dark ground with one faint stripe."""
    picture = np.full((80, 160), 20.0)
    picture[:, 40:100] = 200.0
    picture[:, 130:134] = 35.0
    return np.clip(picture + RNG.normal(0, noise, picture.shape), 0, 255).astype(np.uint8)


def test_the_mask_holds_the_bar_and_not_the_background():
    mask = hot_mask(bar_picture())
    assert mask[:, 40:100].all()
    assert not mask[:, 110:].any()


@pytest.mark.parametrize("method", ["forest", "sobel", "prewitt", "roberts", "canny"])
def test_the_boundaries_enclose_the_bar_s_two_edges_and_nothing_else(method):
    picture = bar_picture()
    found = boundaries_of_interest(picture, hot_mask(picture), method)
    columns = np.flatnonzero(found.band[10:-10].mean(axis=0) > 0.9)
    assert {39, 40} & set(columns)
    assert {99, 100} & set(columns)
    points = found.traced()
    near = np.minimum(np.abs(points[:, 0] - 39.5), np.abs(points[:, 0] - 99.5))
    assert np.mean(near <= 4) > 0.95


def ramped_picture():
    """Edges of every strength: the step between a dark and a bright half grows from row to row."""
    picture = np.full((80, 160), 20.0)
    picture[:, 40:100] += np.linspace(4, 220, 80)[:, None]
    return picture.astype(np.uint8)


def test_the_higher_beta_the_fewer_edges_and_at_the_served_one_all_above_half_of_otsus_level():
    picture = ramped_picture()
    everywhere = np.ones_like(picture)

    def pixels(beta):
        return int(boundaries_of_interest(picture, everywhere, "sobel", Parameters(beta=beta)).thin.sum())

    counted = [pixels(beta) for beta in (60, 120, 240, 250)]
    assert counted[0] > counted[1] > counted[2] >= counted[3] > 0
    assert counted[2] < 0.85 * counted[1]


@pytest.mark.parametrize("beta", [120.0, 240.0])
def test_beta_is_held_against_strengths_whose_otsu_level_lies_at_240(beta):
    picture = ramped_picture()
    edges = detect_edges((picture / 255).astype(np.float32), "sobel")
    thin = ridges(edges.strength, edges.normal_rad)
    level = threshold_otsu(np.rint(255 * thin[thin > 0] / thin.max()).astype(np.uint8)) / 255 * thin.max()
    kept = boundaries_of_interest(picture, None, "sobel", Parameters(beta=beta, least_neighbours=0)).thin.astype(bool)
    off = 1.5 / 255 * thin.max()  # the level is a code of 256
    assert kept[thin > beta / 240 * level + off].all()
    assert not kept[thin < beta / 240 * level - off].any()


def test_alpha_is_the_factor_on_otsus_threshold_of_the_picture():
    picture = np.full((80, 160), 20, np.uint8)
    picture[:, 40:70], picture[:, 70:100] = 200, 115  # Otsu's threshold is 115: the dimmer half is at it
    areas = [int(hot_mask(picture, alpha).sum()) for alpha in (0.95, 1.1)]
    assert areas[0] > 1.6 * areas[1]


def test_as_printed_specks_of_two_pixels_are_noise_by_algorithm_4_and_the_served_route_keeps_them():
    picture = bar_picture(noise=6.0)
    printed, served = (
        boundaries_of_interest(picture, np.ones_like(picture), "sobel", parameters)
        for parameters in (PRINTED_PARAMETERS, Parameters(beta=PRINTED_PARAMETERS.beta, least_neighbours=1))
    )
    assert np.array_equal(printed.thin.astype(bool), denoised(served.thin.astype(bool)))
    assert SERVED_PARAMETERS.least_neighbours == 1


@pytest.mark.parametrize("wrong", [{"alpha": 0}, {"beta": 0}, {"beta": 256}, {"sample_points": 1}, {"boards": 1}])
def test_a_parameter_out_of_bounds_is_named(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Parameters(**wrong)


def test_a_picture_without_edges_has_no_boundaries():
    picture = np.full((64, 64), 90, dtype=np.uint8)
    found = boundaries_of_interest(picture, np.ones_like(picture), "sobel")
    assert not found.band.any()
    assert found.traced().shape == (0, 2)


def test_k_means_splits_a_window_s_points_into_left_and_right():
    points = np.array([[c + d, r] for r in range(20) for c in (30.0, 90.0) for d in (-1.0, 1.0)])
    first, second = two_sides(windowed(points, 5, 4))
    assert np.nanmax(first.column) == 31.0
    assert np.nanmin(second.column) == 89.0
    assert np.isfinite(first.column).sum() == np.isfinite(second.column).sum() == 40


def test_windows_are_split_as_scipy_s_k_means_does_from_the_outermost_columns():
    rng = np.random.default_rng(8)
    columns = rng.exponential(20, (400, 12))
    rows = np.tile(np.arange(12.0), (400, 1))
    first, second = two_sides(WindowPoints(rows, columns))
    moved = 0
    for window, (column, row) in enumerate(zip(columns, rows, strict=True)):
        points = np.column_stack([column, row])
        start = points[[column.argmin(), column.argmax()]]
        _, label = kmeans2(points, start, iter=20, minit="matrix")
        assert np.isfinite(first.column[window]).tolist() == (label == 0).tolist()
        assert np.isfinite(second.column[window]).tolist() == (label == 1).tolist()
        nearest = np.linalg.norm(points[:, None] - start, axis=-1).argmin(axis=1)
        moved += np.any(nearest != label)
    assert moved > 10


def test_points_below_the_last_whole_window_are_left_out():
    points = np.array([[1.0, row] for row in range(23)])
    assert np.nanmax(windowed(points, 5, 4).row) == 19.0


def test_random_lines_through_points_of_one_line_are_that_line_and_come_again():
    row = np.arange(40.0).reshape(4, 10)
    lines = [random_regression(WindowPoints(row, 0.2 * row + 7), 4, 10, np.random.default_rng(1)) for _ in range(2)]
    assert lines[0].at(row) == pytest.approx(np.broadcast_to((0.2 * row + 7)[:, None], (4, 10, 10)))
    assert np.array_equal(lines[0].slope, lines[1].slope)


def test_a_window_with_too_few_points_has_no_line():
    column = np.full((2, 10), 5.0)
    column[1, 3:] = np.nan
    lines = random_regression(WindowPoints(np.arange(20.0).reshape(2, 10), column), 4, 10, np.random.default_rng(1))
    assert np.isfinite(lines.slope[0]).all()
    assert np.isnan(lines.slope[1]).all()


def test_statistics_and_weights_are_those_of_the_equations():
    sampled = np.array([[100.0, 102.0, 104.0], [50.0, 50.0, 50.0]])
    l_mm, sigma = window_statistics(sampled)
    assert l_mm == pytest.approx([102.0, 50.0])
    assert sigma == pytest.approx([np.sqrt(8 / 3), 0.0])
    ratio = similarity_ratio(np.array([[10.0, 30.0], [5.0, 5.0]]), 10.0)
    assert ratio == pytest.approx([2.0, 0.5])
    assert weighted_deviation(ratio, np.array([1.0, 1.0])) == pytest.approx([4 * np.e, 0.25 * np.exp(-0.5)])


def test_windows_whose_sigma_jumps_are_not_trusted_and_even_ones_all_are():
    sigma = np.append(RNG.uniform(0.9, 1.1, 60), [9.0, np.nan])
    assert trusted_windows(sigma).tolist() == [True] * 60 + [False, False]
    assert trusted_windows(np.full(10, 0.3)).all()
    assert not trusted_windows(np.full(3, np.nan)).any()


def test_how_numbers_were_rounded_discards_no_window():
    sigma = np.full(20, 1e-14)
    sigma[3], sigma[7] = 4e-13, 0.2
    assert np.flatnonzero(~trusted_windows(sigma)).tolist() == [7]


def test_a_third_of_the_points_may_be_off_a_robust_line():
    row = np.arange(90.0)
    column = 0.01 * row + 20 + RNG.normal(0, 0.05, 90)
    column[RNG.permutation(90)[:27]] += 6.0
    slope, start = robust_line(row, column)
    assert slope == pytest.approx(0.01, abs=0.003)
    assert start == pytest.approx(20.0, abs=0.1)


def test_the_width_of_a_window_is_the_mean_over_its_own_rows(monkeypatch):
    """A region of 60 rows and 100 columns in three windows; the second edge moves away by a tenth of a column a row."""
    ones = np.ones((3, 1))
    lines = {"first": RandomLines(0 * ones, 0 * ones), "second": RandomLines(0.1 * ones, 10 * ones)}
    monkeypatch.setattr(aligned_pair, "random_regression", lambda side, *_: lines[side.name])
    sides = [SimpleNamespace(name=name, row=[()] * 3) for name in lines]
    region = np.zeros((60, 100))
    alignment = SimpleNamespace(left=region, right=region, to_plane=lambda _: np.diag([0.5, 0.5, 1.0]))
    height = SimpleNamespace(height_mm=0.0)
    pair = AlignedPair(alignment, height, [SimpleNamespace(sides=sides)], SimpleNamespace())
    width_mm = pair.sampled_widths_mm(0, SERVED_PARAMETERS, RNG)
    assert width_mm[:, 0] == pytest.approx(0.5 * (10 + 0.1 * np.array([9.5, 29.5, 49.5])))
