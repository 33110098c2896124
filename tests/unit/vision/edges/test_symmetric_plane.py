"""Which guess of a clipped channel is taken: the one under which a blurred edge is the normal distribution function."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from vision.edges.symmetric_plane import _asymmetry, settled

OFFSETS_PX = np.arange(-7.0, 7.01, 0.25)


def edges(at_px, response=1.0):
    """Profiles of one straight edge that crosses a few pixels, as light or as what a response makes of it."""
    places_px = at_px + np.linspace(-0.4, 0.4, 9)
    return (0.1 + 0.8 * norm.cdf(OFFSETS_PX - places_px[:, None], scale=1.3)) ** response


@pytest.mark.parametrize("at_px", [-2.0, 0.0, 2.0])
def test_of_several_guesses_the_one_that_gives_light_is_taken_wherever_the_edge_lies(at_px):
    planes = [SimpleNamespace(is_guess=True, response=response) for response in (0.5, 1.0, 2.0)]
    (taken,) = settled(planes, lambda plane: edges(at_px, plane.response), OFFSETS_PX)
    assert taken.response == 1.0


@pytest.mark.parametrize("at_px", [-2.0, 0.0, 2.0])
def test_light_is_symmetric_and_without_an_edge_nothing_is(at_px):
    assert _asymmetry(edges(at_px), OFFSETS_PX) < 0.01
    assert np.isinf(_asymmetry(np.full((9, OFFSETS_PX.size), 0.5), OFFSETS_PX))


def test_planes_that_are_no_guess_stay_as_they_are():
    planes = [SimpleNamespace(is_guess=False), SimpleNamespace(is_guess=False)]
    assert settled(planes, edges, OFFSETS_PX) == planes
