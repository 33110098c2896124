"""Compiled kernels: patches walk down the trees, leaves vote where edges are, votes become edge strength.

Compiled code is kept on disk, and numba makes it anew when the file changes in which a function stands, not when
another one does. So nothing here calls or reads what is compiled in `channels`, nor the other way round.
"""

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

NODE_WORDS = 4  # offset of the first operand, of the second, threshold, address of the left child: 16 bytes
PLACE_ROWS = 16  # rows and columns of places that are walked together, so that their cells stay in the cache
PLACE_COLUMNS = 64
LANES = 4  # patches side by side that walk together

_1, _2, _3 = np.uint64(1), np.uint64(2), np.uint64(3)
_31, _32 = np.uint64(31), np.uint64(32)
_NODE = np.uint64(NODE_WORDS)
_NOBODY = np.uint64(0)


class Tables(NamedTuple):
    """The forest, laid out for one width of cells.

    Attributes
    ----------
    nodes : ndarray of uint32, shape (words,)
        A patch goes to the right child, one node behind the left one, if its feature reaches the threshold. A leaf
        has no operands but the start and end of its edges instead, and `end`, an address behind all nodes, as child.
    thresholds : ndarray of float32, shape (words,)
        The same memory, read as numbers.
    roots : ndarray of uint64, shape (trees,)
    end : uint64
    edge_places : ndarray of uint8, shape (places,)
        16 row + column in the label mask.
    trees_evaluated : int
    """

    nodes: NDArray[np.uint32]
    thresholds: NDArray[np.float32]
    roots: NDArray[np.uint64]
    end: np.uint64
    edge_places: NDArray[np.uint8]
    trees_evaluated: int


class Workspace(NamedTuple):
    """Memory that one thread works in.

    Attributes
    ----------
    cells : ndarray of float32, shape (rows, PLANES, width)
        A place (i, j) reads from the cells (i to i + 15, j to j + 15).
    votes : ndarray of uint16, shape (rows, 2 * width)
    waiting_nodes, waiting_lanes : ndarray of uint64, shape (LANES,)
        Where patches wait that parted from the others.
    """

    cells: NDArray[np.float32]
    votes: NDArray[np.uint16]
    waiting_nodes: NDArray[np.uint64]
    waiting_lanes: NDArray[np.uint64]


def _typed_reaching(_typing: Any, cells: Any, first: Any, second: Any, threshold: Any) -> Any:
    """Which of four neighbours reach the threshold: bit k is cells[first + k] - cells[second + k] >= threshold.

    One vector instruction each to load, subtract, compare and gather the bits; numba would do them one by one.
    """

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        four = ir.VectorType(ir.FloatType(), LANES)

        def four_from(index: Any) -> Any:
            values = builder.load(builder.bitcast(builder.gep(data, [index]), four.as_pointer()))
            values.align = 4
            return values

        difference = builder.fsub(four_from(arguments[1]), four_from(arguments[2]))
        thresholds = ir.Constant(four, ir.Undefined)
        for lane in range(LANES):
            thresholds = builder.insert_element(thresholds, arguments[3], ir.Constant(ir.IntType(32), lane))
        bits = builder.bitcast(builder.fcmp_ordered(">=", difference, thresholds), ir.IntType(LANES))
        return builder.zext(bits, ir.IntType(64))

    return types.uint64(cells, first, second, threshold), build


_reaching: Any = intrinsic(_typed_reaching)


def _typed_add_votes(_typing: Any, votes: Any, pixel: Any, first_pair: Any, second_pair: Any) -> Any:
    """Add votes to the pixels 0, 2, 4 and 6 behind one, in one vector instruction each to load, add and store.

    A pair is a uint64 that holds the votes of two pixels in its lower 16 bits and in those from 32 on.
    """

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        pairs = ir.VectorType(ir.IntType(64), 2)
        place = builder.bitcast(builder.gep(data, [arguments[1]]), pairs.as_pointer())
        held = builder.load(place)
        held.align = 2
        more = ir.Constant(pairs, ir.Undefined)
        for number in range(2):
            more = builder.insert_element(more, arguments[2 + number], ir.Constant(ir.IntType(32), number))
        builder.store(builder.add(held, more), place, align=2)
        return context.get_dummy_value()

    return types.void(votes, pixel, first_pair, second_pair), build


_add_votes: Any = intrinsic(_typed_add_votes)


