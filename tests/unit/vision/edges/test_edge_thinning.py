"""Ridges of edge strength: one pixel wide, where the strength is greatest."""

import numpy as np
import pytest

from vision.edges.thinning import ridge_normals, ridges


def band(normal_deg: float):
    """A straight band of edge strength through the middle, and each pixel's distance from its ridge."""
    y, x = np.mgrid[:61, :81] - np.array([30.0, 40.0])[:, None, None]
    across = x * np.cos(np.radians(normal_deg)) + y * np.sin(np.radians(normal_deg))
    return np.exp(-(across**2) / 6).astype(np.float32), across


@pytest.mark.parametrize("normal_deg", [0, 20, 45, 70, 90, 110, 135, 179])
def test_a_band_becomes_an_unbroken_line_on_its_ridge(normal_deg):
    strength, across = band(normal_deg)
    normals = ridge_normals(strength)
    inner = np.s_[8:-8, 8:-8]
    on_ridge = (strength > 0.9)[inner]
    turn = np.degrees(normals[inner][on_ridge]) - normal_deg
    assert np.abs((turn + 90) % 180 - 90).max() < 3
    assert normals.min() >= 0
    assert normals.max() < np.pi
    line = ridges(strength, normals)[inner]
    assert np.abs(across[inner][line > 0.01]).max() <= 0.75
    along_rows = abs(np.cos(np.radians(normal_deg))) > 0.7
    assert (line > 0.9).any(axis=1 if along_rows else 0).sum() >= 45


def test_what_stays_keeps_its_strength_and_a_lone_pixel_stays():
    strength = np.zeros((20, 20), np.float32)
    strength[7, 9] = 0.3
    assert np.array_equal(ridges(strength, np.zeros_like(strength)), strength)


def test_the_weaker_of_two_near_edges_is_suppressed_and_of_two_far_ones_none():
    strength = np.zeros((20, 30), np.float32)
    strength[:, 10], strength[:, 12], strength[:, 20] = 0.5, 0.4, 0.2
    kept = ridges(strength, np.zeros_like(strength))
    assert np.flatnonzero(kept.all(axis=0)).tolist() == [10, 20]
    assert not kept[:, 12].any()
