"""Alignment of two views by what is in the pictures: the ways that chapters 2.3 and 4 name and reject.

All find pairs of places, in the left and in the right picture, that look alike; a homography is fitted to them robustly
(RANSAC). OpenCV and scikit-image do the work.
"""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple, get_args

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.feature import BRIEF, hog

Picture = NDArray[np.uint8]
Points = NDArray[np.float64]
FeatureMethod = Literal["ncc", "hog", "sift", "fast-brief", "orb"]
FEATURE_METHODS: tuple[FeatureMethod, ...] = get_args(FeatureMethod)

LOWE_RATIO = 0.75  # of the distances to the best and the second best match (doi:10.1023/B:VISI.0000029664.99615.94)
RANSAC_PX = 3.0  # chosen: pairs that lie further off the homography are no inliers
LEAST_PAIRS = 4  # of a homography
PATCH_PX, PATCH_STRIDE_PX = 33, 24  # chosen: squares of the left picture that NCC looks for in the right one
LEAST_CORRELATION = 0.8  # chosen
LEAST_CONTRAST = 6.0  # chosen: standard deviation of a square's code values under which it shows nothing
HOG_CELL_PX, HOG_BLOCK_CELLS, HOG_BINS = 8, 4, 9  # cells and bins of section 2.3.1; blocks chosen
BRIEF_PAIRS = 128  # n_d of figure 2.6
FAST_THRESHOLD = 12  # chosen: of algorithm 2, code values
MOST_FEATURES = 4000  # chosen


class FoundAlignment(NamedTuple):
    """What a method found.

    Attributes
    ----------
    right_to_left : ndarray of float64, shape (3, 3), or None
        None when too few pairs agree.
    pairs, inliers : int
        Places that look alike, and those that agree with the homography.
    """

    right_to_left: Points | None
    pairs: int
    inliers: int


def align_by_features(left: Picture, right: Picture, method: FeatureMethod) -> FoundAlignment:
    """Homography from the right to the left picture.

    Parameters
    ----------
    left, right : ndarray of uint8, shape (rows, columns)
        Grey, without lens distortion.
    method : {"ncc", "hog", "sift", "fast-brief", "orb"}
        Normalised cross-correlation of squares (eq. 2.15), histograms of gradients (eq. 2.16 to 2.20), SIFT
        (eq. 2.21 to 2.25), FAST corners with BRIEF (algorithms 2 and 3), ORB (eq. 2.26 to 2.28).

    Raises
    ------
    ValueError
        There is no such method.
    """
    if method not in FEATURE_METHODS:
        raise ValueError(f"method: {method!r} is none of {', '.join(FEATURE_METHODS)}")
    in_left, in_right = _PAIRS[method](left, right)
    if len(in_left) < LEAST_PAIRS:
        return FoundAlignment(None, len(in_left), 0)
    H, inliers = cv2.findHomography(in_right, in_left, cv2.RANSAC, RANSAC_PX)
    if H is None:  # pyright: ignore[reportUnnecessaryComparison]  OpenCV returns None where its stubs do not say so
        return FoundAlignment(None, len(in_left), 0)
    return FoundAlignment(np.asarray(H, dtype=np.float64), len(in_left), int(inliers.sum()))


def _by_squares(left: Picture, right: Picture) -> tuple[Points, Points]:
    """NCC: squares of the left picture where they correlate best with the right one."""
    pairs: list[tuple[float, float, float, float]] = []
    half = PATCH_PX // 2
    for top in range(0, left.shape[0] - PATCH_PX, PATCH_STRIDE_PX):
        for first in range(0, left.shape[1] - PATCH_PX, PATCH_STRIDE_PX):
            patch = left[top : top + PATCH_PX, first : first + PATCH_PX]
            if patch.std() < LEAST_CONTRAST:
                continue
            _, best, _, (x, y) = cv2.minMaxLoc(cv2.matchTemplate(right, patch, cv2.TM_CCOEFF_NORMED))
            if best >= LEAST_CORRELATION:
                pairs.append((first + half, top + half, x + half, y + half))
    return _split(pairs)