@njit(nogil=True, cache=True)
def _vote(tables, leaf, lanes, votes, corner, vote_stride):
    """Add the leaf's edges to the votes of all patches in `lanes`, whose label masks lie two pixels apart."""
    first_pair = (lanes & _1) | ((lanes & _2) << _31)
    second_pair = ((lanes >> _2) & _1) | ((lanes >> _3) << _32)
    for edge in range(np.int64(tables.nodes[leaf]), np.int64(tables.nodes[leaf + _1])):
        place = np.int64(tables.edge_places[edge])
        _add_votes(votes, corner + (place >> 4) * vote_stride + (place & 15), first_pair, second_pair)


@njit(nogil=True, cache=True)
def _walk(tables, root, lanes, patch, corner, cells, votes, work):
    """Take up to four patches side by side to their leaves; they go together as long as they take the same way.

    Neighbours mostly do, so that a node costs little more for four patches than for one; and since the way is mostly
    the one that the processor expects, it does not wait for the comparison before it reads the next node.
    """
    nodes, thresholds = tables.nodes, tables.thresholds
    waiting = 0
    node = root
    while True:
        child = np.uint64(nodes[node + _3])
        while child < tables.end:
            first, second = patch + nodes[node], patch + nodes[node + _1]
            right = _reaching(cells, first, second, thresholds[node + _2]) & lanes
            node = child
            if right == lanes:
                node = child + _NODE
            elif right != _NOBODY:
                work.waiting_nodes[waiting], work.waiting_lanes[waiting] = child + _NODE, right
                waiting += 1
                lanes ^= right
            child = np.uint64(nodes[node + _3])
        _vote(tables, node, lanes, votes, corner, work.votes.shape[1])
        if waiting == 0:
            return
        waiting -= 1
        node, lanes = work.waiting_nodes[waiting], work.waiting_lanes[waiting]


@njit(nogil=True, cache=True)
def _vote_in_tile(phase, size, cell_corner, vote_corner, tables, work):
    """Let the places of a tile (rows, columns) vote; `phase` is i + j of its first place on the whole grid.

    The place (i, j) asks the trees i + j to i + j + trees_evaluated - 1, modulo all: of each tree the places of a row
    that ask it are runs side by side.
    """
    cells, votes = work.cells.reshape(-1), work.votes.reshape(-1)
    cell_stride, vote_stride = work.cells.shape[1] * work.cells.shape[2], work.votes.shape[1]
    trees, run = tables.roots.shape[0], tables.trees_evaluated
    rows, columns = size
    for tree in range(trees):
        for i in range(rows):
            for start in range((tree - phase - i - run + 1) % trees - trees, columns, trees):
                end = min(start + run, columns)
                for j in range(max(start, 0), end, LANES):
                    lanes = (_1 << np.uint64(min(LANES, end - j))) - _1
                    patch = np.uint64(cell_corner + i * cell_stride + j)
                    corner = vote_corner + 2 * (i * vote_stride + j)
                    _walk(tables, tables.roots[tree], lanes, patch, corner, cells, votes, work)


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
            size = min(PLACE_ROWS, rows[1] - row), min(PLACE_COLUMNS, columns[1] - column)
            cell_corner = (row - held) * cell_stride + column
            _vote_in_tile(phase + row + column, size, cell_corner, 2 * (row * vote_stride + column), tables, work)


@njit(nogil=True, cache=True)
def _reflected(index, length):
    if index < 0:
        return -index
    return index if index < length else 2 * length - 2 - index


@njit(nogil=True, cache=True)
def smooth_votes(votes, place, part, shape, weight, strength, corner):
    """Smooth votes by [1 2 1] / 4 both ways and weight them.

    Parameters
    ----------
    votes : ndarray of uint16, shape (rows, columns)
        Of the pixel `place` and those below and to the right of it.
    place : tuple of int
        Row and column in the image.
    part : tuple of int
        First row, end row, first column, end column in the image: what is wanted.
    shape : tuple of int
        Rows and columns of the image, made even, at whose border votes are reflected.
    weight : float32
    strength : ndarray of float32, shape (rows, columns)
        Where the result goes.
    corner : tuple of int
        Row and column in the image of `strength`'s first pixel.
    """
    first_row, end_row, first_column, end_column = part
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
        smoothed = strength[row - corner[0], first_column - corner[1] : end_column - corner[1]]
        for x in range(smoothed.shape[0]):
            smoothed[x] = weight * np.float32(2 * sums[x + 1] + sums[x] + sums[x + 2])
