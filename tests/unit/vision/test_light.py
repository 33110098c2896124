"""Decoding of code values to light, against the published curves."""

import numpy as np
import pytest
from scipy import special

from vision.light import UNKNOWN_RESPONSE, decoding_table, half_level_shift_px


@pytest.mark.parametrize("response", ["srgb", "linear", "gamma 2.2"])
def test_decoding_runs_from_black_to_full_scale_without_a_step_back(response):
    table = decoding_table(response)
    assert table.shape == (256,)
    assert table[0] == 0.0
    assert table[255] == pytest.approx(1.0)
    assert np.all(np.diff(table) > 0)


def test_srgb_decodes_the_published_mid_grey():
    # 18 % grey is code 117.6 in sRGB
    assert np.interp(117.6, np.arange(256), decoding_table("srgb")) == pytest.approx(0.18, abs=0.001)


def test_a_curve_moves_by_the_changes_of_its_parameters():
    moved = UNKNOWN_RESPONSE.moved(np.array([0.2, 0.01, -0.05]))
    assert (moved.exponent, moved.offset, moved.shoulder) == pytest.approx((2.1, 0.04, 0.05))


def test_a_power_law_is_inverted():
    light = 0.37
    code = 255 * light ** (1 / 2.2)
    assert np.interp(code, np.arange(256), decoding_table("gamma 2.2")) == pytest.approx(light, abs=1e-4)


def test_an_unknown_response_is_refused_by_name():
    with pytest.raises(ValueError, match=r"response is 'log'.*srgb"):
        decoding_table("log")


@pytest.mark.parametrize(("dark", "bright", "blur_px"), [(0.02, 0.9, 0.8), (0.2, 0.6, 1.5)])
def test_half_level_of_codes_lies_where_the_codes_of_a_blurred_edge_are_halfway(dark, bright, blur_px):
    place_px = np.linspace(-8.0, 8.0, 4001)
    light = dark + (bright - dark) * special.ndtr(place_px / blur_px)
    code = light ** (1 / 2.2)
    halfway_px = np.interp(0.5 * (code[0] + code[-1]), code, place_px)
    shift_px = half_level_shift_px("gamma 2.2", (code[:1], code[-1:]), blur_px)
    assert shift_px == pytest.approx(-halfway_px, abs=1e-3)
    assert shift_px > 0.1
    assert half_level_shift_px("linear", (code[:1], code[-1:]), blur_px) == pytest.approx(0.0, abs=1e-9)
