"""The share of an edge's way that compression makes: its limits, and against libjpeg on drawn edges."""

from dataclasses import replace

import numpy as np
import pytest
from studies.compression import LEVELS, run

from vision.compression import U_JPEG_SHARE, code_smoothing, compression_shift_px, quantiser_step, u_place_px
from vision.light_planes import Decoder
from vision.sent_picture import Coding

JPEG = Coding("grey", compression="jpeg", quality=75)
VIDEO = Coding("luma", compression="video", quantiser=23.0)


def test_nothing_is_lost_without_compression():
    assert code_smoothing(Coding("grey"), 150.0, 0.8) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("coding", "coarser"),
    [
        (JPEG, Coding("grey", compression="jpeg", quality=50)),
        (VIDEO, Coding("luma", compression="video", quantiser=28.0)),
    ],
)
def test_a_coarser_quantiser_a_lower_and_a_finer_edge_lose_more(coding, coarser):
    share, _ = code_smoothing(coding, 150.0, 0.8)
    assert code_smoothing(coarser, 150.0, 0.8)[0] > share
    assert code_smoothing(coding, 75.0, 0.8)[0] > share
    assert code_smoothing(coding, 150.0, 0.65)[0] > share


def test_a_quantiser_that_nobody_tells_is_doubted_more():
    share, u_share = code_smoothing(Coding("luma", compression="video"), 150.0, 0.8)
    told, u_told = code_smoothing(VIDEO, 150.0, 0.8)
    assert u_share / share > u_told / told
    assert code_smoothing(JPEG, 0.0, 0.8) == (0.0, 0.0)


def test_steps_are_those_of_the_standards():
    assert quantiser_step(VIDEO) == pytest.approx(0.625 * 2 ** (23 / 6))
    assert quantiser_step(Coding("grey", compression="jpeg", quality=100)) == 0.0


@pytest.mark.parametrize("level", LEVELS[:2])
def test_the_share_is_libjpegs(level):
    case = {"coder": "jpeg", "quality": 75, "exponent": 2.4, "dark": level[0], "bright": level[1], "blur_px": 0.8}
    row = run(case)
    share, _ = code_smoothing(JPEG, row["step_codes"], 0.8)
    assert abs(row["share"] - share) <= 2 * np.hypot(row["u_share"], U_JPEG_SHARE * share)


def test_no_edge_moves_nothing():
    plane = Decoder("gamma 2.2").whole(JPEG)
    nowhere = np.full(3, np.nan)
    assert compression_shift_px(JPEG, plane, (nowhere, nowhere), 0.9) == (0.0, 0.0)
    low, high = np.full(3, 0.02), np.full(3, 0.9)
    assert compression_shift_px(JPEG, plane, (high, low), 0.9) == (0.0, 0.0)
    moved_px, u_px = compression_shift_px(JPEG, plane, (low, high), 0.9)
    assert 0.0 < u_px < moved_px < 0.05


def test_the_place_of_a_coded_edge_is_doubted_the_more_the_coarser_the_weaker_and_the_more_upright_it_is():
    assert u_place_px(Coding("grey"), 100.0, 0.0) == 0.0
    doubt_px = u_place_px(VIDEO, 100.0, 0.0)
    assert u_place_px(VIDEO, 50.0, 0.0) == pytest.approx(2 * doubt_px)
    assert u_place_px(replace(VIDEO, quantiser=29.0), 100.0, 0.0) > doubt_px
    assert u_place_px(VIDEO, 100.0, 60.0) < 0.5 * doubt_px
    assert u_place_px(JPEG, 100.0, 0.0) < doubt_px
    assert u_place_px(VIDEO, np.nan, 0.0) == np.inf
