"""Edges by name: the structured forest and the classical operators behind one function.

Examples
--------
A step of light between columns 31 and 32 is an upright edge; its direction is across it, along x:

>>> import numpy as np
>>> from vision.edges.operators import detect_edges
>>> image = np.zeros((64, 64), np.float32)
>>> image[:, 32:] = 1.0
>>> edges = detect_edges(image, "sobel")
>>> np.flatnonzero(edges.strength[30]).tolist()
[31, 32]
>>> edges.normal_rad[30, 32].item()
0.0
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import cv2
import numpy as np
from cv2.typing import MatLike
from numpy.typing import NDArray
from skimage import filters

from vision.edges.forest.features import PATCH_PX
from vision.edges.forest.inference import EdgeDetector, shipped_detector
from vision.edges.forest.model import StructuredForest
from vision.edges.names import CANNY_KERNELS, EDGE_METHODS, CannyKernel, EdgeMethod
from vision.edges.thinning import NORMAL_REACH_PX, ridge_normals
from vision.pictures import check_shape

CANNY_THRESHOLDS = (0.02, 0.05)  # low, high: shares of the steepest gradient (dissertation, printed as 0.02 and 0.5)
CANNY_SIGMA_PX = 2**0.5  # chosen: Gaussian smoothing before the gradient
PRINTED_SIGMA_PX = 1.0  # of the kernels in eq. 2.5 and 2.6
_CANNY_FULL_SCALE = 16_000  # steepest gradient as int16, so that a sum of two squares fits 32 bits
_SMOOTHING = {"gaussian": (0, CANNY_SIGMA_PX), "3x3": (3, PRINTED_SIGMA_PX), "5x5": (5, PRINTED_SIGMA_PX)}
_FLAT_GRADIENT = 1e-3  # chosen: Sobel gradients below it, before scaling, are rounding and no edge

Image = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class EdgeMap:
    """How strong an edge is at each pixel, and which way it faces.

    Attributes
    ----------
    strength : ndarray of float32, shape (rows, columns)
        0 to 1.
    normal_rad : ndarray of float32, shape (rows, columns)
        Direction across the edge, in [0, pi): 0 is along x, pi / 2 along y.
    """

    strength: Image
    normal_rad: Image


@dataclass(frozen=True, slots=True, kw_only=True)
class EdgeOptions:
    """An edge detector with numbers or a model of its own.

    Attributes
    ----------
    method : {"forest", "sobel", "prewitt", "roberts", "canny"}
    forest : StructuredForest or None
        Model of "forest"; None: the shipped one.
    canny_low, canny_high : float
        Thresholds of "canny", shares of the steepest gradient.
    canny_kernel : {"gaussian", "3x3", "5x5"}
        Smoothing of "canny": `CANNY_SIGMA_PX`, or the kernels of eq. 2.5 and 2.6.
    """

    method: EdgeMethod = "forest"
    forest: StructuredForest | None = None
    canny_low: float = CANNY_THRESHOLDS[0]
    canny_high: float = CANNY_THRESHOLDS[1]
    canny_kernel: CannyKernel = "gaussian"

    def __post_init__(self) -> None:
        if self.method not in EDGE_METHODS:
            raise ValueError(f"edges: {self.method!r} is none of {', '.join(EDGE_METHODS)}")
        if not 0 < self.canny_low <= self.canny_high < 1:
            raise ValueError(
                f"canny_low, canny_high: 0 < low <= high < 1 wanted, got {self.canny_low}, {self.canny_high}"
            )
        if self.canny_kernel not in CANNY_KERNELS:
            raise ValueError(f"canny_kernel: {self.canny_kernel!r} is none of {', '.join(CANNY_KERNELS)}")


Edges = EdgeMethod | EdgeOptions


def detect_edges(image: Image, method: Edges, columns: slice = slice(None)) -> EdgeMap:
    """Edge strength and direction by one of `EDGE_METHODS`.

    Parameters
    ----------
    image : ndarray of float32, shape (rows, columns) or (rows, columns, 3)
        Grey or red-green-blue, 0 to 1, at least 32 x 32. The classical operators take the grey value of coloured
        pictures.
    method : {"forest", "sobel", "prewitt", "roberts", "canny"} or EdgeOptions
        Sobel, Prewitt and Roberts give the gradient's magnitude by eq. 2.1 to 2.3 of the dissertation, scaled so that
        no picture can exceed 1; Canny (algorithm 1) gives 0 or 1 with `CANNY_THRESHOLDS`; the forest gives the share
        of its trees' votes.
    columns : slice
        Columns for which edges are returned, without a step. The forest reads only the part of the picture that
        influences them.

    Returns
    -------
    EdgeMap
        Of the wanted columns, bit by bit as cut out of the whole picture's.

    Raises
    ------
    ValueError
        `method` is unknown; `image` has another type or shape, is empty or too small, or holds values that are not
        numbers from 0 to 1; there are no such columns.
    """
    options = method if isinstance(method, EdgeOptions) else EdgeOptions(method=method)
    image = checked_image(image)
    if options.method == "forest":
        whole = columns.indices(image.shape[1])[:2] == (0, image.shape[1])
        # A second thread does not pay for a strip; callers with several strips detect them in parallel.
        return forest_edges(_detector(options.forest, 2 if whole else 1), image, columns)
    grey = grey_of(image)
    if options.method == "canny":
        whole = canny(grey, options.canny_low, options.canny_high, options.canny_kernel)
    else:
        whole = _gradient_edges(grey, options.method)
    return EdgeMap(whole.strength[:, columns], whole.normal_rad[:, columns])


@lru_cache(maxsize=4)
def _detector(forest: StructuredForest | None, threads: int) -> EdgeDetector:
    return shipped_detector(threads) if forest is None else EdgeDetector(forest, threads)


def grey_of(image: Image) -> Image:
    """Grey value of a red-green-blue picture for the classical operators: 0.299 R + 0.587 G + 0.114 B."""
    return image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.float32)


def forest_edges(detector: EdgeDetector, image: Image, columns: slice = slice(None)) -> EdgeMap:
    """Edges by a structured forest.

    Parameters
    ----------
    detector : EdgeDetector
    image : ndarray of float32, shape (rows, columns) or (rows, columns, 3)
        Grey or red-green-blue, 0 to 1.
    columns : slice
        Columns for which edges are returned, without a step.

    Returns
    -------
    EdgeMap
        Strength is the share of trees that vote for an edge, half of `EdgeDetector.strength`.
    """
    first, end, _ = columns.indices(image.shape[1])
    around = slice(max(0, first - NORMAL_REACH_PX), end + NORMAL_REACH_PX)  # directions at the borders depend on it
    (votes,) = detector.strength_in(image, [(slice(None), around)])
    strength = np.minimum(np.float32(0.5) * votes, np.float32(1))
    wanted = slice(first - around.start, end - around.start)
    return EdgeMap(strength[:, wanted], ridge_normals(strength)[:, wanted])


def canny(grey: Image, low: float, high: float, kernel: CannyKernel = "gaussian") -> EdgeMap:
    """Canny's edges: strength 1 where a ridge of the gradient passes both thresholds, else 0.

    Parameters
    ----------
    grey : ndarray of float32, shape (rows, columns)
        0 to 1.
    low, high : float
        Thresholds as shares of the steepest gradient in the picture: a ridge begins above `high` and is followed down
        to `low`.
    kernel : {"gaussian", "3x3", "5x5"}
        See `EdgeOptions`.

    Returns
    -------
    EdgeMap
    """
    smooth = smoothed(grey, kernel)
    dx = cv2.Sobel(smooth, cv2.CV_32F, 1, 0)
    dy = cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    steepest = max(float(cv2.magnitude(dx, dy).max()), _FLAT_GRADIENT)
    across, down = (np.rint(np.asarray(part) * (_CANNY_FULL_SCALE / steepest)).astype(np.int16) for part in (dx, dy))
    edges = cv2.Canny(across, down, low * _CANNY_FULL_SCALE, high * _CANNY_FULL_SCALE, L2gradient=True)
    return EdgeMap((edges > 0).astype(np.float32), _direction(dx, dy))


def smoothed(grey: Image, kernel: CannyKernel) -> Image:
    """Grey picture after the first step of Canny's algorithm.

    Parameters
    ----------
    grey : ndarray of float32, shape (rows, columns)
    kernel : {"gaussian", "3x3", "5x5"}
        See `EdgeOptions`.

    Returns
    -------
    ndarray of float32, shape (rows, columns)
    """
    side, sigma_px = _SMOOTHING[kernel]
    return np.asarray(cv2.GaussianBlur(grey, (side, side), sigma_px), np.float32)


def checked_image(image: Image) -> Image:
    """Return the picture if it is one that edges can be detected in.

    Raises
    ------
    ValueError
        As `detect_edges`.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.float32:
        raise ValueError(f"image: float32 wanted, got {getattr(image, 'dtype', type(image).__name__)}")
    check_shape("image", image)
    if min(image.shape[:2]) < PATCH_PX:
        raise ValueError(f"image: at least {PATCH_PX} rows and columns wanted, got shape {image.shape}")
    if not (image.min() >= 0 and image.max() <= 1):  # NaN fails both
        raise ValueError("image: values from 0 to 1 wanted, without NaN")
    return image


def _gradient_edges(grey: Image, method: Literal["sobel", "prewitt", "roberts"]) -> EdgeMap:
    if method == "roberts":
        falling, rising = filters.roberts_pos_diag(grey), filters.roberts_neg_diag(grey)
        dx, dy = (falling - rising) / np.sqrt(2), (falling + rising) / np.sqrt(2)
    elif method == "sobel":
        dx, dy = filters.sobel_v(grey), filters.sobel_h(grey)
    else:
        dx, dy = filters.prewitt_v(grey), filters.prewitt_h(grey)
    return EdgeMap((np.hypot(dx, dy) / np.sqrt(2)).astype(np.float32), _direction(dx, dy))


def _direction(dx: MatLike, dy: MatLike) -> Image:
    """Gradient's direction folded to [0, pi)."""
    angle = np.arctan2(dy, dx).astype(np.float32) % np.float32(np.pi)
    return np.where(angle >= np.float32(np.pi), np.float32(0), angle)
