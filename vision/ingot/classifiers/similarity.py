"""Similarity of an ingot's end and a reference: structural similarity, eq. 6.1 to 6.3 (doi:10.1109/TIP.2003.819861)."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from skimage.metrics import structural_similarity

from vision.pictures import check_shape, grey

Picture = NDArray[np.uint8]

SIZE = 64  # chosen: rows and columns of ends and references when they are compared
WINDOW_SIGMA_PX = 1.5  # standard deviation of the Gaussian window (doi:10.1109/TIP.2003.819861)
WINDOW_TRUNCATION_SIGMAS = 3.5  # of the Gaussian window, as in scikit-image
DATA_RANGE = 255.0
C1, C2 = (0.01 * DATA_RANGE) ** 2, (0.03 * DATA_RANGE) ** 2


class Exponents(NamedTuple):
    """Weights alpha, beta, gamma of luminance, contrast and structure in eq. 6.1."""

    luminance: float = 1.0
    contrast: float = 1.0
    structure: float = 1.0


ONES = Exponents()

_across = (np.arange(SIZE) - (SIZE - 1) / 2) / (SIZE / 2)
_circle = (np.hypot(_across[:, None], _across) <= 1).astype(np.uint8)


class Comparison(NamedTuple):
    """How an end is compared with the references.

    Attributes
    ----------
    exponents : Exponents
        Of eq. 6.1.
    circular : bool
        Whether everything outside the end's circle is black in both pictures (figures 6.10 and 6.11); else the square
        is compared.
    threshold : float
        Of the classifier "single": a top is more similar than that to the reference top.
    """

    exponents: Exponents = ONES
    circular: bool = False
    threshold: float = 0.75


USUAL_COMPARISON = Comparison()


def circular(picture: Picture) -> Picture:
    """A picture that is black outside the circle that touches its sides.

    Parameters
    ----------
    picture : ndarray of uint8, shape (64, 64)
    """
    return np.asarray(picture * _circle, np.uint8)


def as_reference(picture: Picture) -> Picture:
    """A picture as it is compared: grey, 64 x 64.

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)

    Returns
    -------
    ndarray of uint8, shape (64, 64)

    Raises
    ------
    ValueError
        `picture` has another shape.
    """
    check_shape("picture", picture)
    pixels = grey(picture)
    if pixels.shape != (SIZE, SIZE):
        pixels = cv2.resize(pixels, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
    return np.asarray(pixels, np.uint8)


def similarity(image: Picture, reference: Picture, exponents: Exponents = ONES) -> float:
    """Structural similarity S, eq. 6.1, with the usual constants against division by zero.

    Parameters
    ----------
    image, reference : ndarray of uint8, shape (64, 64)
        As `end_image` and `as_reference` give them.
    exponents : Exponents
        With all three 1 scikit-image computes S. A negative structure term with a fractional exponent counts 0.

    Returns
    -------
    float
        Mean over the picture, -1 to 1; 1 for equal pictures.

    Raises
    ------
    ValueError
        The shapes differ; an exponent is negative, or all three are 0.
    """
    if image.shape != reference.shape:
        raise ValueError(f"image has shape {image.shape}, reference {reference.shape}; make them equal")
    if min(exponents) < 0 or max(exponents) == 0:
        raise ValueError(f"exponents must not be negative, and not all 0, got {tuple(exponents)}")
    if exponents == ONES:
        s = structural_similarity(
            image,
            reference,
            gaussian_weights=True,
            sigma=WINDOW_SIGMA_PX,
            data_range=DATA_RANGE,
            use_sample_covariance=False,
        )
        return float(np.float64(s))  # pyright: ignore[reportArgumentType]  with gradients it gives more
    margin = int(WINDOW_TRUNCATION_SIGMAS * WINDOW_SIGMA_PX + 0.5)
    s_map = similarity_map(image, reference, exponents)
    return float(s_map[margin:-margin, margin:-margin].mean())


def similarity_map(image: Picture, reference: Picture, exponents: Exponents) -> NDArray[np.float64]:
    """S around every pixel, the product of its three terms.

    Parameters
    ----------
    image, reference : ndarray of uint8, shape (64, 64)
    exponents : Exponents
        See `similarity`.

    Returns
    -------
    ndarray of float64, shape (64, 64)
    """
    a, b = image.astype(float), reference.astype(float)
    mu_a, mu_b = _around(a), _around(b)
    variance_a = np.maximum(_around(a * a) - mu_a**2, 0)
    variance_b = np.maximum(_around(b * b) - mu_b**2, 0)
    sigma_a_sigma_b = np.sqrt(variance_a * variance_b)
    luminance = (2 * mu_a * mu_b + C1) / (mu_a**2 + mu_b**2 + C1)
    contrast = (2 * sigma_a_sigma_b + C2) / (variance_a + variance_b + C2)
    structure = (_around(a * b) - mu_a * mu_b + C2 / 2) / (sigma_a_sigma_b + C2 / 2)
    if exponents.structure % 1:
        structure = np.maximum(structure, 0)
    return luminance**exponents.luminance * contrast**exponents.contrast * structure**exponents.structure


def _around(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(gaussian_filter(values, WINDOW_SIGMA_PX, truncate=WINDOW_TRUNCATION_SIGMAS, mode="reflect"))


def dissimilarity(s: float, c0: float = 1.0) -> float:
    """D = c0 / S - 1, eq. 6.2, and with S from `similarity` eq. 6.3; infinite where S <= 0.

    Parameters
    ----------
    s : float
        Similarity.
    c0 : float
        Largest similarity.
    """
    return c0 / s - 1 if s > 0 else math.inf
