"""The dissertation's seven figures of merit of a fused picture (section 5.1.3), none of which needs a true one.

The dissertation only names three of them: each definition here says what was chosen. A better figure of merit does not
make a better measurement (docs/methods/fusion.md).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Array = NDArray[np.float64]

BLOCK_PX = 16
DIRECTIONS = 8
C1, C2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2  # of SSIM
C3 = C2 / 2


def entropy(picture: Picture) -> float:
    """H, eq. 5.2: H = - sum P_i log2 P_i over the 256 code values, bits per pixel.

    Range 0 (one value) to 8 (all values alike often); larger is held to be better. Noise raises it too.
    """
    return _entropy(np.bincount(_checked("picture", picture).ravel(), minlength=256))


def standard_deviation(picture: Picture) -> float:
    """SD, eq. 5.3: root of the mean squared distance from the mean, code values.

    Range 0 to 127.5; larger is held to be better.
    """
    return float(np.std(_checked("picture", picture)))


def spatial_frequency(picture: Picture) -> float:
    """SF, eq. 5.4: SF = sqrt(RF^2 + CF^2), code values.

    RF^2 and CF^2 are the sums of squared differences of neighbours within rows and within columns over the number of
    pixels (Eskicioglu and Fisher 1995, https://doi.org/10.1109/26.477498). Range 0 to 361; larger is held to be better.
    """
    f = _checked("picture", picture).astype(np.float64)
    squares = np.sum(np.diff(f, axis=1) ** 2) + np.sum(np.diff(f, axis=0) ** 2)
    return float(np.sqrt(squares / f.size))


def average_gradient(picture: Picture) -> float:
    """AG, eq. 5.5: mean of G / sqrt 2, G the length of the forward differences to the right and below, code values.

    Range 0 to 255; larger is held to be better. NaN for a picture of a single row or column, which has no such pixel.
    """
    f = _checked("picture", picture).astype(np.float64)
    if min(f.shape) < 2:
        return float("nan")
    right, below = f[:-1, 1:] - f[:-1, :-1], f[1:, :-1] - f[:-1, :-1]
    return float(np.mean(np.hypot(right, below)) / np.sqrt(2))


def feature_mutual_information(fused: Picture, left: Picture, right: Picture) -> float:
    """FMI, eq. 5.6, normalised: I(A, F) / (H_A + H_F) + I(B, F) / (H_B + H_F).

    The features are magnitudes of Sobel's gradient, rounded to 256 steps of their largest possible value; I and H are
    those of their joint and single histograms. The dissertation's equation lacks the denominators, but its values lie
    below 1; they are those of Haghighat et al. 2011 (https://doi.org/10.1016/j.compeleceng.2011.07.012), whose joint
    distributions are of another kind, so values compare within one table only. Range 0 (nothing in common) to 1 (F, A
    and B have the same features); larger is better. Two pictures without any gradient have all in common: 1/2.

    Parameters
    ----------
    fused, left, right : ndarray of uint8, shape (rows, columns)
        Grey.

    Raises
    ------
    ValueError
        A picture is no grey uint8 picture, or their shapes differ.
    """
    _check_alike(fused, left, right)
    feature = [_gradient_steps(picture) for picture in (fused, left, right)]
    return _shared(feature[0], feature[1]) + _shared(feature[0], feature[2])


def sum_of_correlations_of_differences(fused: Picture, left: Picture, right: Picture) -> float:
    """SCD, eq. 5.7: r(F - S2, S1) + r(F - S1, S2), r the correlation over all pixels.

    What F has beyond one view should look like the other (Aslantas and Bendes 2015,
    https://doi.org/10.1016/j.aeue.2015.09.004; the dissertation pairs each view with its own difference, which cannot
    give its positive values). Range -2 to 2; larger is better. A difference or a view without any contrast correlates
    with nothing: 0.

    Parameters
    ----------
    fused, left, right : ndarray of uint8, shape (rows, columns)
        Grey.

    Raises
    ------
    ValueError
        A picture is no grey uint8 picture, or their shapes differ.
    """
    _check_alike(fused, left, right)
    F, first, second = (picture.astype(np.float64) for picture in (fused, left, right))
    return _correlation(F - second, first) + _correlation(F - first, second)


def printed_feature_mutual_information(fused: Picture, left: Picture, right: Picture) -> float:
    """FMI as eq. 5.6 prints it: I(A, F) + I(B, F), bit, of the features of `feature_mutual_information`.

    Range 0 to 16; larger is better. The dissertation's values, 0.96 for every method, look normalised.

    Parameters
    ----------
    fused, left, right : ndarray of uint8, shape (rows, columns)
        Grey.

    Raises
    ------
    ValueError
        A picture is no grey uint8 picture, or their shapes differ.
    """
    _check_alike(fused, left, right)
    feature = [_gradient_steps(picture) for picture in (fused, left, right)]
    return _in_common(feature[0], feature[1])[0] + _in_common(feature[0], feature[2])[0]


def printed_sum_of_correlations(fused: Picture, left: Picture, right: Picture) -> float:
    """SCD as eq. 5.7 prints it: r(F - S1, S1) + r(F - S2, S2), each view with its own difference.

    Range -2 to 2. What a view lacks correlates negatively with it, so that these values are mostly below 0 and the
    dissertation's, which are not, are not of this equation.

    Parameters
    ----------
    fused, left, right : ndarray of uint8, shape (rows, columns)
        Grey.

    Raises
    ------
    ValueError
        A picture is no grey uint8 picture, or their shapes differ.
    """
    _check_alike(fused, left, right)
    F, first, second = (picture.astype(np.float64) for picture in (fused, left, right))
    return _correlation(F - first, first) + _correlation(F - second, second)


def printed_edge_dissimilarity(fused: Picture, left: Picture, right: Picture) -> float:
    """N_ESSIM as eq. 5.9 prints it, with its factor of 1000; see `edge_dissimilarity`.

    Parameters
    ----------
    fused, left, right : ndarray of uint8, shape (rows, columns)
        Grey.

    Raises
    ------
    ValueError
        A picture is no grey uint8 picture, or their shapes differ.
    """
    return 1000.0 * edge_dissimilarity(fused, left, right)


def edge_dissimilarity(fused: Picture, left: Picture, right: Picture) -> float:
    """N_ESSIM, eq. 5.9 without its factor of 1000, which the dissertation's values do not have either.

    1 - (ESSIM(S1, F) + ESSIM(S2, F)) / 2; see `essim`. Range 0 (all alike) to 2; SMALLER is better.

    Parameters
    ----------
    fused, left, right : ndarray of uint8, shape (rows, columns)
        Grey.

    Raises
    ------
    ValueError
        A picture is no grey uint8 picture, or their shapes differ.
    """
    _check_alike(fused, left, right)
    return 1.0 - 0.5 * (essim(left, fused) + essim(right, fused))


def essim(first: Picture, second: Picture) -> float:
    """Edge-based structural similarity, eq. 5.8: mean of l c e over blocks of 16 x 16 pixels.

    l and c are SSIM's comparisons of luminance and contrast, with its constants and population variances; e compares
    edges in place of structure (Chen, Yang, Xie 2006, https://doi.org/10.1109/ICASSP.2006.1660497): with E the
    histogram of a block's directions of Sobel's gradient in 8 bins over 180 degrees, each pixel counting its
    gradient's magnitude, divided by the number of pixels, e = (cov(E1, E2) + C3) / (sd(E1) sd(E2) + C3). Blocks at the
    right and lower border that are not whole are left out, but a picture smaller than a block is one block. Range -1
    to 1; 1 for equal pictures.

    Parameters
    ----------
    first, second : ndarray of uint8, shape (rows, columns)
        Grey.

    Raises
    ------
    ValueError
        A picture is no grey uint8 picture, or their shapes differ.
    """
    _check_alike(first, second)
    block = min(BLOCK_PX, first.shape[0]), min(BLOCK_PX, first.shape[1])
    x, y = (_blocks(picture.astype(np.float64), block) for picture in (first, second))
    mx, my = x.mean(axis=1), y.mean(axis=1)
    vx, vy = x.var(axis=1), y.var(axis=1)
    luminance = (2 * mx * my + C1) / (mx**2 + my**2 + C1)
    contrast = (2 * np.sqrt(vx * vy) + C2) / (vx + vy + C2)
    Ex, Ey = (_direction_histograms(picture, block) for picture in (first, second))
    dx, dy = (E - E.mean(axis=1, keepdims=True) for E in (Ex, Ey))
    covariance = (dx * dy).mean(axis=1)
    deviations = np.sqrt((dx**2).mean(axis=1) * (dy**2).mean(axis=1))
    edges = (covariance + C3) / (deviations + C3)
    return float(np.mean(luminance * contrast * edges))


@dataclass(frozen=True, slots=True)
class Metric:
    """One row of the table of metrics.

    Attributes
    ----------
    symbol : str
        As in the dissertation's table 5.1.
    text : str
    larger_is_better : bool
    of_one : callable or None
        Of any picture; None for what compares the fused picture with both views.
    of_fused : callable or None
        Of the fused picture, the left and the right view; None for what any single picture has.
    """

    symbol: str
    text: str
    larger_is_better: bool
    of_one: Callable[[Picture], float] | None = None
    of_fused: Callable[[Picture, Picture, Picture], float] | None = None

    def measure(self, fused: Picture, left: Picture, right: Picture) -> float:
        """Value of a fused picture.

        Parameters
        ----------
        fused, left, right : ndarray of uint8, shape (rows, columns)
            Grey.
        """
        if self.of_fused is not None:
            return self.of_fused(fused, left, right)
        assert self.of_one is not None  # noqa: S101  a row has one of both
        return self.of_one(fused)


PRINTED_METRICS: tuple[Metric, ...] = (
    Metric("FMI", "eq. 5.6 as printed, bit", True, of_fused=printed_feature_mutual_information),
    Metric("SCD", "eq. 5.7 as printed", True, of_fused=printed_sum_of_correlations),
    Metric("ESSIM", "eq. 5.9 as printed", False, of_fused=printed_edge_dissimilarity),
)

METRICS: tuple[Metric, ...] = (
    Metric("H", "entropy, bit per pixel", True, of_one=entropy),
    Metric("SD", "standard deviation", True, of_one=standard_deviation),
    Metric("SF", "spatial frequency", True, of_one=spatial_frequency),
    Metric("AG", "average gradient", True, of_one=average_gradient),
    Metric("FMI", "feature mutual information", True, of_fused=feature_mutual_information),
    Metric("SCD", "sum of correlations of differences", True, of_fused=sum_of_correlations_of_differences),
    Metric("ESSIM", "edge dissimilarity", False, of_fused=edge_dissimilarity),
)


def _checked(name: str, picture: NDArray[Any]) -> Picture:
    if picture.dtype != np.uint8 or picture.ndim != 2 or picture.size == 0:
        raise ValueError(f"{name}: a grey uint8 picture is needed, not {picture.dtype} of shape {picture.shape}")
    return picture


def _check_alike(first: Picture, *others: Picture) -> None:
    _checked("first picture", first)
    for other in others:
        if _checked("other picture", other).shape != first.shape:
            raise ValueError(f"pictures must be alike in shape, not {first.shape} and {other.shape}")


def _entropy(count: NDArray[np.int64]) -> float:
    P = count[count > 0] / count.sum()
    return float(-(P @ np.log2(P))) + 0.0  # no minus before zero


def _sobel(picture: Picture) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    x, y = (cv2.Sobel(picture, cv2.CV_32F, *order, borderType=cv2.BORDER_REPLICATE) for order in ((1, 0), (0, 1)))
    return np.asarray(x, dtype=np.float32), np.asarray(y, dtype=np.float32)


def _gradient_steps(picture: Picture) -> NDArray[np.int64]:
    largest = 4 * 255 * np.sqrt(2)
    return np.rint(np.hypot(*_sobel(picture)) * (255 / largest)).astype(np.int64).ravel()


def _shared(first: NDArray[np.int64], second: NDArray[np.int64]) -> float:
    """I / (H_1 + H_2), 0 to 1/2."""
    common, both = _in_common(first, second)
    return common / both if both > 0.0 else 0.5


def _in_common(first: NDArray[np.int64], second: NDArray[np.int64]) -> tuple[float, float]:
    """I and H_1 + H_2, bit."""
    joint = np.bincount(256 * first + second, minlength=256 * 256)
    of_first, of_second = (_entropy(joint.reshape(256, 256).sum(axis=axis)) for axis in (1, 0))
    both = of_first + of_second
    return both - _entropy(joint), both


def _correlation(first: Array, second: Array) -> float:
    a, b = first - first.mean(), second - second.mean()
    power = float(np.sqrt(np.vdot(a, a) * np.vdot(b, b)))
    return float(np.vdot(a, b)) / power if power > 1e-9 * a.size else 0.0


def _blocks(image: Array, block: tuple[int, int]) -> Array:
    """Whole blocks of an image, shape (blocks, pixels)."""
    down, across = image.shape[0] // block[0], image.shape[1] // block[1]
    whole = image[: down * block[0], : across * block[1]].reshape(down, block[0], across, block[1])
    return whole.transpose(0, 2, 1, 3).reshape(down * across, block[0] * block[1])


def _direction_histograms(picture: Picture, block: tuple[int, int]) -> Array:
    """Gradient magnitude per pixel in each direction, shape (blocks, DIRECTIONS)."""
    x, y = (_blocks(part.astype(np.float64), block) for part in _sobel(picture))
    direction = np.floor(np.mod(np.arctan2(y, x), np.pi) * (DIRECTIONS / np.pi)).astype(np.int64) % DIRECTIONS
    at = DIRECTIONS * np.arange(len(x))[:, None] + direction
    histogram = np.bincount(at.ravel(), np.hypot(x, y).ravel(), minlength=DIRECTIONS * len(x))
    return histogram.reshape(len(x), DIRECTIONS) / x.shape[1]
