"""The forest as a value: trees of tests on patch features, and in their leaves where a patch has edges."""

import io
import struct
import zlib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import IO, Any, Self
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from vision.edges.forest.features import FEATURES, LABEL_PX

FORMAT = 1
_ARRAYS = {
    "tree_starts": np.int32,
    "left_children": np.int32,
    "feature_ids": np.int32,
    "thresholds": np.float32,
    "edge_starts": np.int32,
    "edge_places": np.uint8,
}
_DAMAGE = (
    *(ArithmeticError, AttributeError, BadZipFile, EOFError, LookupError, MemoryError, NotImplementedError, OSError),
    *(RuntimeError, SyntaxError, TypeError, ValueError, struct.error, zlib.error),
)  # what the readers of zip and npy say of files that were cut, overwritten or never theirs
_NUMBERS = {"format": np.int32, "trees_evaluated": np.int32}


@dataclass(frozen=True, slots=True, eq=False)
class StructuredForest:
    """A trained structured forest.

    The nodes of all trees stand one after another. A node sends a patch to its left child if the patch's feature is
    less than the node's threshold, else to its right child, which stands right behind the left one.

    Parameters
    ----------
    tree_starts : ndarray of int32, shape (trees + 1,)
        First node (the root) of each tree, and at the end the number of nodes.
    left_children : ndarray of int32, shape (nodes,)
        Left child, counted from the tree's root; 0 marks a leaf.
    feature_ids : ndarray of int32, shape (nodes,)
        Which of the 7228 features is tested; see `vision.edges.forest.features`. 0 in leaves.
    thresholds : ndarray of float32, shape (nodes,)
        0 in leaves.
    edge_starts : ndarray of int32, shape (nodes + 1,)
        Node n owns `edge_places[edge_starts[n]:edge_starts[n + 1]]`, which is empty unless it is a leaf.
    edge_places : ndarray of uint8, shape (places,)
        Where the leaf's label mask has edges: 16 row + column, both 0 to 15.
    trees_evaluated : int
        How many trees vote on one patch; neighbouring patches ask different ones.

    Raises
    ------
    TypeError
        An array has another dtype.
    ValueError
        The arrays do not describe a forest; the sentence says which and why.
    """

    tree_starts: NDArray[np.int32]
    left_children: NDArray[np.int32]
    feature_ids: NDArray[np.int32]
    thresholds: NDArray[np.float32]
    edge_starts: NDArray[np.int32]
    edge_places: NDArray[np.uint8]
    trees_evaluated: int = 4

    def __post_init__(self):
        for name, dtype in _ARRAYS.items():
            array = getattr(self, name)
            if not isinstance(array, np.ndarray) or array.dtype != dtype:
                raise TypeError(f"{name} is no array of {np.dtype(dtype)}")
            if array.ndim != 1:
                raise ValueError(f"{name} has {array.ndim} dimensions, not 1")
        self._check_trees()
        self._check_nodes()
        self._check_edges()

    @property
    def trees(self) -> int:
        """Number of trees."""
        return len(self.tree_starts) - 1

    def _check_trees(self):
        starts = self.tree_starts.astype(np.int64)
        nodes = len(self.left_children)
        if len(starts) < 2 or starts[0] != 0 or starts[-1] != nodes or (np.diff(starts) < 1).any():
            raise ValueError(f"tree_starts does not divide {nodes} nodes into trees of at least one node")
        if not 1 <= self.trees_evaluated <= self.trees:
            raise ValueError(f"trees_evaluated is {self.trees_evaluated}; allowed are 1 to {self.trees}")

    def _check_nodes(self):
        nodes = len(self.left_children)
        if len(self.feature_ids) != nodes or len(self.thresholds) != nodes:
            raise ValueError("left_children, feature_ids and thresholds differ in length")
        if ((self.feature_ids < 0) | (self.feature_ids >= FEATURES)).any():
            raise ValueError(f"feature_ids are not all within 0 to {FEATURES - 1}")
        if not np.isfinite(self.thresholds).all():
            raise ValueError("thresholds are not all finite")
        for start, end in zip(self.tree_starts[:-1], self.tree_starts[1:], strict=True):
            left = self.left_children[start:end]
            parents = np.flatnonzero(left)
            lefts = left[parents].astype(np.int64)
            if ((lefts < 0) | (lefts + 1 >= len(left))).any():
                raise ValueError("left_children point outside their tree")
            if (lefts <= parents).any():
                raise ValueError("left_children do not all stand behind their parents, so a walk might never end")
            if not np.array_equal(np.sort(np.concatenate((lefts, lefts + 1))), np.arange(1, len(left))):
                raise ValueError("left_children do not reach every node by one way")

    def _check_edges(self):
        starts = self.edge_starts.astype(np.int64)
        lengths = np.diff(starts)
        if len(starts) != len(self.left_children) + 1 or starts[0] != 0 or starts[-1] != len(self.edge_places):
            raise ValueError("edge_starts does not divide edge_places among the nodes")
        if ((lengths < 0) | (lengths > LABEL_PX**2)).any():
            raise ValueError(f"edge_starts does not rise by 0 to {LABEL_PX**2} from node to node")
        if lengths[self.left_children != 0].any():
            raise ValueError("edge_starts gives edges to nodes that are no leaves")

    @classmethod
    def load(cls, file: str | Path | IO[bytes]) -> Self:
        """Read a forest from an `.npz` file or an open binary file.

        Raises
        ------
        ValueError
            It is no such file, is damaged, or holds no forest; the sentence says which.
        OSError
            It cannot be read.
        """
        content = Path(file).read_bytes() if isinstance(file, str | Path) else file.read()
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as archive:
                entries = {name: np.asarray(archive[name]) for name in (*_ARRAYS, *_NUMBERS)}
        except _DAMAGE as error:
            raise ValueError(f"{_name(file)} is no intact forest model: {error}") from error
        numbers = {name: entries.pop(name) for name in _NUMBERS}
        if any(number.shape != () or number.dtype != _NUMBERS[name] for name, number in numbers.items()):
            raise ValueError(f"{_name(file)} is no forest model: its numbers are no numbers")
        if numbers["format"] != FORMAT:
            raise ValueError(f"{_name(file)} has format {numbers['format']}; this release reads {FORMAT}")
        try:
            return cls(**entries, trees_evaluated=int(numbers["trees_evaluated"]))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{_name(file)} is no forest model: {error}") from error

    def save(self, file: str | Path | IO[bytes]) -> None:
        """Write the forest as a compressed `.npz`; a path is taken as it is, an ending is not added."""
        if isinstance(file, str | Path):
            with Path(file).open("wb") as opened:
                self.save(opened)
            return
        entries: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        entries |= {"format": np.int32(FORMAT), "trees_evaluated": np.int32(self.trees_evaluated)}
        np.savez_compressed(file, **entries)


def _name(file: str | Path | IO[bytes]) -> str:
    return str(file if isinstance(file, str | Path) else getattr(file, "name", "the file"))


@cache
def shipped_forest() -> StructuredForest:
    """The forest that comes with Hotgauge, read once."""
    folder = resources.files("vision.edges.forest") / "model"
    models = [entry for entry in folder.iterdir() if entry.name.endswith(".npz")]
    if len(models) != 1:
        raise ValueError(f"the installation holds {len(models)} forest models instead of one; install it again")
    with models[0].open("rb") as file:
        return StructuredForest.load(file)
