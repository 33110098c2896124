"""Edge strength of pictures, or of parts of them, from a structured forest."""

import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vision.edges.forest import channels, walk
from vision.edges.forest.features import (
    FEATURES,
    LABEL_PX,
    PATCH_CELLS,
    check_values,
    checked_image,
    feature_offsets,
    places_along,
)
from vision.edges.forest.model import StructuredForest, shipped_forest
from vision.edges.forest.rings import Rings, new_rings

Floats = NDArray[np.float32]
Region = tuple[slice, slice]
Rectangle = tuple[int, int, int, int]  # first row, end row, first column, end column

CELLS_AT_ONCE = 200_000  # values made before they are walked: 0.8 MB, so that they are still in the nearest big cache
OVERLAP = PATCH_CELLS - 1  # rows of cells that the patches of one row and of the next ones share
REACH_CELLS = 8  # further from a patch nothing changes its features: 4 + 4 + 1 from a cell that lies 1 inside it
VECTOR_CELLS = 32  # rows of so many cells leave no rest to the compiled loops, which take them together


class EdgeDetector:
    """A structured forest, laid out for detecting edges in pictures.

    Strength is the share of voting trees that see an edge in a pixel, smoothed by [1 2 1] / 4 both ways and doubled: 1
    where all trees agree on a straight edge one pixel wide. It can reach 2 where they agree on a patch of edge pixels.

    The same picture gives the same bits with one or two threads, and a region the same as the whole picture.
    The two last rows and columns of a picture belong to no patch and get votes from smoothing only.

    Parameters
    ----------
    forest : StructuredForest
    threads : int
        1 or more; more than one work on parts of the picture. They are the detector's own.
    """

    def __init__(self, forest: StructuredForest, threads: int = 2):
        if threads < 1:
            raise ValueError(f"threads is {threads}; at least one is needed")
        self.forest = forest
        self._threads = threads
        self._pool = ThreadPoolExecutor(threads, "edges") if threads > 1 else None
        self._memory = _Memory()
        self._tables = lru_cache(maxsize=8)(lambda width: _tables(forest, width))

    def strength(self, image: Floats) -> Floats:
        """Edge strength of a whole picture.

        Parameters
        ----------
        image : ndarray of float32, shape (rows, columns) or (rows, columns, 3)
            Grey or RGB, 0 to 1, at least 32 x 32.

        Returns
        -------
        ndarray of float32, shape (rows, columns)

        Raises
        ------
        TypeError, ValueError
            See `vision.edges.forest.features.checked_image`; or a value is outside 0 to 1 or NaN.
        """
        return self.strength_in(image, [np.s_[:, :]])[0]

    def strength_in(self, image: Floats, regions: Sequence[Region]) -> list[Floats]:
        """Edge strength in parts of a picture, in the time that the parts take.

        Parameters
        ----------
        image : ndarray of float32, shape (rows, columns) or (rows, columns, 3)
            Grey or RGB, 0 to 1, at least 32 x 32.
        regions : sequence of (slice, slice)
            Rows and columns, as one would index the picture.

        Returns
        -------
        list of ndarray of float32
            For each region bit by bit `strength(image)[region]`.

        Raises
        ------
        TypeError, ValueError
            As `strength`, for values in the regions and around them; or a region is empty or has a step.
        """
        image = checked_image(image)
        rectangles = [_rectangle(region, image) for region in regions]
        results = [np.empty((r[1] - r[0], r[3] - r[2]), np.float32) for r in rectangles]
        parts = [
            (part, result, (whole[0], whole[2]))
            for whole, result in zip(rectangles, results, strict=True)
            for part in _parts(whole, -(-self._threads // len(rectangles)))
        ]
        run = self._pool.map if self._pool else map
        check_values(sum(run(lambda part: self._fill(image, *part), parts)))
        return results

    def _fill(self, image: Floats, part: Rectangle, strength: Floats, corner: tuple[int, int]) -> int:
        """Strength of one part, into an array that begins at `corner`; gives how many values outside 0 to 1 it met."""
        rows, columns, colours = image.shape
        first_row, end_row = _places_seeing(part[0], part[1], rows)
        first_column, end_column = _places_seeing(part[2], part[3], columns)
        left, right = _cells_seen(first_column, end_column, channels.cells_along(columns))
        rings, work = self._memory_for(right - left, end_row - first_row, colours)
        tables = self._tables(work.cells.shape[2])
        place_columns = (first_column - left, end_column - left)
        done = channels.stages_starting_at(first_row)
        at_once, kept = len(work.cells) - OVERLAP, 0
        work.votes[:] = 0
        outside = 0
        for row in range(first_row, end_row, at_once):
            end = min(row + at_once, end_row)
            work.cells[:kept] = work.cells[len(work.cells) - kept :]
            outside += channels.make_cell_rows(image, left, row + kept, end + OVERLAP, rings, done, work.cells[kept:])
            place_rows = (row - first_row, end - first_row)
            walk.count_votes(place_rows, place_columns, place_rows[0], first_row + left, tables, work)
            kept = OVERLAP
        weight = np.float32(1 / (32 * 16 * self.forest.trees_evaluated))
        even = (rows + rows % 2, columns + columns % 2)
        walk.smooth_votes(work.votes, (2 * first_row, 2 * left), part, even, weight, strength, corner)
        return outside

    def _memory_for(self, width: int, place_rows: int, colours: int) -> tuple[Rings, walk.Workspace]:
        """Memory for such a part: reused from this thread's earlier parts where it fits."""
        place_rows = 32 * -(-place_rows // 32)  # so that it fits the next part too, which has a few rows more or less
        stride = 32 * (-(-(width - 16) // 32)) + 16  # an odd number of cache lines: rows do not displace each other
        return self._memory.rings(width, colours), self._memory.workspace(stride, place_rows)


class _Memory(threading.local):
    """Memory that one thread reuses: strips along both edges of a bar alternate and differ by a few columns."""

    def __init__(self):
        self.rings = lru_cache(maxsize=4)(new_rings)
        self.workspace = lru_cache(maxsize=2)(_workspace)


def _workspace(stride: int, place_rows: int) -> walk.Workspace:
    at_once = max(walk.PLACE_ROWS, CELLS_AT_ONCE // (channels.PLANES * stride) // walk.PLACE_ROWS * walk.PLACE_ROWS)
    return walk.Workspace(
        cells=np.zeros((min(place_rows, at_once) + OVERLAP, channels.PLANES, stride), np.float32),
        votes=np.zeros((2 * place_rows + LABEL_PX + 2, 2 * stride), np.uint16),
        waiting_nodes=np.zeros(walk.LANES, np.uint64),
        waiting_lanes=np.zeros(walk.LANES, np.uint64),
    )


def _rectangle(region: Region, image: Floats) -> Rectangle:
    rows, columns = region
    first_row, end_row, row_step = rows.indices(image.shape[0])
    first_column, end_column, column_step = columns.indices(image.shape[1])
    if (row_step, column_step) != (1, 1) or first_row >= end_row or first_column >= end_column:
        raise ValueError(f"regions holds {region}, which is empty in this image or has a step")
    return first_row, end_row, first_column, end_column


def _parts(rectangle: Rectangle, count: int) -> list[Rectangle]:
    """The rectangle in so many parts along its longer side."""
    first_row, end_row, first_column, end_column = rectangle
    if end_row - first_row >= end_column - first_column or count == 1:
        cuts = np.linspace(first_row, end_row, count + 1).astype(int).tolist()
        return [(a, b, first_column, end_column) for a, b in pairwise(cuts)]
    cuts = np.linspace(first_column, end_column, count + 1).astype(int).tolist()
    return [(first_row, end_row, a, b) for a, b in pairwise(cuts)]


def _places_seeing(first: int, end: int, pixels: int) -> tuple[int, int]:
    """Places along one side whose votes reach the pixels first - 1 to end."""
    return max(0, (first - LABEL_PX) // 2), min(places_along(pixels), end // 2 + 1)


def _cells_seen(first_place: int, end_place: int, cells: int) -> tuple[int, int]:
    """First and end cell of a row that places depend on; some more where that makes whole vectors."""
    first, end = max(0, first_place - REACH_CELLS), min(cells, end_place + OVERLAP + REACH_CELLS)
    more = -(end - first) % VECTOR_CELLS
    end = min(cells, end + more)
    return max(0, first - (-(end - first) % VECTOR_CELLS)), end


def _tables(forest: StructuredForest, width: int) -> walk.Tables:
    """Lay the forest out for cells of this width."""
    leaf = forest.left_children == 0
    first, second = feature_offsets(np.arange(FEATURES), width)
    roots = np.repeat(forest.tree_starts[:-1], np.diff(forest.tree_starts)).astype(np.int64)
    words = np.zeros((len(leaf), walk.NODE_WORDS), np.uint32)
    words[:, 0] = np.where(leaf, forest.edge_starts[:-1], first[forest.feature_ids])
    words[:, 1] = np.where(leaf, forest.edge_starts[1:], second[forest.feature_ids])
    words.view(np.float32)[:, 2] = forest.thresholds
    words[:, 3] = np.where(leaf, words.size, walk.NODE_WORDS * (roots + forest.left_children))
    return walk.Tables(
        nodes=words.reshape(-1),
        thresholds=words.view(np.float32).reshape(-1),
        roots=walk.NODE_WORDS * forest.tree_starts[:-1].astype(np.uint64),
        end=np.uint64(words.size),
        edge_places=forest.edge_places.copy(),
        trees_evaluated=forest.trees_evaluated,
    )


@cache
def shipped_detector(threads: int = 2) -> EdgeDetector:
    """The detector with the forest that comes with Hotgauge, made once."""
    return EdgeDetector(shipped_forest(), threads)
