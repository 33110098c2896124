"""Boundaries of interest (algorithms 5 and 8): the bar's edges, without the background's and the weak ones.

The dissertation leaves the use of two numbers open. Here alpha is the factor on Otsu's threshold of the picture, and
beta the code value under which edges are suppressed, after strengths have been stretched so that Otsu's level of the
strengths inside the mask lies at 240: on unstretched strengths, beta = 240 leaves no edge at all.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.edges.binary import denoised
from vision.edges.operators import Edges, detect_edges
from vision.edges.thinning import ridges
from vision.pictures import grey
from vision.sizing.virtual_board.parameters import PRINTED_PARAMETERS, Parameters

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
Plane = NDArray[np.float32]

STRETCHED_LEVEL_CODE = 240  # chosen: where Otsu's level of the strengths lies when they are compared with beta
OPENING_PX, DILATION_PX = 5, 9  # chosen: sides of the squares that open the mask, and widen it over the bar's edges


@dataclass(frozen=True, slots=True, eq=False)
class Boundaries:
    """Edges of interest in one region.

    Attributes
    ----------
    thin : ndarray of uint8, shape (rows, columns)
        1 on edges that survive, one pixel wide.
    band : ndarray of uint8, shape (rows, columns)
        I_MEDGE: those edges widened by one pixel, 1 inside; its borders are the boundaries of interest I_BOI.
    """

    thin: Picture
    band: Picture

    def traced(self) -> Array:
        """Boundaries of interest by Moore-neighbour tracing: their pixels (column, row), shape (n, 2)."""
        # the band is closed at the first and last row and column too, where it only leaves the region
        contours, _ = cv2.findContours(self.band, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        if not contours:
            return np.empty((0, 2))
        points = np.concatenate(contours)[:, 0].astype(np.float64)
        rows, columns = self.band.shape
        inner = (points[:, 1] > 0) & (points[:, 1] < rows - 1) & (points[:, 0] > 0) & (points[:, 0] < columns - 1)
        return points[inner]


def hot_mask(picture: Picture, alpha: float = PRINTED_PARAMETERS.alpha) -> Picture:
    """I_MOR: what is brighter than alpha times Otsu's threshold, opened, then widened over its own edges.

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
    alpha : float

    Returns
    -------
    ndarray of uint8, shape (rows, columns)
        0 or 1.
    """
    pixels = grey(picture)
    level, _ = cv2.threshold(pixels, 0, 1, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    _, mask = cv2.threshold(pixels, alpha * level, 1, cv2.THRESH_BINARY)
    opened = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((OPENING_PX, OPENING_PX), np.uint8))
    return np.asarray(cv2.dilate(opened, np.ones((DILATION_PX, DILATION_PX), np.uint8)), dtype=np.uint8)


def boundaries_of_interest(
    picture: Picture,
    mask: Picture | None,
    edges: Edges,
    parameters: Parameters = PRINTED_PARAMETERS,
    *,
    seen: slice = slice(None),
) -> Boundaries:
    """Edges inside a mask, thinned, without the weak ones and without noise (algorithm 8 from step 3 on, algorithm 4).

    Parameters
    ----------
    picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        Grey or blue-green-red.
    mask : ndarray of uint8, shape (rows, columns), or None
        I_MOR, 0 or 1; None where the whole picture is of interest.
    edges : str or EdgeOptions
        See `vision.edges.operators.detect_edges`.
    parameters : Parameters
        beta, and the neighbours of algorithm 4.
    seen : slice
        Columns of the result; the others only influence the edge detector.

    Returns
    -------
    Boundaries
        Of the columns `seen`.
    """
    found = detect_edges(_unit(picture), edges, seen)
    thin = ridges(found.strength, found.normal_rad)
    strong = _without_weak(thin if mask is None else thin * mask[:, seen], parameters.beta)
    kept = denoised(strong, parameters.least_neighbours).astype(np.uint8)
    band = cv2.dilate(kept, np.ones((3, 3), np.uint8))
    return Boundaries(kept, np.asarray(band, dtype=np.uint8))


def _unit(picture: Picture) -> Plane:
    """Grey or red-green-blue, 0 to 1."""
    ordered = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
    return np.multiply(ordered, np.float32(1 / 255), dtype=np.float32)


def _without_weak(strength: Plane, beta: float) -> NDArray[np.bool_]:
    """Where an edge reaches beta after Otsu's level of the edges was stretched to `STRETCHED_LEVEL_CODE`."""
    there = strength[strength > 0]
    if there.size == 0:
        return np.zeros(strength.shape, dtype=np.bool_)
    full = float(there.max())
    coded = np.rint(255 * (there / full)).astype(np.uint8)
    level, _ = cv2.threshold(coded, 0, 1, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    stretch = STRETCHED_LEVEL_CODE / max(level, 1.0)
    return (255 * stretch / full * strength) >= beta
