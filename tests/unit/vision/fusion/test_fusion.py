"""Fusing two pictures: identities that hold for every method, each method's own rule, and bad input."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import pywt

from vision.fusion.fourier import LEAST_STRIP_PX, continued, fuse_spectra
from vision.fusion.methods import METHODS, MULTISCALE, fuse
from vision.fusion.multiscale import Scales
from vision.fusion.wavelets import WAVELETS, wavelet

SHAPES = ((64, 96), (61, 83), (33, 48, 3), (7, 5), (1, 1), (1, 40))
TYPES = (np.uint8, np.uint16, np.float32, np.float64)


def full_scale(dtype):
    return np.iinfo(dtype).max if np.dtype(dtype).kind == "u" else 1.0


def noise(shape, dtype=np.float32, seed=0):
    return (np.random.default_rng(seed).random(shape) * full_scale(dtype)).astype(dtype)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_a_picture_fused_with_itself_is_that_picture(method, dtype, shape):
    picture = noise(shape, dtype)
    fused = fuse(picture, picture.copy(), method)
    assert fused.dtype == dtype
    assert fused.shape == shape
    off = np.abs(fused.astype(np.float64) - picture.astype(np.float64)).max()
    assert off < 1e-5 * full_scale(dtype)
    if np.dtype(dtype).kind == "u":
        assert off == 0


@pytest.mark.parametrize("levels", [1, 3, 9])
@pytest.mark.parametrize("rule", ["larger", "weighted"])
@pytest.mark.parametrize("approximation", ["average", "larger"])
@pytest.mark.parametrize("method", MULTISCALE)
def test_the_identity_holds_for_all_scales(method, levels, rule, approximation):
    picture = noise((75, 102))
    fused = fuse(picture, picture.copy(), method, scales=Scales(levels, rule, approximation))
    np.testing.assert_allclose(fused, picture, rtol=0, atol=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_fusing_leaves_its_pictures_alone_and_does_not_depend_on_threads(method):
    left, right = noise((70, 90)), noise((70, 90), seed=1)
    before = left.copy(), right.copy()
    alone = fuse(left, right, method)
    with ThreadPoolExecutor(2) as pool:
        np.testing.assert_array_equal(fuse(left, right, method, executor=pool), alone)
    np.testing.assert_array_equal(left, before[0])
    np.testing.assert_array_equal(right, before[1])


@pytest.mark.parametrize("method", METHODS)
def test_constant_pictures_give_a_constant_picture_between_them(method):
    dark, bright = np.full((50, 60), 40, dtype=np.uint8), np.full((50, 60), 90, dtype=np.uint8)
    fused = fuse(dark, bright, method)
    expected = {"fft": 90, "minimum": 40, "maximum": 90}.get(method, 65)
    np.testing.assert_array_equal(fused, np.full((50, 60), expected, dtype=np.uint8))


@pytest.mark.parametrize("method", ["average", "minimum", "maximum"])
def test_pixel_by_pixel_methods_agree_with_numpy(method):
    left, right = noise((20, 30, 3)), noise((20, 30, 3), seed=1)
    expected = {"average": (left + right) / 2, "minimum": np.minimum(left, right), "maximum": np.maximum(left, right)}
    np.testing.assert_allclose(fuse(left, right, method), expected[method], rtol=1e-6)


def test_fourier_fusion_takes_from_each_view_the_frequencies_that_are_stronger_there():
    x, y = np.meshgrid(np.arange(240), np.arange(180))
    wave = [np.sin(0.3 * x), np.sin(0.7 * y), np.sin(0.9 * x + 0.5 * y)]
    left = 0.5 + 0.20 * wave[0] + 0.05 * wave[1]
    right = 0.5 + 0.05 * wave[0] + 0.20 * wave[1] + 0.1 * wave[2]
    fused = fuse(left, right, "fft")
    strength = [2 * np.mean((fused - 0.5) * one) for one in wave]
    assert strength == pytest.approx([0.20, 0.20, 0.10], abs=0.015)


@pytest.mark.parametrize(("rows", "columns"), [(48, 63), (59, 65), (59, 48), (48, 65)])
def test_fourier_fusion_is_algorithm_14_written_down_with_numpy(rows, columns):
    """Even and odd lengths, 64, 75, 80 and 81 with their strips, which OpenCV packs in different ways."""
    left, right = noise((1, rows, columns)), noise((1, rows, columns), seed=1)
    first, second = (np.fft.fft2(continued(planes)[0].astype(np.float64)) for planes in (left, right))
    of_first = np.abs(first) > np.abs(second)
    magnitude = np.where(of_first, np.abs(first), np.abs(second))
    phase = np.where(of_first, np.angle(first), np.angle(second))
    expected = np.fft.ifft2(magnitude * np.exp(1j * phase)).real[:rows, :columns]
    np.testing.assert_allclose(fuse_spectra(left, right)[0], expected, rtol=0, atol=2e-5)


def test_as_printed_algorithm_14_takes_pictures_to_be_periodic():
    left, right = noise((48, 63)), noise((48, 63), seed=1)
    first, second = (np.fft.fft2(picture.astype(np.float64)) for picture in (left, right))
    expected = np.fft.ifft2(np.where(np.abs(first) > np.abs(second), first, second)).real
    np.testing.assert_allclose(fuse(left, right, "fft", periodic=True), expected, rtol=0, atol=2e-5)
    assert np.abs(fuse(left, right, "fft") - expected).max() > 0.05


def test_the_spectrum_holds_the_energy_of_the_picture():
    picture = continued(noise((1, 61, 83)))[0]
    spectrum = np.abs(np.fft.rfft2(picture)) ** 2
    twice = slice(1, None if picture.shape[1] % 2 else -1)
    assert (spectrum.sum() + spectrum[:, twice].sum()) / picture.size == pytest.approx(np.sum(picture**2), rel=1e-5)


@pytest.mark.parametrize("shape", [(40, 61), (5, 3), (1, 1)])
def test_pictures_are_continued_without_a_step(shape):
    ramp = np.add.outer(10.0 * np.arange(shape[0]), np.arange(shape[1])).astype(np.float32)[None]
    whole = continued(ramp)[0]
    np.testing.assert_array_equal(whole[: shape[0], : shape[1]], ramp[0])
    for axis in (0, 1):
        around = np.concatenate([whole, whole.take([0], axis=axis)], axis=axis)
        step, rise = np.abs(np.diff(around, axis=axis)).max(), (10.0, 1.0)[axis]
        assert step <= rise * (1 + (shape[axis] + 2 * LEAST_STRIP_PX) / LEAST_STRIP_PX)


def test_no_seam_shows_where_opposite_borders_differ():
    """Slopes against each other: their steps from border to border have frequencies all over the picture."""
    rng = np.random.default_rng(3)
    x = np.tile(np.linspace(0, 1, 200), (150, 1))
    left, right = (slope + 0.02 * rng.standard_normal(x.shape) for slope in (0.2 + 0.6 * x, 0.8 - 0.6 * x))
    first, second = (np.fft.fft2(picture) for picture in (left, right))
    plain = np.fft.ifft2(np.where(np.abs(first) > np.abs(second), first, second)).real

    def ripple(picture):
        return np.std(np.diff(picture.mean(axis=0), 2))

    assert ripple(fuse(left, right, "fft")) < 0.2 * ripple(plain)


@pytest.mark.parametrize("name", WAVELETS)
@pytest.mark.parametrize("approximation", ["average", "larger"])
@pytest.mark.parametrize("levels", [1, 2])
def test_wavelet_fusion_keeps_the_larger_of_the_coefficients_that_pywavelets_gives(name, approximation, levels):
    left, right = noise((150, 161)), noise((150, 161), seed=1)
    first, second = (pywt.wavedec2(one.astype(np.float64), wavelet(name), level=levels) for one in (left, right))
    expected = [0.5 * (first[0] + second[0]) if approximation == "average" else larger(first[0], second[0])]
    expected += [tuple(map(larger, *details)) for details in zip(first[1:], second[1:], strict=True)]
    fused = fuse(left, right, name, scales=Scales(levels, "larger", approximation))
    np.testing.assert_allclose(fused, pywt.waverec2(expected, wavelet(name))[:150, :161], rtol=0, atol=1e-5)


def larger(a, b):
    return np.where(np.abs(a) > np.abs(b), a, b)


def test_the_weighted_rule_lies_between_both_views_and_leans_to_the_larger():
    left, right = noise((64, 64)), noise((64, 64), seed=1)
    first, second = (pywt.wavedec2(picture.astype(np.float64), "db2", level=1)[1][0] for picture in (left, right))
    fused = fuse(left, right, "db2", scales=Scales(1, "weighted"))
    again = pywt.wavedec2(fused.astype(np.float64), "db2", level=1)[1][0]
    inner = (slice(3, -3), slice(3, -3))
    weighted = (np.abs(first) * first + np.abs(second) * second) / (np.abs(first) + np.abs(second))
    np.testing.assert_allclose(again[inner], weighted[inner], rtol=0, atol=1e-5)


@pytest.mark.parametrize("method", ["pyramid", "db4", "fk4"])
def test_details_that_only_one_view_has_are_kept_in_full(method):
    """Stripes that are sharp left above and right below: the fused picture has them sharp everywhere."""
    x = np.tile(np.arange(160), (120, 1))
    sharp, flat = (0.5 + 0.2 * np.sin(1.5 * x)).astype(np.float32), np.full(x.shape, 0.5, dtype=np.float32)
    above = np.arange(120)[:, None] < 60
    fused = fuse(np.where(above, sharp, flat), np.where(above, flat, sharp), method)
    rows = np.r_[10:45, 75:110]
    np.testing.assert_allclose(fused[rows, 20:-20], sharp[rows, 20:-20], atol=0.02)


@pytest.mark.parametrize("method", ["pyramid", "db2", "fft"])
def test_integers_stay_within_their_range(method):
    left, right = (noise((40, 40), np.uint8, seed) for seed in (1, 2))
    floats = fuse(left / 255.0, right / 255.0, method)
    clipped = np.clip(np.rint(255 * floats), 0, 255)
    assert np.abs(fuse(left, right, method) - clipped).max() <= 1
    assert floats.max() > 1.001 or floats.min() < -0.001


def good():
    return np.zeros((4, 5), dtype=np.uint8)


@pytest.mark.parametrize(
    ("left", "right", "said"),
    [
        (good(), np.zeros((5, 4), dtype=np.uint8), r"^right: uint8 of shape \(5, 4\), but left is"),
        (good(), np.zeros((4, 5), dtype=np.float32), "^right: float32 of shape"),
        (np.zeros((4, 5), dtype=np.int32), good(), "^left: int32 is none of uint8, uint16, float32, float64"),
        (np.zeros((4, 5), dtype=bool), good(), "^left: bool"),
        (np.zeros((4, 5, 4), dtype=np.uint8), good(), r"^left: shape \(4, 5, 4\)"),
        (np.zeros((0, 5), dtype=np.uint8), good(), r"^left: shape \(0, 5\)"),
        (np.zeros(5, dtype=np.uint8), good(), r"^left: shape \(5,\)"),
        (np.zeros((4, 5)), np.full((4, 5), np.nan), "^right: holds values that are not finite"),
        (np.full((4, 5), np.inf), np.zeros((4, 5)), "^left: holds values that are not finite"),
    ],
)
@pytest.mark.parametrize("method", ["fft", "db4", "average"])
def test_pictures_that_cannot_be_fused_are_named(left, right, said, method):
    with pytest.raises(ValueError, match=said):
        fuse(left, right, method)


def test_an_unknown_method_is_named():
    with pytest.raises(ValueError, match="method: 'db3' is none of fft, db2, "):
        fuse(good(), good(), "db3")


@pytest.mark.parametrize(
    ("values", "said"),
    [({"levels": 0}, "levels: 0"), ({"rule": "x"}, "rule: 'x'"), ({"approximation": "x"}, "approximation: 'x'")],
)
def test_scales_that_make_no_sense_are_named(values, said):
    with pytest.raises(ValueError, match=said):
        Scales(**values)
