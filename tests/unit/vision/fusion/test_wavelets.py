"""The wavelets by name: derived anew with many digits, against published tables, and by their identities."""

import mpmath
import numpy as np
import pytest
import pywt

from vision.fusion.wavelets import FEJER_KOROVKIN, WAVELETS, wavelet

# the tables that public packages carry, to the digits in which they agree with each other
PUBLISHED = {
    "fk4": [0.6539, 0.7533, 0.0532, -0.0462],
    "fk6": [0.4279, 0.8129, 0.3564, -0.1464, -0.0772, 0.0406],
    "fk8": [0.3492, 0.7827, 0.4753, -0.0997, -0.1600, 0.0431, 0.0426, -0.0190],
}


def derived(length):
    """Nielsen's filter: half-band gain damped by the Fejer-Korovkin kernel, its minimum phase factor."""
    n = 3 if length == 4 else length
    step = mpmath.pi / (n + 2)

    def damping(k):
        top = (n - k + 3) * mpmath.sin((k + 1) * step) - (n - k + 1) * mpmath.sin((k - 1) * step)
        return top / (2 * (n + 2) * mpmath.sin(step))

    term = {k: damping(k) * mpmath.sin(k * mpmath.pi / 2) / k for k in range(1, length, 2)}
    scale = 1 / (2 * sum(term.values()))
    # |m0|^2 times z^(length - 1), a symmetric polynomial, highest power first
    gain = [mpmath.mpf(0)] * (2 * length - 1)
    gain[length - 1] = mpmath.mpf(1) / 2
    for k, value in term.items():
        gain[length - 1 - k] += scale * value / 2
        gain[length - 1 + k] += scale * value / 2
    left = divided_by_z_plus_1(divided_by_z_plus_1(gain))
    roots = mpmath.polyroots(left, maxsteps=2000, extraprec=2000, asc=True)  # symmetric: either order is the same
    inner = sorted(roots, key=abs)[: length - 2]
    factor = [mpmath.mpf(1), mpmath.mpf(1)]
    for root in inner:
        factor = [a - root * b for a, b in zip([*factor, 0], [0, *factor], strict=True)]
    real = [mpmath.re(value) for value in factor]
    return np.array([float(mpmath.sqrt(2) * value / sum(real)) for value in real])


def divided_by_z_plus_1(polynomial):
    quotient, rest = [], mpmath.mpf(0)
    for value in polynomial:
        rest = value - rest
        quotient.append(rest)
    assert abs(quotient.pop()) < mpmath.mpf(10) ** -50
    return quotient


@pytest.mark.parametrize("name", FEJER_KOROVKIN)
def test_fejer_korovkin_filters_follow_from_their_definition(name):
    with mpmath.workdps(60):
        np.testing.assert_allclose(FEJER_KOROVKIN[name], derived(int(name[2:])), rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", PUBLISHED)
def test_fejer_korovkin_filters_agree_with_published_tables(name):
    np.testing.assert_allclose(FEJER_KOROVKIN[name], PUBLISHED[name], rtol=0, atol=1e-4)


@pytest.mark.parametrize("name", WAVELETS)
def test_a_filter_is_orthogonal_to_its_double_shifts_and_blind_at_the_highest_frequency(name):
    h = np.array(wavelet(name).rec_lo)
    shifted = [h[2 * shift :] @ h[: h.size - 2 * shift] for shift in range(h.size // 2)]
    np.testing.assert_allclose(shifted, [1.0, *[0.0] * (h.size // 2 - 1)], rtol=0, atol=1e-12)
    assert h.sum() == pytest.approx(np.sqrt(2), abs=1e-12)
    assert np.sum(h * (-1.0) ** np.arange(h.size)) == pytest.approx(0.0, abs=1e-9)


def test_daubechies_wavelets_are_those_of_pywavelets_with_twice_their_number_of_coefficients():
    for number in (2, 4, 8, 16):
        assert wavelet(f"db{number}").dec_lo == pywt.Wavelet(f"db{number}").dec_lo
        assert wavelet(f"db{number}").dec_len == 2 * number


@pytest.mark.parametrize("name", WAVELETS)
def test_transform_and_inverse_give_the_picture_back(name):
    picture = np.random.default_rng(1).uniform(0, 255, (131, 154))
    there = pywt.wavedec2(picture, wavelet(name), "symmetric", 2)
    np.testing.assert_allclose(pywt.waverec2(there, wavelet(name), "symmetric")[:131], picture, atol=1e-9)


@pytest.mark.parametrize("name", WAVELETS)
def test_coefficients_hold_the_energy_of_the_picture(name):
    picture = np.random.default_rng(2).uniform(-1, 1, (128, 192))
    coefficients, _ = pywt.coeffs_to_array(pywt.wavedec2(picture, wavelet(name), "periodization", 2))
    assert np.sum(coefficients**2) == pytest.approx(np.sum(picture**2), rel=1e-10)


def test_an_unknown_wavelet_is_named():
    with pytest.raises(ValueError, match="'db3' is none of db2, "):
        wavelet("db3")
