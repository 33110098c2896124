"""Growing one tree of a structured forest.

A node's patches are told apart by one feature and a threshold, chosen for the purity of two classes that are found
anew at each node from the patches' label masks: Gini's, or the information gain (eq. 2.8 to 2.11). Features are read
from the channels at the moment they are compared: what a tree needs in memory is its pictures' channels, whatever the
number of patches.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision.edges.forest.features import FEATURES, feature_offsets
from vision.edges.forest.structured_labels import Masks, edge_pixels, medoid, two_classes

LEAST_GAIN = 1e-10  # of impurity: a smaller gain is rounding, and the node becomes a leaf

Floats = NDArray[np.float32]
Criterion = Literal["gini", "entropy"]


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Training set of a tree: n patches of pictures whose channels lie one behind the other.

    Attributes
    ----------
    cells : ndarray of float32, shape (cells,)
        Of all pictures, each of shape (rows, planes, columns).
    start : ndarray of int64, shape (n,)
        First plane of the cell in each patch's upper left corner.
    width : ndarray of int64, shape (n,)
        Cells a row of its picture.
    masks : ndarray of uint8, shape (n, 256)
        Segments in the middle of each patch.
    """

    cells: Floats
    start: NDArray[np.int64]
    width: NDArray[np.int64]
    masks: Masks


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """A grown tree, one entry per node; node 0 is the root.

    Attributes
    ----------
    child : ndarray of int32
        The left child, whose neighbour is the right one; 0 for a leaf.
    feature : ndarray of int32
        Number of the feature that is compared; 0 for a leaf.
    threshold : ndarray of float32
        Left when the feature is less; 0 for a leaf.
    edges : list of ndarray of uint8
        Of leaves: places of the edge's pixels in the 16 x 16 mask, row by row; empty for other nodes.
    """

    child: NDArray[np.int32]
    feature: NDArray[np.int32]
    threshold: NDArray[np.float32]
    edges: list[NDArray[np.uint8]]


@dataclass(frozen=True, slots=True)
class Growth:
    """How far a tree grows.

    Attributes
    ----------
    feature_part : float
        Of all features, which a tree may use; drawn for each tree.
    least_patches : int
        In a child.
    greatest_depth : int
    criterion : {"gini", "entropy"}
        What a split must lower: 1 - sum p^2, or - sum p log2 p (eq. 2.8 with K = 1 / ln 2), whose gain is eq. 2.11.
    """

    feature_part: float = 0.25
    least_patches: int = 8
    greatest_depth: int = 64
    criterion: Criterion = "gini"


def grow(
    patches: Patches,
    growth: Growth,
    rng: np.random.Generator,
    on_progress: Callable[[int], None],
) -> Tree:
    """Grow a tree.

    Parameters
    ----------
    patches : Patches
    growth : Growth
    rng : numpy Generator
        The same generator grows the same tree.
    on_progress : callable
        Gets the number of patches that have reached their leaf since the last call.

    Returns
    -------
    Tree
    """
    usable = rng.choice(FEATURES, round(growth.feature_part * FEATURES), replace=False)
    tried = round(len(usable) ** 0.5)
    child, feature, threshold, edges = [0], [0], [0.0], [np.empty(0, np.uint8)]
    waiting = [(0, np.arange(len(patches.start)), 0)]
    while waiting:
        node, members, depth = waiting.pop()
        masks = patches.masks[members]
        split, candidates = None, usable
        if len(members) >= 2 * growth.least_patches and depth < growth.greatest_depth and (masks != masks[0]).any():
            candidates = rng.choice(usable, tried, replace=False)
            split = _split(patches, members, two_classes(masks, rng), candidates, growth)
        if split is None:
            edges[node] = edge_pixels(medoid(masks, rng))
            on_progress(len(members))
            continue
        which, threshold[node], goes_left = split
        child[node], feature[node] = len(child), int(candidates[which])
        for part in (members[goes_left], members[~goes_left]):
            waiting.append((len(child), part, depth + 1))
            child.append(0)
            feature.append(0)
            threshold.append(0.0)
            edges.append(np.empty(0, np.uint8))
    return Tree(np.array(child, np.int32), np.array(feature, np.int32), np.array(threshold, np.float32), edges)


def _split(
    patches: Patches,
    members: NDArray[np.int64],
    classes: NDArray[np.uint8],
    feature_ids: NDArray[np.int64],
    growth: Growth,
) -> tuple[int, float, NDArray[np.bool_]] | None:
    """Best of the candidates: its place among them, the threshold, and which members go left."""
    widths, which_width = np.unique(patches.width[members], return_inverse=True)
    offsets = np.array([feature_offsets(feature_ids, int(width)) for width in widths])
    values = _read(patches.cells, patches.start[members], which_width, offsets)
    which, threshold, gain = _best(values, classes, growth.least_patches, growth.criterion == "entropy")
    return (which, threshold, values[which] < threshold) if gain > LEAST_GAIN else None


@njit(nogil=True, cache=True)
def _read(
    cells: Floats, start: NDArray[np.int64], which_width: NDArray[np.int64], offsets: NDArray[np.int64]
) -> Floats:
    """Features of patches, shape (features, patches)."""
    values = np.empty((offsets.shape[2], len(start)), np.float32)
    for f in range(len(values)):
        for n in range(len(start)):
            first, second = offsets[which_width[n], 0, f], offsets[which_width[n], 1, f]
            values[f, n] = cells[start[n] + first] - cells[start[n] + second]
    return values


@njit(nogil=True, cache=True)
def _best(values: Floats, classes: NDArray[np.uint8], least: int, by_entropy: bool = False) -> tuple[int, float, float]:
    """Feature, threshold and gain of the split that leaves the purest classes."""
    count = values.shape[1]
    ones = 0
    for n in range(count):
        ones += int(classes[n])
    before = _impurity(count, ones, by_entropy)
    best, best_threshold, best_gain = 0, 0.0, 0.0
    for f in range(len(values)):
        order = np.argsort(values[f])
        left_ones = 0
        for left in range(1, count - least + 1):
            left_ones += int(classes[order[left - 1]])
            if left < least:
                continue
            low, high = values[f, order[left - 1]], values[f, order[left]]
            if not low < high:
                continue
            right, right_ones = count - left, ones - left_ones
            after = _impurity(left, left_ones, by_entropy) + _impurity(right, right_ones, by_entropy)
            if (before - after) / count > best_gain:
                middle = low + (high - low) * np.float32(0.5)
                best, best_threshold = f, float(middle if middle > low else high)
                best_gain = (before - after) / count
    return best, best_threshold, best_gain


@njit(nogil=True, cache=True)
def _impurity(count: int, ones: int, by_entropy: bool) -> float:
    """Impurity of patches of which some are of class 1, times their count: Gini's, or their entropy in bit."""
    if not by_entropy:
        return 2.0 * ones * (count - ones) / count
    bits = 0.0
    for part in (ones, count - ones):
        if part > 0:
            bits += part * np.log2(count / part)
    return bits
