"""Binary edges: edge strength compared with a confidence, and lone edge pixels removed."""

import cv2
import numpy as np
from numpy.typing import NDArray

# Confidences of the dissertation's structured forest, section 3.2: for the empty line and for a hot bar.
EVERY_EDGE_CONFIDENCE, BAR_EDGE_CONFIDENCE = 0.02, 0.2
LEAST_NEIGHBOURS = 2  # of algorithm 4


def binarised(strength: NDArray[np.float32], confidence: float) -> NDArray[np.bool_]:
    """Edges of at least this confidence.

    Parameters
    ----------
    strength : ndarray of float32, shape (rows, columns)
        0 to 1, as `vision.edges.operators.detect_edges` gives it, thinned or not.
    confidence : float
        Least strength, as a share of full scale. Full scale is 1 and not the strongest edge in the picture, so an edge
        does not depend on what else is in view.

    Returns
    -------
    ndarray of bool, shape (rows, columns)

    Raises
    ------
    ValueError
        `confidence` is not above 0 and at most 1.
    """
    if not 0 < confidence <= 1:
        raise ValueError(f"confidence is {confidence}; it must be above 0 and at most 1")
    return strength >= np.float32(confidence)


def denoised(edges: NDArray[np.bool_], least_neighbours: int = LEAST_NEIGHBOURS) -> NDArray[np.bool_]:
    """Keep edge pixels that have at least two others among their eight neighbours (algorithm 4 of the dissertation).

    Every pixel is judged by the input, not by what was removed before it. Border pixels, which the dissertation's loop
    does not visit, are judged like all others; beyond the border there are no edges.

    Parameters
    ----------
    edges : ndarray of bool, shape (rows, columns)
    least_neighbours : int
        Another number than the dissertation's two.

    Returns
    -------
    ndarray of bool, shape (rows, columns)

    Raises
    ------
    TypeError
        `edges` is no array of bool.
    """
    if edges.dtype != np.bool_:
        raise TypeError(f"edges is an array of {edges.dtype}; wanted is bool")
    within = cv2.boxFilter(edges.astype(np.uint8), cv2.CV_8U, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    return edges & (np.asarray(within) > least_neighbours)
