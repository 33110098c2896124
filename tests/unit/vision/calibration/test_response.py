"""The response from board edges that are drawn here: a step, a blur with a halo, a response, noise and code values."""

import numpy as np
import pytest
from scipy import special

from appliance.simulation.response import ResponseShape, encode
from vision.calibration.board_edges import BoardEdges
from vision.calibration.response import chosen_response, edge_shift_px, measure_response
from vision.light import UNKNOWN_RESPONSE, ResponseCurve, half_level_share, light_of
from vision.sent_picture import Coding

PICTURES, SEGMENTS, PIXELS = 12, 12, 400
BLACK, WHITE, NOISE = 0.03, 0.45, 0.004
HALO_SHARE, HALO_PX = 0.02, 5.0
PX_PER_MM = (0.35, 1.1)  # near and far boards: a printer's gain shows by it


def boards(response, gain_mm=0.0, bits=10, pictures=PICTURES):
    rng = np.random.default_rng(4)
    return [(edges(rng, response, gain_mm, bits), Coding("grey", bits)) for _ in range(pictures)]


def edges(rng, response, gain_mm, bits):
    scale, blur_px = rng.uniform(*PX_PER_MM), rng.uniform(0.6, 1.0)
    count = SEGMENTS * PIXELS
    distance = rng.uniform(-5.5, 5.5, count)
    place = distance - gain_mm * scale  # black reaches over the line
    share = (1 - HALO_SHARE) * special.ndtr(place / blur_px) + HALO_SHARE * special.ndtr(place / HALO_PX)
    light = BLACK + share * (WHITE - BLACK) + rng.normal(0, NOISE, count)
    code = np.rint(((1 << bits) - 1) * encode(np.clip(light, 0, 1), response)).astype(np.int64)
    segment = np.repeat(np.arange(SEGMENTS), PIXELS)
    return BoardEdges(code, distance, segment, segment % 2 == 0, np.full(count, scale))


def shift_px(curve, response, blur_px=0.8):
    """How far half level of a bar's edge is off when it is decoded by a curve."""
    dark, bright = 0.02, 0.6
    light = np.linspace(0, 1, 4001)
    decoded = light_of(encode(light, response), curve)
    half = np.interp(0.5 * (np.interp(dark, light, decoded) + np.interp(bright, light, decoded)), decoded, light)
    return blur_px * special.ndtri((half - dark) / (bright - dark))


RESPONSES = [
    "linear",
    "srgb",
    "gamma 2.2",
    ResponseShape(1.5, shoulder=0.3),
    ResponseShape(2.4, toe=0.08, black=0.02),
]


@pytest.mark.parametrize("response", RESPONSES)
def test_half_level_is_right_under_the_measured_response(response):
    measured = measure_response(boards(response))
    assert abs(shift_px(measured.curve, response)) < 0.02
    assert measured.pictures == PICTURES


def test_a_printers_gain_is_not_taken_for_a_response():
    measured = measure_response(boards("srgb", gain_mm=0.04))
    assert measured.gain_mm == pytest.approx(0.04, abs=3 * measured.u_gain_mm + 0.01)
    assert abs(shift_px(measured.curve, "srgb")) < 0.02


def test_too_few_pictures_tell_nothing():
    assert measure_response(boards("srgb", pictures=5)) is None
    assert measure_response([]) is None


@pytest.mark.parametrize("told", ["srgb", "linear", "gamma 2.2"])
def test_a_told_response_is_kept_unless_the_pictures_contradict_it(told):
    measured = measure_response(boards("srgb"))
    chosen = chosen_response(told, measured)
    if told == "linear":
        assert chosen.response is measured.curve
        assert 'the response "linear", which the board pictures contradict' in chosen.warning
        assert "px" in chosen.warning
    else:  # sRGB and 2.2 are within 0.04 px of each other
        assert chosen == (told, "", "")


def test_without_any_knowledge_the_doubt_is_large():
    unknown = chosen_response(None, None)
    assert unknown.response is UNKNOWN_RESPONSE
    assert "tells no response" in unknown.warning
    assert edge_shift_px(UNKNOWN_RESPONSE, UNKNOWN_RESPONSE)[1] > 0.05
    assert chosen_response("srgb", None) == ("srgb", "", "")


def test_the_doubt_of_half_level_follows_from_the_covariance():
    curve = ResponseCurve(2.0, covariance=np.diag([0.1**2, 0.0, 0.0]))
    dark, bright = np.array([0.01]), np.array([0.8])
    found = np.linalg.norm(half_level_share(curve, dark, bright))
    middle = (0.5 * (dark + bright)) ** 0.5  # its code value; decoded with an exponent that is 0.1 larger
    low, at, high = (code**2.1 for code in (dark**0.5, middle, bright**0.5))
    assert found == pytest.approx(float(abs((at - low) / (high - low) - 0.5)[0]), rel=0.1)
