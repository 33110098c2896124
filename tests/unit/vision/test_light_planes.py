"""Half level in luma and in mosaics, on edges whose place is given and which cameras coded."""

import numpy as np
import pytest
from scipy import special

from appliance.simulation.coding import mosaic
from appliance.simulation.response import ResponseShape
from vision.edges.profiles import sample_profiles
from vision.light import ResponseCurve, light_of
from vision.light_planes import Decoder
from vision.sent_picture import LUMA_601, LUMA_709, Coding, sent_picture

EDGE_PX, BLUR_PX, LEANING = 20.37, 1.1, 0.13
OFFSETS = np.arange(-8, 8.25, 0.25)
DARK, BRIGHT = np.array([0.03, 0.025, 0.02]), np.array([0.06, 0.25, 0.7])  # blue, green, red
CURVE = ResponseCurve(2.1, 0.04, 0.2)


def encoded(light, curve=CURVE):
    grid = np.linspace(0, 1, 20001)
    return np.interp(light, light_of(grid, curve), grid)


def light(dark=DARK, bright=BRIGHT, rows=40):
    """Of an edge that leans, so that it crosses pixels at all phases."""
    row, column = np.mgrid[:rows, :41]
    share = special.ndtr((column - EDGE_PX - LEANING * (row - 20)) / BLUR_PX)
    return dark + share[:, :, None] * (bright - dark)


def crossing(picture, plane):
    """Where the mean profile over many rows is halfway between its plateaus."""
    rows = np.linspace(8, 31, 185)
    point = np.column_stack([20 + LEANING * (rows - 20), rows])
    profile = sample_profiles(picture.measured, plane, point, np.tile([1.0, 0.0], (len(rows), 1)), OFFSETS)
    mean = profile.mean(axis=0)
    return 20 + np.interp(0.5 * (mean[:8].mean() + mean[-8:].mean()), mean, OFFSETS)


def shown_codes(colour):
    return 255 * encoded(colour)


@pytest.mark.parametrize("weights", [LUMA_601, LUMA_709])
@pytest.mark.parametrize("dark", [DARK, np.array([0.3, 0.2, 0.05]), np.array([0.02, 0.1, 0.3])])
def test_luma_of_a_red_bar_crosses_halfway_before_any_ground(weights, dark):
    red, blue = weights
    luma = encoded(light(dark)) @ np.array([blue, 1 - red - blue, red])
    coding = Coding("luma", 10, luma_weights=weights)
    codes = np.rint(1023 * luma).astype(np.uint16)
    picture = sent_picture(codes, coding, np.zeros((*codes.shape, 3), np.uint8))
    (plane,) = Decoder(CURVE).planes(coding, shown_codes(dark), shown_codes(BRIGHT))
    assert crossing(picture, plane) == pytest.approx(EDGE_PX, abs=0.01)


@pytest.mark.parametrize("pattern", ["RGGB", "GBRG"])
def test_a_mosaic_crosses_halfway_though_its_sites_differ(pattern):
    codes = np.rint(4095 * encoded(light())).astype(np.uint16)
    coding = Coding("mosaic", 12, mosaic=pattern)
    picture = sent_picture(mosaic(codes, pattern), coding)
    plane = Decoder(CURVE).planes(coding, shown_codes(DARK), shown_codes(BRIGHT))[0]
    assert crossing(picture, plane) == pytest.approx(EDGE_PX, abs=0.015)


def test_an_overexposed_channel_of_a_mosaic_is_left_out():
    bright = np.array([0.2, 0.7, 1.9])
    codes = np.rint(4095 * encoded(np.minimum(light(bright=bright), 1.0))).astype(np.uint16)
    coding = Coding("mosaic", 12, mosaic="RGGB")
    picture = sent_picture(mosaic(codes, "RGGB"), coding)
    whole, unclipped = Decoder(CURVE).planes(coding, shown_codes(DARK), shown_codes(np.minimum(bright, 1.0)))
    assert abs(crossing(picture, whole) - EDGE_PX) > 0.1
    assert crossing(picture, unclipped) == pytest.approx(EDGE_PX, abs=0.01)


def test_colours_come_brightest_first():
    planes = Decoder("srgb").planes(Coding("colour"), np.zeros(3), np.array([40.0, 220.0, 130.0]))
    assert [plane.channel for plane in planes] == [1, 2, 0]


def test_a_curve_inverts_a_response_of_its_kind():
    shape = ResponseShape(2.2, toe=0.05, black=0.01)
    code = shape.encode(np.linspace(0.05, 1, 50))
    # (c - p) / (1 - p) + a, over 1 + a, is (c + a') / (1 + a')
    curve = ResponseCurve(2.2, offset=0.05 * (1 - 0.01) - 0.01)
    np.testing.assert_allclose(curve.light(code), np.linspace(0.05, 1, 50), atol=2e-3)