def _by_gradients(left: Picture, right: Picture) -> tuple[Points, Points]:
    """HOG: blocks of cells with alike histograms."""
    (left_at, left_blocks), (right_at, right_blocks) = (_blocks(picture) for picture in (left, right))
    return _matched(left_at, left_blocks, right_at, right_blocks, cv2.NORM_L2)


def _blocks(picture: Picture) -> tuple[Points, NDArray[np.float32]]:
    cells = (HOG_CELL_PX, HOG_CELL_PX)
    blocks_of: Any = hog(
        picture, HOG_BINS, cells, (HOG_BLOCK_CELLS, HOG_BLOCK_CELLS), block_norm="L2-Hys", feature_vector=False
    )
    found = np.asarray(blocks_of, dtype=np.float32)
    down, across = found.shape[:2]
    rows, columns = np.mgrid[:down, :across]
    middle = HOG_CELL_PX * HOG_BLOCK_CELLS / 2
    at = np.column_stack([HOG_CELL_PX * columns.ravel() + middle, HOG_CELL_PX * rows.ravel() + middle]).astype(
        np.float64
    )
    blocks = found.reshape(down * across, -1)
    shows = (
        np.array([picture[int(y) - 16 : int(y) + 16, int(x) - 16 : int(x) + 16].std() for x, y in at]) >= LEAST_CONTRAST
    )
    return at[shows], blocks[shows]


def _by_sift(left: Picture, right: Picture) -> tuple[Points, Points]:
    return _described(cv2.SIFT.create(MOST_FEATURES), left, right, cv2.NORM_L2)


def _by_orb(left: Picture, right: Picture) -> tuple[Points, Points]:
    return _described(cv2.ORB.create(MOST_FEATURES), left, right, cv2.NORM_HAMMING)


def _described(detector: Any, left: Picture, right: Picture, norm: int) -> tuple[Points, Points]:
    found = [detector.detectAndCompute(picture, None) for picture in (left, right)]
    (left_keys, left_words), (right_keys, right_words) = found
    if left_words is None or right_words is None:
        return np.empty((0, 2)), np.empty((0, 2))
    places = [np.array([key.pt for key in keys], dtype=np.float64) for keys in (left_keys, right_keys)]
    return _matched(places[0], left_words, places[1], right_words, norm)


def _by_corners(left: Picture, right: Picture) -> tuple[Points, Points]:
    """FAST corners, each described by BRIEF."""
    (left_at, left_words), (right_at, right_words) = (_corners(picture) for picture in (left, right))
    return _matched(left_at, left_words, right_at, right_words, cv2.NORM_HAMMING)


def _corners(picture: Picture) -> tuple[Points, Picture]:
    keys = sorted(cv2.FastFeatureDetector.create(FAST_THRESHOLD).detect(picture), key=lambda key: -key.response)
    at = np.array([key.pt for key in keys[:MOST_FEATURES]], dtype=np.float64).reshape(-1, 2)
    extractor: Any = BRIEF(descriptor_size=BRIEF_PAIRS)
    extractor.extract(picture, at[:, ::-1])
    words = np.packbits(extractor.descriptors, axis=1) if len(at) else np.empty((0, BRIEF_PAIRS // 8), np.uint8)
    return at[extractor.mask] if len(at) else at, words


def _matched(left_at: Points, left: Any, right_at: Points, right: Any, norm: int) -> tuple[Points, Points]:
    """Pairs whose best match is clearly better than the second best."""
    if min(len(left), len(right)) < 2:
        return np.empty((0, 2)), np.empty((0, 2))
    candidates = cv2.BFMatcher(norm).knnMatch(left, right, k=2)
    good = [best for best, second in candidates if best.distance < LOWE_RATIO * second.distance]
    pairs = [(*left_at[one.queryIdx], *right_at[one.trainIdx]) for one in good]
    return _split(pairs)


def _split(pairs: list[tuple[float, float, float, float]]) -> tuple[Points, Points]:
    both = np.array(pairs, dtype=np.float64).reshape(-1, 4)
    return both[:, :2], both[:, 2:]


_PAIRS: dict[FeatureMethod, Callable[[Picture, Picture], tuple[Points, Points]]] = {
    "ncc": _by_squares,
    "hog": _by_gradients,
    "sift": _by_sift,
    "fast-brief": _by_corners,
    "orb": _by_orb,
}
