"""Wavelets by name: Daubechies' from PyWavelets, and those of Fejer and Korovkin, which it does not have.

An fk filter of N coefficients is the minimum phase factor of a half-band gain whose Fourier series is damped by the
Fejer-Korovkin kernel: M. Nielsen, On the construction and frequency localization of finite orthogonal quadrature
filters, J. Approx. Theory 108 (2001) 36-52. The order of the kernel is n = N, but n = 3 for N = 4, where n = 4 would
give db2. A test derives the numbers anew.
"""

from functools import cache
from typing import Any, Literal, get_args

import pywt

WaveletName = Literal["db2", "db4", "db8", "db16", "fk4", "fk6", "fk8", "fk18"]

_Wavelet: Any = pywt.Wavelet  # pyright: ignore[reportAttributeAccessIssue]  compiled, and without stubs

WAVELETS: tuple[WaveletName, ...] = get_args(WaveletName)

FEJER_KOROVKIN: dict[str, tuple[float, ...]] = {
    "fk4": (0.653927551502433, 0.7532724962889091, 0.05317922968411453, -0.04616571510236161),
    "fk6": (
        *(0.4279150202839754, 0.8129196443541133, 0.35636952280358636),
        *(-0.14643867874320485, -0.07717776190101418, 0.04062581557563907),
    ),
    "fk8": (
        *(0.3492140468509178, 0.7826778145736836, 0.4752921234301978, -0.0996706950058189),
        *(-0.15998657439543107, 0.04310114990157858, 0.04258718530086304, -0.019001488282895752),
    ),
    "fk18": (
        *(0.2214447453136865, 0.6335505315898576, 0.6509884058593036, 0.1423554391412191, -0.24619635447999066),
        *(-0.11362823254865634, 0.12784674502791396, 0.0707063769819612, -0.07523961207296669, -0.03972596505712651),
        *(0.045936081238799366, 0.018696757224015512, -0.02663246557833437, -0.006157985650627823),
        *(0.013639364044389375, -0.0003259844215095766, -0.004680128166253553, 0.0016358439274143924),
    ),
}
"""Scaling filters (reconstruction low-pass), sum sqrt 2."""


@cache
def wavelet(name: WaveletName) -> Any:
    """Orthogonal wavelet of a name.

    Parameters
    ----------
    name : {"db2", "db4", "db8", "db16", "fk4", "fk6", "fk8", "fk18"}
        dbK is PyWavelets' and has 2 K coefficients; fkN has N.

    Returns
    -------
    pywt.Wavelet

    Raises
    ------
    ValueError
        `name` is none of `WAVELETS`.
    """
    if name not in WAVELETS:
        raise ValueError(f"name: {name!r} is none of {', '.join(WAVELETS)}")
    if name in FEJER_KOROVKIN:
        return _Wavelet(name, filter_bank=pywt.orthogonal_filter_bank(FEJER_KOROVKIN[name]))
    return _Wavelet(name)
