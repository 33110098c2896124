"""Roberts, Prewitt, Sobel and Canny on steps whose place and direction are known."""

import cv2
import numpy as np
import pytest
from random_forests import random_forest
from scipy.ndimage import correlate

from vision.edges.operators import EDGE_METHODS, EdgeOptions, canny, detect_edges, smoothed

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


KERNELS = {  # eq. 2.1 to 2.3 of the dissertation, the first Roberts kernel up to sign
    "roberts": ([[1, 0], [0, -1]], [[0, -1], [1, 0]]),
    "prewitt": ([[-1, 0, 1]] * 3, [[1, 1, 1], [0, 0, 0], [-1, -1, -1]]),
    "sobel": ([[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]], [[1, 2, 1], [0, 0, 0], [-1, -2, -1]]),
}


@pytest.mark.parametrize("method", KERNELS)
def test_strengths_are_those_of_the_printed_kernels(method):
    picture = np.random.default_rng(4).random((40, 50)).astype(np.float32)
    across, down = (np.array(kernel, float) for kernel in KERNELS[method])
    full = np.abs(across).sum() / 2  # a picture from 0 to 1 gives no more
    x, y = (correlate(picture.astype(float), kernel) / full for kernel in (across, down))
    wanted = np.hypot(x, y) / np.sqrt(2)
    strength = detect_edges(picture, method).strength
    shifts = [(r, c) for r in (-1, 0, 1) for c in (-1, 0, 1)] if method == "roberts" else [(0, 0)]
    away = [np.abs(np.roll(wanted, shift, (0, 1)) - strength)[3:-3, 3:-3].max() for shift in shifts]
    assert min(away) < 1e-6


PRINTED_SMOOTHING = {  # eq. 2.5 and 2.6
    "3x3": [[0.0751, 0.1238, 0.0751], [0.1238, 0.2042, 0.1238], [0.0751, 0.1238, 0.0751]],
    "5x5": [
        [0.0030, 0.0133, 0.0219, 0.0133, 0.0030],
        [0.0133, 0.0596, 0.0983, 0.0596, 0.0133],
        [0.0219, 0.0983, 0.1621, 0.0983, 0.0219],
        [0.0133, 0.0596, 0.0983, 0.0596, 0.0133],
        [0.0030, 0.0133, 0.0219, 0.0133, 0.0030],
    ],
}


def impulse_response(kernel):
    impulse = np.zeros((33, 33), np.float32)
    impulse[16, 16] = 1.0
    return smoothed(impulse, kernel)


@pytest.mark.parametrize("kernel", PRINTED_SMOOTHING)
def test_canny_s_kernels_are_the_printed_ones(kernel):
    printed = np.array(PRINTED_SMOOTHING[kernel])
    reach = len(printed) // 2
    inside = np.s_[16 - reach : 17 + reach, 16 - reach : 17 + reach]
    assert impulse_response(kernel)[inside] == pytest.approx(printed, abs=1e-4)
    assert impulse_response(kernel).sum() == pytest.approx(1.0, abs=1e-5)


def test_canny_s_own_smoothing_has_a_variance_of_two_pixels_squared():
    response = impulse_response("gaussian")
    away = np.arange(33) - 16.0
    assert away**2 @ response.sum(axis=0) == pytest.approx(2.0, abs=0.02)
    assert away**2 @ response.sum(axis=1) == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize(("share", "found"), [(0.043, False), (0.058, True)])
def test_canny_s_gradient_is_the_root_of_the_squares_on_an_oblique_edge_too(share, found):
    """An edge at 45 degrees beside an upright one, the steepest: a sum of both parts would be 1.4 times as large."""
    row, column = np.mgrid[:128, :160]
    picture = np.where(column >= 24, 0.8, 0.0) - 0.8 * share * (column - row > 40)
    edges = detect_edges(picture.astype(np.float32), "canny").strength
    assert bool(edges[40:90, 70:140].any()) == found


def test_canny_follows_an_edge_down_to_a_fiftieth_of_the_steepest_gradient():
    """Upright edge whose step falls from 20 % to nothing of the other's, which is the steepest, with its rows."""
    picture = np.zeros((200, 96), np.float32)
    picture[:, 24:] = 0.8
    share = np.linspace(0.2, 0.0, 200, dtype=np.float32)
    picture[:, 64:] -= 0.8 * share[:, None]
    found = detect_edges(picture, "canny").strength[:, 61:67].any(axis=1)
    assert found[(share > 0.023) & (share < 0.19)].all()
    assert not found[share < 0.017].any()


def ramps(*shares):
    """Upright steps, each this share of the steepest, three rows of each so that no edge runs into another."""
    picture = np.zeros((36, 64), np.float32)
    picture[:12, 32:] = 0.8
    picture[16:, 32:] = 0.8 * shares[0]
    return cv2.GaussianBlur(picture, (0, 0), 1.0)


@pytest.mark.parametrize(("share", "found"), [(0.03, False), (0.07, True), (0.3, True)])
def test_canny_starts_at_a_twentieth_of_the_steepest_gradient(share, found):
    edges = detect_edges(ramps(share), EdgeOptions(method="canny")).strength
    assert edges[2:10, 31:33].any(axis=1).all()
    assert bool(edges[26:34, 28:36].any()) == found


def test_canny_s_pair_and_kernel_act():
    noisy = np.clip(step(20) + np.random.default_rng(3).normal(0, 0.08, (61, 81)), 0, 1).astype(np.float32)

    def pixels(picture, **options):
        return int(detect_edges(picture, EdgeOptions(method="canny", **options)).strength.sum())

    assert pixels(ramps(0.3), canny_low=0.4, canny_high=0.5) < pixels(ramps(0.3))
    counted = [pixels(noisy, canny_kernel=kernel) for kernel in ("3x3", "5x5", "gaussian")]
    assert counted[0] > counted[1] > counted[2]  # the more smoothing, the less noise


@pytest.mark.parametrize(
    "wrong",
    [{"method": "cany"}, {"canny_low": 0.5}, {"canny_high": 1.0}, {"canny_kernel": "7x7"}, {"canny_low": 0.0}],
)
def test_edge_options_that_cannot_be_are_named(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong)).replace("method", "edges")):
        EdgeOptions(**wrong)


def test_a_forest_of_one_s_own_finds_the_edges():
    picture = step(0)
    own = EdgeOptions(forest=random_forest(seed=5, depth=4, patches=200))
    assert not np.array_equal(detect_edges(picture, own).strength, detect_edges(picture, "forest").strength)
    assert np.array_equal(detect_edges(picture, EdgeOptions()).strength, detect_edges(picture, "forest").strength)


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
    with pytest.raises(ValueError, match=r"edges: 'cany' is none of forest, sobel, prewitt, roberts, canny"):
        detect_edges(np.zeros((40, 40), np.float32), "cany")
