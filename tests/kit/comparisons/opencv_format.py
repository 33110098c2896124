"""Forests in the YAML format that OpenCV's `createStructuredEdgeDetection` reads.

In that format a node's child c means: left child c - 1, right child c, both counted from the tree's root; 0 is a leaf.
All trees have the same number of nodes; what a smaller tree lacks is filled up with leaves that nothing leads to.
Edge places count down the columns of the label mask, ours along the rows.
"""

import gzip
import re
import textwrap
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vision.edges.forest.features import LABEL_PX
from vision.edges.forest.model import StructuredForest

Integers = NDArray[np.int64]

_OPTIONS = {
    "stride": 2,
    "shrinkNumber": 2,
    "patchSize": 32,
    "patchInnerSize": LABEL_PX,
    "numberOfGradientOrientations": 4,
    "gradientSmoothingRadius": 0,
    "regFeatureSmoothingRadius": 2,
    "ssFeatureSmoothingRadius": 8,
    "gradientNormalizationRadius": 4,
    "selfsimilarityGridSize": 5,
}
_TREES, _EVALUATED = "numberOfTrees", "numberOfTreesToEvaluate"
_SECTION = re.compile(r"^(\w+):[ \t]*$", re.MULTILINE)
_OPTION = re.compile(r"^[ \t]+(\w+):[ \t]*(-?\d+)[ \t]*$", re.MULTILINE)
_SEQUENCE = re.compile(r"-\s*\[([^\]]*)\]")


def read_opencv(file: str | Path) -> StructuredForest:
    """Read a forest that OpenCV could read; compressed by gzip or not.

    Raises
    ------
    ValueError
        The file is damaged, holds no forest, or one with other features than those computed here.
    OSError
        It cannot be read.
    """
    content = Path(file).read_bytes()
    try:
        text = (gzip.decompress(content) if content[:2] == b"\x1f\x8b" else content).decode("utf-8")
        return _forest(text)
    except (EOFError, zlib.error, gzip.BadGzipFile, ValueError, TypeError) as error:
        raise ValueError(f"{file} is no intact forest in OpenCV's format: {error}") from error


def _forest(text: str) -> StructuredForest:
    headings = list(_SECTION.finditer(text))
    ends = [heading.start() for heading in headings[1:]] + [len(text)]
    sections = {heading[1]: text[heading.end() : end] for heading, end in zip(headings, ends, strict=True)}
    missing = {"options", "childs", "featureIds", "thresholds", "edgeBoundaries", "edgeBins"} - sections.keys()
    if missing:
        raise ValueError(f"it lacks {', '.join(sorted(missing))}")
    options = {name: int(value) for name, value in _OPTION.findall(sections["options"])}
    for name, wanted in _OPTIONS.items():
        if options.get(name) != wanted:
            raise ValueError(f"{name} is {options.get(name)}; only {wanted} can be used here")
    trees, evaluated = options.get(_TREES, 0), options.get(_EVALUATED, 0)
    children = _whole_numbers(sections["childs"])
    if trees < 1 or len(children) < trees or len(children) % trees:
        raise ValueError(f"{len(children)} childs cannot be divided among {trees} trees")
    kept, lefts = zip(*(_reachable(tree) for tree in children.reshape(trees, -1)), strict=True)
    size = len(children) // trees
    nodes = np.concatenate([size * tree + reached for tree, reached in enumerate(kept)])
    left_children = np.concatenate(lefts)
    thresholds, feature_ids = _numbers(sections["thresholds"]), _whole_numbers(sections["featureIds"])
    boundaries, bins = _whole_numbers(sections["edgeBoundaries"]), _whole_numbers(sections["edgeBins"])
    if not len(thresholds) == len(feature_ids) == len(children) or len(boundaries) <= len(children):
        raise ValueError("childs, featureIds, thresholds and edgeBoundaries do not fit each other in length")
    if boundaries[0] < 0 or (np.diff(boundaries) < 0).any() or boundaries[len(children)] > len(bins):
        raise ValueError("edgeBoundaries do not rise from 0 to the number of edgeBins")
    if len(bins) and not 0 <= bins.min() <= bins.max() < LABEL_PX**2:
        raise ValueError(f"edgeBins are not all within 0 to {LABEL_PX**2 - 1}")
    is_leaf = left_children == 0
    lengths = np.where(is_leaf, boundaries[nodes + 1] - boundaries[nodes], 0)
    column, row = np.divmod(bins[_ranges(boundaries[nodes], lengths)], LABEL_PX)
    return StructuredForest(
        tree_starts=np.cumsum([0, *map(len, kept)]).astype(np.int32),
        left_children=left_children.astype(np.int32),
        feature_ids=np.where(is_leaf, 0, feature_ids[nodes]).astype(np.int32),
        thresholds=np.where(is_leaf, 0, thresholds[nodes]).astype(np.float32),
        edge_starts=np.append(0, np.cumsum(lengths)).astype(np.int32),
        edge_places=(LABEL_PX * row + column).astype(np.uint8),
        trees_evaluated=evaluated,
    )


