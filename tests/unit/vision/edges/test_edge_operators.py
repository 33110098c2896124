"""Roberts, Prewitt, Sobel and Canny on steps whose place and direction are known."""

import numpy as np
import pytest

from vision.edges.operators import EDGE_METHODS, canny, detect_edges

CLASSICAL = ("sobel", "prewitt", "roberts", "canny")


def step(normal_deg: float, low: float = 0.1, high: float = 0.9) -> np.ndarray:
    """A straight ramp through the middle, three pixels wide, whose normal has the given angle from x towards y."""
    y, x = np.mgrid[:61, :81] - np.array([30.0, 40.0])[:, None, None]
    across = x * np.cos(np.radians(normal_deg)) + y * np.sin(np.radians(normal_deg))
    return np.clip(low + (high - low) * (across / 3 + 0.5), low, high).astype(np.float32)


@pytest.mark.parametrize("method", CLASSICAL)
@pytest.mark.parametrize("normal_deg", [0, 30, 45, 75, 90, 120, 165])
def test_an_edge_is_strongest_on_its_line_and_faces_across_it(method, normal_deg):
    edges = detect_edges(step(normal_deg), method)
    y, x = np.nonzero(edges.strength > 0.9 * edges.strength.max())
    across = (x - 40) * np.cos(np.radians(normal_deg)) + (y - 30) * np.sin(np.radians(normal_deg))
    assert np.abs(across).max() <= 2
    turn = np.degrees(edges.normal_rad[y, x]) - normal_deg
    assert abs(np.median((turn + 90) % 180 - 90)) < 3
    assert edges.normal_rad.min() >= 0
    assert edges.normal_rad.max() < np.pi


@pytest.mark.parametrize("method", CLASSICAL)
def test_strengths_stay_between_0_and_1_on_the_hardest_picture(method):
    picture = (np.random.default_rng(1).random((64, 64)) > 0.5).astype(np.float32)
    strength = detect_edges(picture, method).strength
    assert strength.dtype == np.float32
    assert 0.6 < strength.max() <= 1
    assert strength.min() >= 0


@pytest.mark.parametrize("method", CLASSICAL)
def test_a_flat_picture_has_no_edge(method):
    assert detect_edges(np.full((40, 50, 3), 0.3, np.float32), method).strength.max() < 1e-6


def test_a_weak_line_of_canny_is_followed_from_where_it_is_strong():
    picture = step(0)
    picture = 0.1 + (picture - 0.1) * np.linspace(1, 0.25, len(picture), dtype=np.float32)[:, None]
    low_too_high, followed = canny(picture, 0.4, 0.5), canny(picture, 0.1, 0.5)
    assert not low_too_high.strength[52:].any()
    assert followed.strength[52:].any(axis=1).all()


@pytest.mark.parametrize("method", EDGE_METHODS)
@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((40, 40)),
        np.zeros((40, 40), np.uint8),
        np.zeros((40, 40, 4), np.float32),
        np.zeros((0, 0), np.float32),
        np.zeros((31, 40), np.float32),
        np.full((40, 40), np.nan, np.float32),
        np.full((40, 40), 255, np.float32),
        [[0.0]],
    ],
)
def test_what_is_no_picture_is_refused_by_name(picture, method):
    with pytest.raises(ValueError, match="image: "):
        detect_edges(picture, method)


def test_an_unknown_method_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match=r"method: 'cany' is none of forest, sobel, prewitt, roberts, canny"):
        detect_edges(np.zeros((40, 40), np.float32), "cany")
