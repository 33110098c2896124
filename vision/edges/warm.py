"""Compile what edge detection needs before the first frame waits for it."""

import numpy as np

from vision.edges.operators import detect_edges
from vision.edges.thinning import ridges


def warm_up() -> None:
    """Compile all kernels of the edge forest and of thinning, or read them from the cache on disk.

    Takes about 12 s of one core the first time and under a second afterwards. Kernels are kept in `NUMBA_CACHE_DIR` if
    that is set, else beside the sources, else in the user's cache folder; one of them must be writable.
    Grey and colour pictures use the same compiled code.

    Raises
    ------
    ValueError
        The installation lacks its forest model.
    """
    edges = detect_edges(np.zeros((64, 64), np.float32), "forest")
    ridges(edges.strength, edges.normal_rad)
