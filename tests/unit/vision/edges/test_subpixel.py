"""Edges with a known place: a step, blurred by a Gaussian, is the normal distribution function."""

import numpy as np
import pytest
from scipy.stats import norm

from vision.edges.profiles import sample_profiles
from vision.edges.subpixel import edge_blur_px, edge_shading, even_profiles, fitted_edges, half_level_crossing
from vision.light_planes import LightPlane

OFFSETS = np.arange(-9.0, 9.25, 0.25)


def blurred_step(place, blur, dark=0.03, bright=0.6):
    return dark + (bright - dark) * norm.cdf((OFFSETS - place) / blur)


def test_a_blurred_step_is_found_where_it_is():
    places = np.linspace(-2.0, 2.0, 41)
    profile = np.array([blurred_step(place, 0.8) for place in places])
    found = half_level_crossing(profile, OFFSETS, 0.8)
    np.testing.assert_allclose(found.place_px, places, atol=0.003)
    np.testing.assert_allclose(found.dark, 0.03, atol=0.005)
    np.testing.assert_allclose(found.bright, 0.6, atol=0.005)


def test_half_level_of_coded_values_is_somewhere_else():
    profile = blurred_step(0.0, 1.0)[None, :]
    coded = half_level_crossing(profile ** (1 / 2.2), OFFSETS, 1.0).place_px[0]
    assert coded < -0.3


def test_the_first_clear_rise_is_the_edge_unless_another_is_expected():
    # a dark patch on the bar: its own edge, 5 px further in, is the steeper one
    profile = (0.3 * norm.cdf(OFFSETS / 0.6) + 0.7 * norm.cdf((OFFSETS - 5.0) / 0.6))[None, :]
    assert half_level_crossing(profile, OFFSETS, 0.6).place_px[0] == pytest.approx(0.0, abs=0.02)
    assert half_level_crossing(profile, OFFSETS, 0.6, expected_px=5.2).place_px[0] == pytest.approx(5.0, abs=0.02)


def test_a_faint_reflection_before_the_edge_is_not_taken_for_it():
    profile = (0.08 * norm.cdf((OFFSETS + 5.0) / 0.6) + 0.92 * norm.cdf(OFFSETS / 0.6))[None, :]
    assert half_level_crossing(profile, OFFSETS, 0.6).place_px[0] == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize(
    "profile",
    [np.full(OFFSETS.size, 0.2), np.full(OFFSETS.size, np.nan), blurred_step(0.0, 0.8)[::-1]],
    ids=["flat", "outside the picture", "bright to dark"],
)
def test_a_profile_without_a_rise_has_no_edge(profile):
    assert np.isnan(half_level_crossing(profile[None, :], OFFSETS, 0.8).place_px[0])


def test_noise_moves_an_edge_without_a_bias():
    rng = np.random.default_rng(3)
    profile = blurred_step(0.3, 0.9) + rng.normal(0, 0.01, (4000, OFFSETS.size))
    place = half_level_crossing(profile, OFFSETS, 0.9).place_px
    standard_error = place.std() / np.sqrt(place.size)
    assert abs(place.mean() - 0.3) < 4 * standard_error + 0.003


@pytest.mark.parametrize("blur", [0.6, 1.0, 1.8])
def test_the_blur_of_an_edge_is_measured(blur):
    profile = np.array([blurred_step(place, blur) for place in (-0.4, 0.0, 0.7)])
    assert edge_blur_px(profile, OFFSETS, np.array([-0.4, 0.0, 0.7])) == pytest.approx(blur, rel=0.05)