def _numbers(section: str) -> NDArray[np.float64]:
    lines = ["".join(sequence.split()).rstrip(",") for sequence in _SEQUENCE.findall(section)]
    numbers = [np.loadtxt([line], np.float64, delimiter=",", ndmin=1) for line in lines if line]
    return np.concatenate([np.empty(0), *numbers])


def _whole_numbers(section: str) -> Integers:
    numbers = _numbers(section)
    if (np.abs(numbers) >= 2**31).any() or (numbers != np.rint(numbers)).any():
        raise ValueError("a count, an index or a place in it is no whole number of 32 bits")
    return numbers.astype(np.int64)


def _reachable(children: Integers) -> tuple[Integers, Integers]:
    """The nodes of one tree that the root leads to, level by level, and each one's left child in that order."""
    levels, lefts, count, level = [], [], 1, np.zeros(1, np.int64)
    while len(level):
        inner = children[level] != 0
        left = children[level][inner] - 1
        if ((left < 1) | (left + 1 >= len(children))).any():
            raise ValueError("childs point outside their tree")
        lefts.append(np.where(inner, count + 2 * (np.cumsum(inner) - 1), 0))
        levels.append(level)
        level = np.column_stack((left, left + 1)).reshape(-1)
        count += len(level)
        if count > len(children):
            raise ValueError("childs lead to a node by two ways")
    return np.concatenate(levels), np.concatenate(lefts)


def _ranges(starts: Integers, lengths: Integers) -> Integers:
    """The whole numbers start to start + length - 1 of all ranges, one range after the other."""
    before = np.cumsum(lengths) - lengths
    return np.repeat(starts - before, lengths) + np.arange(lengths.sum())


def write_opencv(forest: StructuredForest, file: str | Path) -> None:
    """Write a forest so that OpenCV can read it; compressed if the file's name ends in `.gz`."""
    sizes = np.diff(forest.tree_starts)
    size = int(sizes.max())
    nodes = np.concatenate([size * tree + np.arange(count) for tree, count in enumerate(sizes)])

    def padded(values: NDArray[np.generic]) -> NDArray[np.generic]:
        filled = np.zeros(size * forest.trees, values.dtype)
        filled[nodes] = values
        return filled.reshape(forest.trees, size)

    row, column = np.divmod(forest.edge_places.astype(np.int64), LABEL_PX)
    bins = LABEL_PX * column + row
    boundaries = np.append(0, np.cumsum(padded(np.diff(forest.edge_starts))))
    children = np.where(forest.left_children != 0, forest.left_children + 1, 0)
    options = _OPTIONS | {_TREES: forest.trees, _EVALUATED: forest.trees_evaluated}
    sections = {
        "childs": list(padded(children)),
        "featureIds": list(padded(forest.feature_ids)),
        "thresholds": list(padded(forest.thresholds)),
        "edgeBoundaries": np.split(boundaries, size * np.arange(1, forest.trees)),
        "edgeBins": np.split(bins, forest.edge_starts[forest.tree_starts[1:-1]]),
    }
    text = "%YAML:1.0\n---\noptions:\n" + "".join(f"   {name}: {value}\n" for name, value in options.items())
    for name, trees in sections.items():
        text += f"{name}:\n" + "".join(f"   - [ {_wrapped(tree)} ]\n" for tree in trees)
    content = text.encode()
    Path(file).write_bytes(gzip.compress(content) if str(file).endswith(".gz") else content)


def _wrapped(values: NDArray[np.generic]) -> str:
    decimals = ", ".join(str(value) for value in values.tolist())
    return textwrap.fill(decimals, 100, subsequent_indent="       ")
