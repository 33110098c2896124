"""Compiled kernels: patches walk down the trees, leaves vote where edges are, votes become edge strength.

Compiled code is kept on disk, and numba makes it anew when the file changes in which a function stands, not when
another one does. So nothing here calls or reads what is compiled in `channels`, nor the other way round.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

NODE_WORDS = 4  # offset of the first operand, of the second, threshold, address of the left child: 16 bytes
PLACE_ROWS = 16  # rows and columns of places that are walked together, so that their cells stay in the cache
PLACE_COLUMNS = 64
LANES = 8

_1, _2, _3 = np.uint64(1), np.uint64(2), np.uint64(3)


class Tables(NamedTuple):
    """The forest, laid out for one width of cells and of votes.

    Attributes
    ----------
    nodes : ndarray of uint32, shape (words,)
        All nodes, then the leaves from the word `first_leaf` on, which is a power of two above all nodes. A patch goes
        to the right child, one node behind the left one, if its feature reaches the threshold. A leaf leads to
        itself, so that patches that have arrived can go on walking with the others.
    thresholds : ndarray of float32, shape (words,)
        The same memory, read as numbers.
    roots : ndarray of uint64, shape (trees,)
    first_leaf : uint64
    edge_starts : ndarray of int64, shape (leaves + 1,)
    edge_offsets : ndarray of int64, shape (edge places,)
        Offsets into the flattened votes.
    trees_evaluated : int
    """

    nodes: NDArray[np.uint32]
    thresholds: NDArray[np.float32]
    roots: NDArray[np.uint64]
    first_leaf: np.uint64
    edge_starts: NDArray[np.int64]
    edge_offsets: NDArray[np.int64]
    trees_evaluated: int


class Workspace(NamedTuple):
    """Memory that one thread works in.

    Attributes
    ----------
    cells : ndarray of float32, shape (rows, PLANES, width)
        A place (i, j) reads from the cells (i to i + 15, j to j + 15).
    votes : ndarray of uint16, shape (rows, 2 * width)
    patches : ndarray of uint64, shape (places of a tile + LANES,)
    corners : ndarray of int64, shape (places of a tile + LANES,)
    arrived : ndarray of uint64, shape (LANES,)
    """

    cells: NDArray[np.float32]
    votes: NDArray[np.uint16]
    patches: NDArray[np.uint64]
    corners: NDArray[np.int64]
    arrived: NDArray[np.uint64]


@njit(nogil=True, cache=True)
def _step(nodes, thresholds, cells, patch, node):
    """The child to which the patch goes whose first cell is `patch`."""
    feature = cells[patch + nodes[node]] - cells[patch + nodes[node + _1]]
    right = np.uint64(feature >= thresholds[node + _2])
    return np.uint64(nodes[node + _3]) + (right << _2)


@njit(nogil=True, cache=True)
def _walk_together(tables, root, cells, patches, arrived):
    """Walk eight patches from the root to their leaves, in step, so that their memory accesses overlap."""
    nodes, thresholds, first_leaf = tables.nodes, tables.thresholds, tables.first_leaf
    p0, p1, p2, p3 = patches[0], patches[1], patches[2], patches[3]
    p4, p5, p6, p7 = patches[4], patches[5], patches[6], patches[7]
    n0 = n1 = n2 = n3 = n4 = n5 = n6 = n7 = root
    while (n0 & n1 & n2 & n3 & n4 & n5 & n6 & n7) < first_leaf:
        n0 = _step(nodes, thresholds, cells, p0, n0)
        n1 = _step(nodes, thresholds, cells, p1, n1)
        n2 = _step(nodes, thresholds, cells, p2, n2)
        n3 = _step(nodes, thresholds, cells, p3, n3)
        n4 = _step(nodes, thresholds, cells, p4, n4)
        n5 = _step(nodes, thresholds, cells, p5, n5)
        n6 = _step(nodes, thresholds, cells, p6, n6)
        n7 = _step(nodes, thresholds, cells, p7, n7)
    arrived[0], arrived[1], arrived[2], arrived[3] = n0, n1, n2, n3
    arrived[4], arrived[5], arrived[6], arrived[7] = n4, n5, n6, n7


@njit(nogil=True, cache=True)
def _places_of_tree(behind, tile, tables, work):
    """List the places of a tile that ask one tree, by their corners in cells and in votes; gives their number.

    The place (i, j) asks the trees i + j to i + j + trees_evaluated - 1, modulo all. `behind` is how many trees the
    tile's first place asks before this one.
    """
    rows, columns, cell_corner, vote_corner = tile
    trees = tables.roots.shape[0]
    cell_stride, vote_stride = work.cells.shape[1] * work.cells.shape[2], work.votes.shape[1]
    count = 0
    for i in range(rows):
        before = (behind - i) % trees
        for j in range(columns):
            work.patches[count] = np.uint64(cell_corner + i * cell_stride + j)
            work.corners[count] = vote_corner + 2 * (i * vote_stride + j)
            count += before < tables.trees_evaluated
            before = before - 1 if before > 0 else trees - 1
    return count


@njit(nogil=True, cache=True)
def _vote_in_tile(behind, tile, tables, work):
    """Let the places of a tile vote: rows, columns, corner in the flattened cells, corner in the flattened votes."""
    cells, votes = work.cells.reshape(-1), work.votes.reshape(-1)
    for tree in range(tables.roots.shape[0]):
        count = _places_of_tree(tree + behind, tile, tables, work)
        for lane in range(count, count + LANES):  # fill the last eight up
            work.patches[lane] = work.patches[0]
        for first in range(0, count, LANES):
            _walk_together(tables, tables.roots[tree], cells, work.patches[first : first + LANES], work.arrived)
            for lane in range(min(LANES, count - first)):
                leaf = np.int64((work.arrived[lane] - tables.first_leaf) >> _2)
                corner = work.corners[first + lane]
                for edge in range(tables.edge_starts[leaf], tables.edge_starts[leaf + 1]):
                    votes[corner + tables.edge_offsets[edge]] += np.uint16(1)


@njit(nogil=True, cache=True)
def count_votes(rows, columns, held, phase, tables, work):
    """Add the votes of all places in a rectangle of the grid to `work.votes`.

    Parameters
    ----------
    rows, columns : tuple of int
        First and end row, first and end column on the grid of `work.cells` and `work.votes`.
    held : int
        The row of the grid that stands first in `work.cells`.
    phase : int
        i + j of the grid's first place on the grid of the whole image.
    tables : Tables
    work : Workspace
    """
    cell_stride, vote_stride = work.cells.shape[1] * work.cells.shape[2], work.votes.shape[1]
    for row in range(rows[0], rows[1], PLACE_ROWS):
        for column in range(columns[0], columns[1], PLACE_COLUMNS):
            cell_corner = (row - held) * cell_stride + column
            vote_corner = 2 * (row * vote_stride + column)
            size = min(PLACE_ROWS, rows[1] - row), min(PLACE_COLUMNS, columns[1] - column)
            _vote_in_tile(-(phase + row + column), (size[0], size[1], cell_corner, vote_corner), tables, work)


@njit(nogil=True, cache=True)
def _reflected(index, length):
    if index < 0:
        return -index
    return index if index < length else 2 * length - 2 - index


@njit(nogil=True, cache=True)
def smoothed_votes(votes, place, region, shape, weight, strength):
    """Smooth votes by [1 2 1] / 4 both ways and weight them.

    Parameters
    ----------
    votes : ndarray of uint16, shape (rows, columns)
        Of the pixel `place` and those below and to the right of it.
    place : tuple of int
        Row and column in the image.
    region : tuple of int
        First row, end row, first column, end column in the image: what is wanted.
    shape : tuple of int
        Rows and columns of the image, made even, at whose border votes are reflected.
    weight : float32
    strength : ndarray of float32, shape (rows of the region, columns of the region)
        The result.
    """
    first_row, end_row, first_column, end_column = region
    sums = np.empty(end_column - first_column + 2, np.int32)
    inner = sums[1:-1]
    left = first_column - place[1]
    for row in range(first_row, end_row):
        above = votes[_reflected(row - 1, shape[0]) - place[0]]
        here = votes[row - place[0]]
        below = votes[_reflected(row + 1, shape[0]) - place[0]]
        for x in range(inner.shape[0]):
            inner[x] = 2 * here[left + x] + above[left + x] + below[left + x]
        for x, column in ((0, first_column - 1), (sums.shape[0] - 1, end_column)):
            source = _reflected(column, shape[1]) - place[1]
            sums[x] = 2 * here[source] + above[source] + below[source]
        smoothed = strength[row - first_row]
        for x in range(smoothed.shape[0]):
            smoothed[x] = weight * np.float32(2 * sums[x + 1] + sums[x] + sums[x + 2])
