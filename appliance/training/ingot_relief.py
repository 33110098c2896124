"""Trains the network of the classifier `relief` on rendered ends: `python -m appliance.training.ingot_relief`.

AdamW (arXiv:1711.05101) on cross entropy, in numpy: the network is so small that no library for it is needed.
"""

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from appliance.simulation.ingots.faces import LABELS
from appliance.training.rendered_ends import random_face, rendered_end
from vision.ingot.classifiers.relief import MODEL, STRIDE, relief

Array = NDArray[np.float32]
Layers = list[tuple[Array, Array]]

SEED = 777  # no study draws faces from it
FACES, VIEWS, EPOCHS, BATCH = 8000, 4, 16, 128
SIDES, CHANNELS, HIDDEN = (5, 3, 3), (2, 12, 24, 40), 32
RATE, DECAY, MOMENTS, LEAST_MOMENT = 4e-3, 1e-4, (0.9, 0.999), 1e-8
CERTAINTY = 0.98  # of labels: a face may be blurred beyond recognition


def main() -> None:
    """Draw, train, write the model."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faces", type=int, default=FACES)
    parser.add_argument("--output", type=Path, default=MODEL)
    given = parser.parse_args()
    images, tops = drawn(given.faces)
    layers = trained(images, tops)
    arrays = {
        f"{kind}{number}": one for number, pair in enumerate(layers) for kind, one in zip("Wb", pair, strict=True)
    }
    np.savez(given.output, allow_pickle=False, **arrays)


def drawn(faces: int) -> tuple[Array, Array]:
    """Inputs of the network, shape (n, 64, 64, 2), and whether each is a top."""
    rng = np.random.default_rng(SEED)
    images: list[Array] = []
    for number in tqdm(range(faces), unit="face", disable=None):
        light = random_face(LABELS[number % 2], rng)
        images += [relief(rendered_end(light, rng)) for _ in range(VIEWS)]
    return np.array(images), np.repeat(np.arange(faces) % 2 == 0, VIEWS).astype(np.float32)


def first_layers(rng: np.random.Generator) -> Layers:
    """Layers before training, after He et al. (doi:10.1109/ICCV.2015.123)."""
    shapes = [(side, side, *pair) for side, pair in zip(SIDES, pairwise(CHANNELS), strict=True)]
    shapes += [(2 * CHANNELS[-1], HIDDEN), (HIDDEN, 1)]
    scaled = [rng.standard_normal(shape) * np.sqrt(2 / np.prod(shape[:-1])) for shape in shapes]
    return [(weights.astype(np.float32), np.zeros(weights.shape[-1], np.float32)) for weights in scaled]


def trained(images: Array, tops: Array, epochs: int = EPOCHS) -> Layers:
    """Layers that tell tops from bottoms.

    Parameters
    ----------
    images : ndarray of float32, shape (n, 64, 64, 2)
    tops : ndarray of float32, shape (n,)
    epochs : int

    Returns
    -------
    list of (weights, bias)
    """
    rng = np.random.default_rng(SEED)
    layers = first_layers(rng)
    parameters = [one for pair in layers for one in pair]
    first, second = ([np.zeros_like(one) for one in parameters] for _ in range(2))
    steps = epochs * (len(images) // BATCH)
    for step in tqdm(range(steps), unit="step", disable=None):
        chosen = rng.integers(len(images), size=BATCH)
        batch = images[chosen]
        batch[: BATCH // 2] = batch[: BATCH // 2, :, ::-1]
        _, slopes = loss_and_slopes(layers, batch, tops[chosen])
        rate = RATE * 0.5 * (1 + np.cos(np.pi * step / steps))
        for number, slope in enumerate(slopes):
            first[number] += (1 - MOMENTS[0]) * (slope - first[number])
            second[number] += (1 - MOMENTS[1]) * (slope**2 - second[number])
            unbiased = first[number] / (1 - MOMENTS[0] ** (step + 1))
            spread = np.sqrt(second[number] / (1 - MOMENTS[1] ** (step + 1))) + LEAST_MOMENT
            parameters[number] -= (rate * (unbiased / spread + DECAY * parameters[number])).astype(np.float32)
    return layers


def loss_and_slopes(layers: Layers, images: Array, tops: Array) -> tuple[float, list[Array]]:
    """Mean cross entropy of a batch, and its slope in every weight and bias, in the order of the layers.

    Parameters
    ----------
    layers : list of (weights, bias)
    images : ndarray, shape (n, 64, 64, 2)
    tops : ndarray, shape (n,)

    Returns
    -------
    loss : float
    slopes : list of ndarray
    """
    (*convolutions, hidden, last), values = layers, images
    around: list[Array] = []
    planes = [images]
    for weights, bias in convolutions:
        around.append(_around(values, len(weights)))
        values = np.maximum(around[-1] @ weights.reshape(-1, weights.shape[-1]) + bias, 0)
        planes.append(values)
    flat = values.reshape(len(values), -1, values.shape[-1])
    highest = flat.argmax(axis=1)
    pooled = np.concatenate([flat.mean(axis=1), np.take_along_axis(flat, highest[:, None], axis=1)[:, 0]], axis=1)
    inner = np.maximum(pooled @ hidden[0] + hidden[1], 0)
    odds = (inner @ last[0] + last[1])[:, 0]
    wanted = tops * CERTAINTY + (1 - CERTAINTY) / 2
    loss = float(np.mean(np.logaddexp(0, odds) - wanted * odds))
    back = ((1 / (1 + np.exp(-odds)) - wanted) / len(odds))[:, None]
    slopes = [inner.T @ back, back.sum(axis=0)]
    back = (back @ last[0].T) * (inner > 0)
    slopes = [pooled.T @ back, back.sum(axis=0), *slopes]
    back = back @ hidden[0].T
    half = back.shape[1] // 2
    spread = np.repeat(back[:, None, :half] / flat.shape[1], flat.shape[1], axis=1)
    chosen = np.take_along_axis(spread, highest[:, None], axis=1) + back[:, None, half:]
    np.put_along_axis(spread, highest[:, None], chosen, axis=1)
    spread = spread.reshape(values.shape)
    for (weights, _), seen, before, after in reversed(
        list(zip(convolutions, around, planes[:-1], planes[1:], strict=True))
    ):
        spread = spread * (after > 0)
        slope = seen.reshape(-1, seen.shape[-1]).T @ spread.reshape(-1, spread.shape[-1])
        slopes = [slope.reshape(weights.shape), spread.sum(axis=(0, 1, 2)), *slopes]
        spread = _scattered(spread @ weights.reshape(-1, weights.shape[-1]).T, before.shape, len(weights))
    return loss, [np.asarray(slope) for slope in slopes]


def _padding(size: int, side: int) -> tuple[int, int]:
    padding = max((-(-size // STRIDE) - 1) * STRIDE + side - size, 0)
    return padding // 2, padding - padding // 2


def _around(values: Array, side: int) -> Array:
    """What each kernel sees, shape (n, rows, columns, side * side * channels)."""
    pad = _padding(values.shape[1], side)
    values = np.pad(values, ((0, 0), pad, pad, (0, 0)))
    seen = np.lib.stride_tricks.sliding_window_view(values, (side, side), axis=(1, 2))[:, ::STRIDE, ::STRIDE]
    return np.ascontiguousarray(seen.transpose(0, 1, 2, 4, 5, 3)).reshape(*seen.shape[:3], -1)


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


if __name__ == "__main__":
    main()
