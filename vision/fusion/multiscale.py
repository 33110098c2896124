"""Fusion scale by scale: details by a rule, the smallest picture averaged or by the same rule."""

from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import cv2
import numpy as np
import pywt
from numpy.typing import NDArray

from vision.fusion.rules import Rule, fuse_coefficients
from vision.fusion.wavelets import WaveletName, wavelet

Planes = NDArray[np.float32]
Approximation = Literal["average", "larger"]

RULES: tuple[Rule, ...] = ("larger", "weighted")
APPROXIMATIONS: tuple[Approximation, ...] = ("average", "larger")
BORDER = "symmetric"  # mirrored, so that borders are no edges


@dataclass(frozen=True, slots=True)
class Scales:
    """How coefficients of two views become those of one.

    Attributes
    ----------
    levels : int
        How often the picture is halved, at least 1; a small picture is halved less often, down to not at all.
    rule : {"larger", "weighted"}
        For details; see `fuse_coefficients`.
    approximation : {"average", "larger"}
        For the smallest picture, below the last level of details.

    Raises
    ------
    ValueError
        A value is none of those.
    """

    levels: int = 4
    rule: Rule = "larger"
    approximation: Approximation = "average"

    def __post_init__(self) -> None:
        if self.levels < 1:
            raise ValueError(f"levels: {self.levels} is less than 1")
        if self.rule not in RULES:
            raise ValueError(f"rule: {self.rule!r} is none of {', '.join(RULES)}")
        if self.approximation not in APPROXIMATIONS:
            raise ValueError(f"approximation: {self.approximation!r} is none of {', '.join(APPROXIMATIONS)}")

    def fuse_approximation(self, first: Planes, second: Planes) -> None:
        """Fuse the smallest pictures of both views into the first one.

        Parameters
        ----------
        first, second : ndarray of float32, same shape
            `first` becomes the fused one.
        """
        if self.approximation == "average":
            first += second
            first *= 0.5
        else:
            fuse_coefficients(first, second, "larger")


DEFAULT_SCALES = Scales()


def fuse_wavelets(
    left: Planes, right: Planes, name: WaveletName, scales: Scales, executor: Executor | None = None
) -> Planes:
    """Fuse two pictures by their discrete wavelet transforms (dissertation, section 5.1.2).

    Parameters
    ----------
    left, right : ndarray of float32, shape (channels, rows, columns)
    name : str
        One of `WAVELETS`.
    scales : Scales
    executor : Executor, optional
        Transforms both views at once.

    Returns
    -------
    ndarray of float32, shape (channels, rows, columns)
    """
    basis = wavelet(name)
    levels = min(scales.levels, pywt.dwtn_max_level(left.shape[1:], basis))

    def transformed(planes: Planes) -> list[Bands]:
        return [_analysed(plane, basis, levels) for plane in planes]

    rows, columns = left.shape[1:]
    fused: list[Planes] = []
    for first, second in zip(*(executor.map if executor else map)(transformed, (left, right)), strict=True):
        scales.fuse_approximation(first.approximation, second.approximation)
        for band, other in zip(first.details, second.details, strict=True):
            fuse_coefficients(band, other, scales.rule)
        fused.append(_synthesised(first, basis)[:rows, :columns])
    return np.stack(fused)


class Bands(NamedTuple):
    """Discrete wavelet transform of a picture."""

    approximation: Planes
    details: list[Planes]  # three a level, the finest level first


# PyWavelets takes twice as long along columns: their numbers do not lie one behind the other in memory. Transposed
# pictures have the same bits as `pywt.wavedec2` and `pywt.waverec2`.


def _analysed(plane: Planes, basis: Any, levels: int) -> Bands:
    details: list[Planes] = []
    for _ in range(levels):
        upper, lower = map(cv2.transpose, pywt.dwt(cv2.transpose(plane), basis, BORDER))
        halves: list[Any] = [*pywt.dwt(upper, basis, BORDER), *pywt.dwt(lower, basis, BORDER)]
        plane = halves[0]
        details += halves[1:]
    return Bands(plane if levels else plane.copy(), details)


def _synthesised(bands: Bands, basis: Any) -> Planes:
    plane, details = bands.approximation, bands.details.copy()
    while details:
        *details, beside, below, diagonal = details
        rows, columns = beside.shape  # a level of odd length comes back with one more
        upper = pywt.idwt(plane[:rows, :columns], beside, basis, BORDER)
        lower = pywt.idwt(below, diagonal, basis, BORDER)
        plane = np.asarray(cv2.transpose(pywt.idwt(cv2.transpose(upper), cv2.transpose(lower), basis, BORDER)))
    return plane


def fuse_pyramids(left: Planes, right: Planes, scales: Scales) -> Planes:
    """Fuse two pictures by their Laplacian pyramids (Burt and Adelson 1983, https://doi.org/10.1109/TCOM.1983.1095851).

    Parameters
    ----------
    left, right : ndarray of float32, shape (channels, rows, columns)
    scales : Scales

    Returns
    -------
    ndarray of float32, shape (channels, rows, columns)
    """
    return np.stack([_fused_pyramid(*planes, scales) for planes in zip(left, right, strict=True)])


def _fused_pyramid(left: Planes, right: Planes, scales: Scales) -> Planes:
    levels = min(scales.levels, int(np.log2(min(left.shape))))
    first, second = (_pyramid(plane, levels) for plane in (left, right))
    scales.fuse_approximation(first[-1], second[-1])
    for detail, other in zip(first[:-1], second[:-1], strict=True):
        fuse_coefficients(detail, other, scales.rule)
    picture = first.pop()
    while first:
        detail = first.pop()
        picture = detail + _enlarged(picture, detail)
    return picture


def _pyramid(plane: Planes, levels: int) -> list[Planes]:
    """Details of each scale, finest first, and the picture that is left."""
    details: list[Planes] = []
    for _ in range(levels):
        smaller = np.asarray(cv2.pyrDown(plane), dtype=np.float32)
        details.append(plane - _enlarged(smaller, plane))
        plane = smaller
    return [*details, plane.copy()]


def _enlarged(picture: Planes, like: Planes) -> Planes:
    return np.asarray(cv2.pyrUp(picture, dstsize=like.shape[::-1]), dtype=np.float32)
