"""The part of two aligned pictures that both cameras see: only there do metrics of fusion say something of both."""

import numpy as np
from numpy.typing import NDArray

BLOCK_PX = 8  # the rectangle is found in steps of 8 pixels


def common_rectangle(seen: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Largest rectangle of pixels that are all seen, in steps of `BLOCK_PX`.

    Parameters
    ----------
    seen : ndarray of bool, shape (rows, columns)

    Returns
    -------
    tuple of two slice
        Rows and columns; empty where no whole block is seen.
    """
    down, across = (size // BLOCK_PX for size in seen.shape)
    blocks = seen[: down * BLOCK_PX, : across * BLOCK_PX].reshape(down, BLOCK_PX, across, BLOCK_PX).all(axis=(1, 3))
    best = (0, 0, 0, 0, 0)  # area, first row, end row, first column, end column
    height = np.zeros(across, dtype=np.int64)
    for row, line in enumerate(blocks.reshape(down, across)):
        height = np.where(line, height + 1, 0)
        best = max(best, _widest(height.tolist(), row + 1))
    _, top, bottom, left, right = (BLOCK_PX * number for number in best)
    return slice(top, bottom), slice(left, right)


def _widest(heights: list[int], end_row: int) -> tuple[int, int, int, int, int]:
    """Largest rectangle under a histogram that stands on a row: area, first row, end row, first column, end column."""
    best, waiting = (0, 0, 0, 0, 0), list[tuple[int, int]]()
    for column, height in enumerate([*heights, 0]):
        first = column
        while waiting and waiting[-1][1] >= height:
            first, high = waiting.pop()
            best = max(best, (high * (column - first), end_row - high, end_row, first, column))
        waiting.append((first, height))
    return best
