"""Memory for the last rows of every stage on the way from a picture to its smoothed channels."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

RING = 16  # rows kept of every stage: a power of two above the longest reach
REACH = 4  # radius of the strong smoothing in cells, and of the normalisation in pixels
ORIENTATIONS = 4
UNSMOOTHED = 3 + 2 * ORIENTATIONS  # channels: a magnitude is the sum of its orientations, before smoothing and after


class Rings(NamedTuple):
    """The last rows of every stage; `columns` are those of the padded picture, `cells` half as many.

    Attributes
    ----------
    luv : ndarray of float32, shape (1 or 3, RING, columns + 2)
        L, u, v with their outermost values repeated; L alone for a grey picture.
    magnitude, half_magnitude : ndarray of float32, shape (RING, columns or cells)
    orientation, half_orientation : ndarray of int32, shape (RING, columns or cells)
        Bins 0 to 3.
    half_luv : ndarray of float32, shape (1 or 3, RING, cells + 2)
    channels : ndarray of float32, shape (11, RING, cells)
        L, u, v and two times four orientations, not smoothed.
    scratch : ndarray of float32, shape (6, columns + 8)
    """

    luv: NDArray[np.float32]
    magnitude: NDArray[np.float32]
    orientation: NDArray[np.int32]
    half_luv: NDArray[np.float32]
    half_magnitude: NDArray[np.float32]
    half_orientation: NDArray[np.int32]
    channels: NDArray[np.float32]
    scratch: NDArray[np.float32]


def new_rings(cells: int, colours: int) -> Rings:
    """Empty rings.

    Parameters
    ----------
    cells : int
        Cells a row of the padded picture.
    colours : int
        1 for grey pictures, 3 for coloured ones.
    """
    columns = 2 * cells
    return Rings(
        luv=np.zeros((colours, RING, columns + 2), np.float32),
        magnitude=np.zeros((RING, columns), np.float32),
        orientation=np.zeros((RING, columns), np.int32),
        half_luv=np.zeros((colours, RING, cells + 2), np.float32),
        half_magnitude=np.zeros((RING, cells), np.float32),
        half_orientation=np.zeros((RING, cells), np.int32),
        channels=np.zeros((UNSMOOTHED, RING, cells), np.float32),
        scratch=np.zeros((6, columns + 2 * REACH), np.float32),
    )
