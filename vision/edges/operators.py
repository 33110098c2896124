"""Edges by name: the structured forest and the classical operators behind one function."""

from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np
from cv2.typing import MatLike
from numpy.typing import NDArray
from skimage import filters

from vision.edges.forest.features import PATCH_PX
from vision.edges.forest.inference import EdgeDetector, shipped_detector
from vision.edges.thinning import NORMAL_REACH_PX, ridge_normals
from vision.pictures import check_shape

EdgeMethod = Literal["forest", "sobel", "prewitt", "roberts", "canny"]

EDGE_METHODS: tuple[EdgeMethod, ...] = get_args(EdgeMethod)

CANNY_PAIR = (0.02, 0.05)  # low and high threshold, parts of the picture's steepest gradient
CANNY_SIGMA_PX = 2**0.5  # smoothing before the gradient is taken
_CANNY_FULL_SCALE = 16_000  # of gradients as int16; the sum of two squares fits 32 bits
_FLAT = 1e-3  # steepest gradient, of Sobel's unscaled mask, that rounding alone may leave

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


def detect_edges(image: Image, method: EdgeMethod, columns: slice = slice(None)) -> EdgeMap:
    """Edge strength and direction by one of `EDGE_METHODS`.

    Parameters
    ----------
    image : ndarray of float32, shape (rows, columns) or (rows, columns, 3)
        Grey or red-green-blue, 0 to 1, at least 32 x 32. The classical operators take the grey value of coloured
        pictures.
    method : {"forest", "sobel", "prewitt", "roberts", "canny"}
        Sobel, Prewitt and Roberts give the gradient's magnitude by eq. 2.1 to 2.3 of the dissertation, scaled so that
        no picture can exceed 1; Canny (algorithm 1) gives 0 or 1 with the pair `CANNY_PAIR`; the forest gives the share
        of its trees' votes.
    columns : slice
        Columns that are wanted, without a step. The forest looks at no more of the picture than these need.

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
    if method not in EDGE_METHODS:
        raise ValueError(f"method: {method!r} is none of {', '.join(EDGE_METHODS)}")
    image = checked_image(image)
    if method == "forest":
        whole = columns.indices(image.shape[1])[:2] == (0, image.shape[1])
        # a strip is not worth a second thread: whoever wants several has them looked at side by side
        return forest_edges(shipped_detector() if whole else shipped_detector(1), image, columns)
    grey = grey_of(image)
    whole = canny(grey, *CANNY_PAIR) if method == "canny" else _gradient_edges(grey, method)
    return EdgeMap(whole.strength[:, columns], whole.normal_rad[:, columns])


def grey_of(image: Image) -> Image:
    """What the classical operators take of a picture: its grey value, 0.299 R + 0.587 G + 0.114 B."""
    return image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.float32)


def forest_edges(detector: EdgeDetector, image: Image, columns: slice = slice(None)) -> EdgeMap:
    """Edges by a forest; strength is the share of trees that vote for an edge, half of what the detector gives."""
    first, end, _ = columns.indices(image.shape[1])
    around = slice(max(0, first - NORMAL_REACH_PX), end + NORMAL_REACH_PX)  # what directions at the borders depend on
    (votes,) = detector.strength_in(image, [(slice(None), around)])
    strength = np.minimum(np.float32(0.5) * votes, np.float32(1))
    wanted = slice(first - around.start, end - around.start)
    return EdgeMap(strength[:, wanted], ridge_normals(strength)[:, wanted])


def canny(grey: Image, low: float, high: float) -> EdgeMap:
    """Canny's edges: strength 1 where a ridge of the gradient passes both thresholds, else 0.

    Parameters
    ----------
    grey : ndarray of float32, shape (rows, columns)
        0 to 1.
    low, high : float
        Parts of the steepest gradient in the picture: where a ridge begins, and how far it is followed.

    Returns
    -------
    EdgeMap
    """
    smooth = cv2.GaussianBlur(grey, (0, 0), CANNY_SIGMA_PX)
    dx = cv2.Sobel(smooth, cv2.CV_32F, 1, 0)
    dy = cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    steepest = max(float(cv2.magnitude(dx, dy).max()), _FLAT)
    across, down = (np.rint(np.asarray(part) * (_CANNY_FULL_SCALE / steepest)).astype(np.int16) for part in (dx, dy))
    edges = cv2.Canny(across, down, low * _CANNY_FULL_SCALE, high * _CANNY_FULL_SCALE, L2gradient=True)
    return EdgeMap((edges > 0).astype(np.float32), _direction(dx, dy))


def checked_image(image: Image) -> Image:
    """The picture itself when it is one.

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
