"""Training a structured forest from pictures whose segments are known.

After Dollar and Zitnick, Fast Edge Detection Using Structured Forests, doi:10.1109/TPAMI.2014.2377715. Each tree draws
its own pictures, patches and usable features.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.edges.forest.channels import PAD_PX
from vision.edges.forest.features import LABEL_PX, smoothed_cells
from vision.edges.forest.model import StructuredForest
from vision.edges.forest.structured_labels import Masks
from vision.edges.forest.tree import Growth, Patches, Tree, grow

NEAR_PX = 8.0  # a patch shows an edge when one passes its middle as near as this
GRADIENT_PLANE = 3  # magnitude at full scale, lightly smoothed


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """A picture and its true segments, by people or by geometry.

    Attributes
    ----------
    image : ndarray of float32, shape (rows, columns) or (rows, columns, 3)
        Grey or red-green-blue, 0 to 1.
    segments : tuple of ndarray of integers, shape (rows, columns)
        Number of each pixel's segment, one array for each opinion; negative where the segment is unknown, and no patch
        is drawn.
    """

    image: NDArray[np.float32]
    segments: tuple[NDArray[np.integer], ...]


def train_tree(
    examples: Iterable[Example],
    patches_per_example: int,
    growth: Growth,
    rng: np.random.Generator,
    on_progress: Callable[[int], None] = lambda _: None,
    *,
    uneven_part: float = 0.0,
) -> Tree:
    """Draw patches from examples and grow a tree of them.

    Parameters
    ----------
    examples : iterable of Example
        Read one after the other; only their cells are kept.
    patches_per_example : int
        Half of them near edges as long as there are as many.
    growth : Growth
    rng : numpy Generator
        The same examples and generator give the same tree.
    on_progress : callable
        Gets the number of patches that have been drawn, and again that have reached a leaf, since the last call.
    uneven_part : float
        Of the patches without an edge, which are drawn the likelier the more uneven the picture is there. What is steep
        and no edge is learnt better; but strength is then no longer as probable as the edge.

    Returns
    -------
    Tree

    Raises
    ------
    ValueError
        `examples` hold no patch.
    """
    cells: list[NDArray[np.float32]] = []
    start: list[NDArray[np.int64]] = []
    width: list[NDArray[np.int64]] = []
    masks: list[Masks] = []
    first = 0
    for example in examples:
        own = smoothed_cells(example.image)
        for opinion, count in zip(example.segments, _shares(patches_per_example, len(example.segments)), strict=True):
            rows, columns = _places(opinion, own[:, GRADIENT_PLANE], count, rng, uneven_part)
            start.append(first + rows * own[0].size + columns)
            width.append(np.full(len(rows), own.shape[2]))
            masks.append(_masks(opinion, 2 * rows, 2 * columns))
            on_progress(len(rows))
        cells.append(own.ravel())
        first += own.size
    if not sum(map(len, start)):
        raise ValueError("examples: at least one of 16 x 16 pixels wanted")
    patches = Patches(
        _joined(cells),
        np.concatenate(start),
        np.concatenate(width),
        np.concatenate(masks),
    )
    return grow(patches, growth, rng, on_progress)


def _joined(parts: list[NDArray[np.float32]]) -> NDArray[np.float32]:
    """One array of all parts; each is given up as soon as it is copied, so that memory does not hold them twice."""
    whole = np.empty(sum(map(len, parts)), np.float32)
    end = len(whole)
    while parts:
        part = parts.pop()
        whole[end - len(part) : end] = part
        end -= len(part)
    return whole


def _shares(total: int, parts: int) -> list[int]:
    """A number in nearly equal parts."""
    return [total * (part + 1) // parts - total * part // parts for part in range(parts)]


def _places(
    segments: NDArray[np.integer],
    gradient: NDArray[np.float32],
    count: int,
    rng: np.random.Generator,
    uneven_part: float,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Channel cells of the upper left corners of drawn patches: half near an edge, half not."""
    near = _edge_distance(segments) < NEAR_PX
    half = LABEL_PX // 2
    middle = near[half : len(near) - half + 1 : 2, half : near.shape[1] - half + 1 : 2]
    inner = LABEL_PX // 4 + PAD_PX // 2
    uneven = cv2.blur(gradient, (LABEL_PX // 2, LABEL_PX // 2))[inner:, inner:][: middle.shape[0], : middle.shape[1]]
    known = cv2.erode((segments >= 0).astype(np.uint8), np.ones((LABEL_PX, LABEL_PX)), anchor=(0, 0), borderValue=0)
    known = known[: near.shape[0] - LABEL_PX + 1 : 2, : near.shape[1] - LABEL_PX + 1 : 2] > 0
    with_edge, without = np.flatnonzero(middle & known), np.flatnonzero(~middle & known)
    drawn = [
        _drawn(with_edge, count - count // 2, rng),
        _drawn(without, count // 2, rng, np.asarray(uneven, np.float32).ravel(), uneven_part),
    ]
    rows, columns = np.divmod(np.concatenate(drawn), middle.shape[1])
    return rows, columns


def _drawn(
    places: NDArray[np.int64],
    count: int,
    rng: np.random.Generator,
    weight: NDArray[np.float32] | None = None,
    weighted_part: float = 0.0,
) -> NDArray[np.int64]:
    """At most so many of the places, without repeating one; a part of them in proportion to weights."""
    count = min(count, len(places))
    if weight is None or not weighted_part or not count:
        return rng.choice(places, count, replace=False)
    weights = weight[places].astype(np.float64) + 1e-6
    chance = weighted_part * weights / weights.sum() + (1 - weighted_part) / len(places)
    return rng.choice(places, count, replace=False, p=chance / chance.sum())


def _edge_distance(segments: NDArray[np.integer]) -> NDArray[np.float32]:
    """Distance of each pixel to the nearest one beside another segment, pixels."""
    inside = np.ones(segments.shape, np.uint8)
    inside[1:][segments[1:] != segments[:-1]] = 0
    inside[:, 1:][segments[:, 1:] != segments[:, :-1]] = 0
    if inside.all():
        return np.full(segments.shape, np.inf, np.float32)
    return cv2.distanceTransform(inside, cv2.DIST_L2, cv2.DIST_MASK_5).astype(np.float32, copy=False)


def _masks(segments: NDArray[np.integer], rows: NDArray[np.int64], columns: NDArray[np.int64]) -> Masks:
    """Segments of 16 x 16 pixels, numbered from 0 in each, shape (n, 256)."""
    masks = np.empty((len(rows), LABEL_PX * LABEL_PX), np.uint8)
    for number, (row, column) in enumerate(zip(rows, columns, strict=True)):
        window = segments[row : row + LABEL_PX, column : column + LABEL_PX]
        masks[number] = np.unique(window, return_inverse=True)[1].ravel()
    return masks


def forest_of(trees: Sequence[Tree], trees_evaluated: int) -> StructuredForest:
    """A forest of grown trees.

    Parameters
    ----------
    trees : sequence of Tree
    trees_evaluated : int
        Trees that vote on one patch.

    Returns
    -------
    StructuredForest
    """
    starts = np.concatenate([[0], np.cumsum([len(tree.child) for tree in trees])])
    edges = [places for tree in trees for places in tree.edges]
    return StructuredForest(
        tree_starts=starts.astype(np.int32),
        left_children=np.concatenate([tree.child for tree in trees]),
        feature_ids=np.concatenate([tree.feature for tree in trees]),
        thresholds=np.concatenate([tree.threshold for tree in trees]),
        edge_starts=np.concatenate([[0], np.cumsum([len(places) for places in edges])]).astype(np.int32),
        edge_places=np.concatenate(edges),
        trees_evaluated=trees_evaluated,
    )
