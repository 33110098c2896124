"""Label masks as the split of a node sees them, and the mask that stands for a leaf.

A mask is compared with another by its pairs of pixels: whether the two pixels of a pair lie in the same segment. That
does not depend on how segments are numbered, and it makes a vector of each mask: z in the paper of Dollar and Zitnick,
doi:10.1109/TPAMI.2014.2377715, section 3.2.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.edges.forest.features import LABEL_PX

PIXEL_PAIRS = 256  # drawn again at each node, as in the paper
MOST_MASKS = 256  # masks of a node from which the principal component, or the medoid, is found
POWER_ROUNDS = 12  # of the power iteration

Masks = NDArray[np.uint8]


def same_segment(masks: Masks, rng: np.random.Generator) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Whether drawn pairs of pixels share a segment, less the mean over the masks, and the pairs.

    Parameters
    ----------
    masks : ndarray of uint8, shape (n, 256)
        Segment numbers, row by row.
    rng : numpy Generator

    Returns
    -------
    z : ndarray of float32, shape (n, `PIXEL_PAIRS`)
    pairs : ndarray of int64, shape (2, `PIXEL_PAIRS`)
        Places in a mask.
    """
    pairs = rng.integers(masks.shape[1], size=(2, PIXEL_PAIRS))
    z = (masks[:, pairs[0]] == masks[:, pairs[1]]).astype(np.float32)
    z -= z.mean(axis=0)
    return z, pairs


def two_classes(masks: Masks, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Class, 0 or 1, of each mask: on which side of their mean it lies along the first principal component.

    Parameters
    ----------
    masks : ndarray of uint8, shape (n, 256)
    rng : numpy Generator

    Returns
    -------
    ndarray of uint8, shape (n,)
        One class only if the drawn pairs cannot tell the masks apart.
    """
    chosen = rng.choice(len(masks), MOST_MASKS, replace=False) if len(masks) > MOST_MASKS else np.arange(len(masks))
    z, pairs = same_segment(masks[chosen], rng)
    direction = rng.standard_normal(PIXEL_PAIRS).astype(np.float32)
    for _ in range(POWER_ROUNDS):
        direction = (direction @ z.T) @ z
        length = np.linalg.norm(direction)
        if length < 1e-9:
            return np.zeros(len(masks), np.uint8)
        direction /= length
    return (_projected(masks, pairs, direction.astype(np.float32)) > 0).astype(np.uint8)


def medoid(masks: Masks, rng: np.random.Generator) -> NDArray[np.uint8]:
    """The mask that is nearest to the mean of them all.

    Parameters
    ----------
    masks : ndarray of uint8, shape (n, 256)
    rng : numpy Generator

    Returns
    -------
    ndarray of uint8, shape (256,)
    """
    chosen = masks if len(masks) <= MOST_MASKS else masks[rng.choice(len(masks), MOST_MASKS, replace=False)]
    z, _ = same_segment(chosen, rng)
    return chosen[np.argmin(np.einsum("ij,ij->i", z, z))]


def edge_pixels(mask: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Places, row by row, of the pixels on either side of a segment's border.

    Both sides count, so the middle of the line that votes draw lies on the border itself.
    """
    square = mask.reshape(LABEL_PX, LABEL_PX)
    edge = np.zeros(square.shape, np.bool_)
    down, right = square[1:] != square[:-1], square[:, 1:] != square[:, :-1]
    edge[1:] |= down
    edge[:-1] |= down
    edge[:, 1:] |= right
    edge[:, :-1] |= right
    return np.flatnonzero(edge).astype(np.uint8)


@njit(nogil=True, cache=True)
def _projected(masks: Masks, pairs: NDArray[np.int64], direction: NDArray[np.float32]) -> NDArray[np.float32]:
    """First principal component of each mask, less the mean over all of them."""
    values = np.empty(len(masks), np.float32)
    for n in range(len(masks)):
        total = np.float32(0)
        for pair in range(pairs.shape[1]):
            if masks[n, pairs[0, pair]] == masks[n, pairs[1, pair]]:
                total += direction[pair]
        values[n] = total
    return values - values.mean()