@pytest.mark.parametrize("blur", [0.7, 1.1])
@pytest.mark.parametrize("darker", [0.0, 0.05, 0.1])
def test_a_limb_that_grows_darker_with_the_angle_is_found_where_it_is(blur, darker):
    # a cylinder of 90 px radius whose light falls with the cosine of the angle, blurred numerically
    fine = np.arange(-29.995, 30.0, 0.01)  # cells, none of which the edge cuts
    depth = np.clip(fine, 0.0, 90.0)
    cosine = np.sqrt(1 - (1 - depth / 90.0) ** 2)
    light = np.where(fine < 0, 0.03, 0.6 * (1 - darker * (1 - cosine)))
    spread = norm.pdf(np.arange(-6.0, 6.005, 0.01) / blur)
    profile = np.interp(OFFSETS, fine, np.convolve(light, spread / spread.sum(), mode="same"))[None, :]
    without = half_level_crossing(profile, OFFSETS, blur, expected_px=0.0)
    shading = edge_shading(profile, OFFSETS, without, blur)
    place = half_level_crossing(profile, OFFSETS, blur, expected_px=0.0, shading=shading).place_px[0]
    assert abs(place) < 0.003
    assert darker < 0.1 or abs(place) < 0.3 * abs(without.place_px[0])


def test_patches_on_the_bar_do_not_count_as_shading():
    flat = blurred_step(0.0, 0.8)
    patched = np.where(OFFSETS > 4.0, 0.4 * flat, flat)
    profile = np.array([flat] * 6 + [patched] * 4)
    assert edge_shading(profile, OFFSETS, half_level_crossing(profile, OFFSETS, 0.8), 0.8) == pytest.approx(
        0.0, abs=5e-3
    )


def test_profiles_are_sampled_along_the_normal_and_empty_outside():
    y, x = np.mgrid[0:20, 0:30]
    picture = np.stack([np.zeros_like(x), x + 5 * y], axis=-1).astype(np.uint8)
    plane = LightPlane(1, np.arange(256, dtype=np.float32)[None], np.ones(1, np.float32), 250.0)
    normal = np.array([[0.6, 0.8]])
    values = sample_profiles(picture, plane, np.array([[10.0, 8.0]]), normal, np.array([-1.0, 0.0, 2.0, 50.0]))
    np.testing.assert_allclose(values[0, :3], [9.4 + 36, 10 + 40, 11.2 + 48])
    assert np.isnan(values[0, 3])


def patched(place, patch_px, darker=0.3):
    """A bar's edge with a dark patch that begins some way behind it."""
    edge = blurred_step(place, 0.9, 0.0, 1.0)
    return 0.03 + 0.57 * (edge - darker * norm.cdf((OFFSETS - place - patch_px) / 0.9))


def located(profile):
    crossings = half_level_crossing(profile, OFFSETS, 0.9, expected_px=0.0)
    even = even_profiles(profile, OFFSETS, crossings, 0.9)
    return crossings.place_px, *fitted_edges(profile, OFFSETS, crossings, even, 0.9)


def test_an_edge_s_own_shape_agrees_with_half_level_on_a_clean_edge():
    rng = np.random.default_rng(4)
    places = rng.uniform(-0.8, 0.8, 300)
    profile = np.array([blurred_step(place, 0.9) for place in places]) + rng.normal(0, 0.004, (300, OFFSETS.size))
    half, fitted, _, uneven = located(profile)
    assert abs(np.mean(fitted - places)) < 0.003
    assert np.std(fitted - places) < 0.03
    assert np.isfinite(fitted).mean() > 0.95
    assert uneven < 0.05
    assert abs(np.median(fitted - half)) < 0.003


def test_edges_that_a_patch_would_move_are_left_out_and_told():
    rng = np.random.default_rng(5)
    places = rng.uniform(-0.3, 0.3, 300)
    near = rng.uniform(1.5, 6.0, 300)
    spoilt = np.arange(300) % 3 == 0
    profile = np.array(
        [
            patched(place, patch) if spoil else blurred_step(place, 0.9)
            for place, patch, spoil in zip(places, near, spoilt, strict=True)
        ]
    ) + rng.normal(0, 0.004, (300, OFFSETS.size))
    half, fitted, _, uneven = located(profile)
    assert uneven == pytest.approx(1 / 3, abs=0.1)
    assert np.nanmax(np.abs(half - places)[spoilt]) > 0.15
    assert np.nanmax(np.abs(fitted - places)) < 0.12
    assert np.isfinite(fitted[~spoilt]).mean() > 0.95
