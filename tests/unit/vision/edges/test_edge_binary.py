"""Binarised edges and their noise, on pictures made by hand."""

import numpy as np
import pytest

from vision.edges.binary import binarised, denoised


def counted_one_by_one(edges):
    """Algorithm 4, written as the source writes it, on a picture with a border of nothing."""
    framed = np.pad(edges, 1)
    kept = np.zeros_like(edges)
    for row, column in np.argwhere(edges):
        kept[row, column] = framed[row : row + 3, column : column + 3].sum() - 1 > 1
    return kept


@pytest.mark.parametrize("density", [0.05, 0.3, 0.6])
def test_denoising_counts_the_eight_neighbours(density):
    edges = np.random.default_rng(4).random((40, 50)) < density
    assert np.array_equal(denoised(edges), counted_one_by_one(edges))


def test_a_line_loses_its_ends_and_a_speck_goes():
    edges = np.zeros((9, 12), bool)
    edges[4, 2:10] = True
    edges[1, 1] = edges[7, 11] = edges[8, 11] = True
    wanted = np.zeros_like(edges)
    wanted[4, 3:9] = True
    assert np.array_equal(denoised(edges), wanted)


def test_confidence_is_a_share_of_full_scale():
    strength = np.array([[0.0, 0.019, 0.02, 0.2, 1.0]], np.float32)
    assert binarised(strength, 0.02).tolist() == [[False, False, True, True, True]]
    assert binarised(strength / 10, 0.02).sum() == 2


@pytest.mark.parametrize("confidence", [0.0, -0.1, 1.01, float("nan")])
def test_a_confidence_that_is_no_share_is_refused(confidence):
    with pytest.raises(ValueError, match="confidence"):
        binarised(np.zeros((4, 4), np.float32), confidence)


def test_strengths_are_not_taken_for_edges():
    with pytest.raises(TypeError, match="edges"):
        denoised(np.zeros((4, 4), np.float32))
