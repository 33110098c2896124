"""The network of the classifier `relief` while it is trained: its first layers, its loss, and the slopes of that.

What the classifier itself computes of one end is in `vision/ingot/classifiers/relief.py`.
"""

from itertools import pairwise
from typing import cast

import numpy as np
from numpy.typing import NDArray

from appliance.training.relief_batches import Batch
from vision.ingot.classifiers.relief import CONVOLUTIONS, PLANES, STRIDE, Layers

Array = NDArray[np.float32]
Rng = np.random.Generator

SIDES, CHANNELS, HIDDEN = (5, 3, 3, 3), (PLANES, 24, 48, 64, 96), 64
CERTAINTY = 0.999  # chosen, of labels: a face may be blurred beyond recognition; log odds end near 7.6


def first_layers(rng: Rng) -> Layers:
    """Layers before training, after He et al. (doi:10.1109/ICCV.2015.123)."""
    shapes = [(side, side, *pair) for side, pair in zip(SIDES, pairwise(CHANNELS), strict=True)]
    shapes += [(6 * CHANNELS[-1], HIDDEN), (HIDDEN, 1)]
    scaled = [rng.standard_normal(shape) * np.sqrt(2 / np.prod(shape[:-1])) for shape in shapes]
    return [(weights.astype(np.float32), np.zeros(weights.shape[-1], np.float32)) for weights in scaled]


def loss_and_slopes(layers: Layers, batch: Batch) -> tuple[float, list[Array]]:
    """Mean cross entropy of a batch, and its slope in every weight and bias, in the order of the layers.

    Parameters
    ----------
    layers : list of (weights, bias)
    batch : Batch

    Returns
    -------
    loss : float
    slopes : list of ndarray
    """
    (*convolutions, hidden, last), ends = layers, len(batch.labels)
    around, planes = _planes(convolutions, batch.planes)
    flat = planes[-1].reshape(len(batch.planes), -1, planes[-1].shape[-1])
    highest = flat.argmax(axis=1)[:, None]
    found = np.concatenate([flat.mean(axis=1), np.take_along_axis(flat, highest, axis=1)[:, 0]], axis=1)
    of_end = found[:ends]
    compared = np.concatenate([of_end, of_end - found[batch.top], of_end - found[batch.bottom]], axis=1)
    inner = np.maximum(compared @ hidden[0] + hidden[1], 0)
    odds = (inner @ last[0] + last[1])[:, 0]
    wanted = batch.labels * CERTAINTY + (1 - CERTAINTY) / 2
    loss = float(np.mean(np.logaddexp(0, odds) - wanted * odds))
    back = ((1 / (1 + np.exp(-odds)) - wanted) / len(odds))[:, None]
    slopes = [inner.T @ back, back.sum(axis=0)]
    back = (back @ last[0].T) * (inner > 0)
    slopes = [compared.T @ back, back.sum(axis=0), *slopes]
    own, over_top, over_bottom = np.split(back @ hidden[0].T, 3, axis=1)
    back = np.zeros_like(found)
    back[:ends] = own + over_top + over_bottom
    np.subtract.at(back, batch.top, over_top)
    np.subtract.at(back, batch.bottom, over_bottom)
    half = back.shape[1] // 2
    spread = np.repeat(back[:, None, :half] / flat.shape[1], flat.shape[1], axis=1)
    chosen = np.take_along_axis(spread, highest, axis=1) + back[:, None, half:]
    np.put_along_axis(spread, highest, chosen, axis=1)
    spread = cast("Array", spread.reshape(planes[-1].shape))
    return loss, [*_slopes(convolutions, around, planes, spread), *cast("list[Array]", slopes)]


def _planes(convolutions: Layers, planes: Array) -> tuple[list[Array], list[Array]]:
    """What each convolution's kernels see, and the planes before and after each."""
    around: list[Array] = []
    every = [planes]
    for weights, bias in convolutions:
        around.append(_around(every[-1], len(weights)))
        every.append(np.maximum(_times(around[-1], weights.reshape(-1, weights.shape[-1])) + bias, 0))
    return around, every


def _times(values: Array, matrix: Array) -> Array:
    """The last axis times a matrix, in one product: numpy makes one of each row of pixels otherwise."""
    return (values.reshape(-1, values.shape[-1]) @ matrix).reshape(*values.shape[:-1], -1)


def _slopes(convolutions: Layers, around: list[Array], planes: list[Array], spread: Array) -> list[Array]:
    """Slopes of the loss in the convolutions' weights and biases, from those in their last planes."""
    slopes: list[Array] = []
    for number in reversed(range(CONVOLUTIONS)):
        weights, seen = convolutions[number][0], around[number]
        spread = spread * (planes[number + 1] > 0)
        slope = seen.reshape(-1, seen.shape[-1]).T @ spread.reshape(-1, spread.shape[-1])
        slopes = [slope.reshape(weights.shape), spread.sum(axis=(0, 1, 2)), *slopes]
        if number:
            back = _times(spread, weights.reshape(-1, weights.shape[-1]).T)
            spread = _scattered(back, planes[number].shape, len(weights))
    return slopes


def _padding(size: int, side: int) -> tuple[int, int]:
    padding = max((-(-size // STRIDE) - 1) * STRIDE + side - size, 0)
    return padding // 2, padding - padding // 2


def _around(values: Array, side: int) -> Array:
    """What each kernel sees, shape (n, rows, columns, side * side * channels)."""
    pad = _padding(values.shape[1], side)
    values = np.pad(values, ((0, 0), pad, pad, (0, 0)))
    channels = values.shape[3]
    rows = values.reshape(*values.shape[:2], -1)
    seen = np.lib.stride_tricks.sliding_window_view(rows, (side, side * channels), axis=(1, 2))
    seen = seen[:, ::STRIDE, :: STRIDE * channels]
    return seen.reshape(*seen.shape[:3], -1)


def _scattered(slopes: Array, shape: tuple[int, ...], side: int) -> Array:
    """Slopes of what kernels see, added up at the places that they see; the inverse of `_around`."""
    pad = _padding(shape[1], side)
    whole = np.zeros((shape[0], shape[1] + sum(pad), shape[2] + sum(pad), shape[3]), slopes.dtype)
    parts = slopes.reshape(*slopes.shape[:3], side, side, shape[3])
    rows, columns = STRIDE * slopes.shape[1], STRIDE * slopes.shape[2]
    for down in range(side):
        for right in range(side):
            whole[:, down : down + rows : STRIDE, right : right + columns : STRIDE] += parts[:, :, :, down, right]
    return whole[:, pad[0] : pad[0] + shape[1], pad[0] : pad[0] + shape[2]]
