"""Trains the network of the classifier `relief` on rendered lines: `python -m appliance.training.ingot_relief`.

Cross entropy, by AdamW. A batch shows some ends of each of its lines beside that line's references, now and then beside
another line's.
"""

import argparse
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from appliance.training.adamw import AdamW
from appliance.training.rendered_ends import RenderedLine, rendered_line
from vision.ingot.classifiers.relief import CONVOLUTIONS, MODEL, PLANES, STRIDE, relief

Array = NDArray[np.float32]
Indices = NDArray[np.int64]
Layers = list[tuple[Array, Array]]
Rng = np.random.Generator

SEED = 777  # no study draws faces from it
LINES, FACES, VIEWS = 1500, 6, 2
LINES_A_BATCH, ENDS_A_LINE = 24, 5
STEPS, FALLING_STEPS = 1500, 2000  # chosen: the rate falls along half a cosine, and training ends before it is 0
SIDES, CHANNELS, HIDDEN = (5, 3, 3, 3), (PLANES, 16, 32, 48, 64), 48
RATE = 3e-3
CERTAINTY = 0.99  # of labels: a face may be blurred beyond recognition
SHARE_OF_WRONG_REFERENCES = 0.1  # of the ends: compared with another line's


class Batch(NamedTuple):
    """Ends and references of some lines, and who is compared with whom.

    Attributes
    ----------
    planes : ndarray of float32, shape (n, 64, 64, 3)
        The ends first.
    top, bottom : ndarray of int, shape (ends,)
        Where among `planes` an end's references are.
    labels : ndarray of float32, shape (ends,)
        1 top, 0 bottom.
    """

    planes: Array
    top: Indices
    bottom: Indices
    labels: Array


def main() -> None:
    """Draw, train, write the model."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lines", type=int, default=LINES)
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--output", type=Path, default=MODEL)
    given = parser.parse_args()
    write(trained(given.lines, given.steps), given.output)


def trained(lines: int, steps: int) -> Layers:
    """Layers as the command gives them; on one computer, with one thread, always the same.

    Parameters
    ----------
    lines, steps : int
    """
    rng = np.random.default_rng(SEED)
    layers = first_layers(rng)
    train(layers, drawn(lines), steps, rng)
    return layers


def write(layers: Layers, output: Path) -> None:
    """Write a model; the same layers give the same bytes.

    Parameters
    ----------
    layers : list of (weights, bias)
    output : Path
    """
    arrays = {
        f"{kind}{number}": one for number, pair in enumerate(layers) for kind, one in zip("Wb", pair, strict=True)
    }
    np.savez(output, allow_pickle=False, **arrays)


def drawn(lines: int) -> list[RenderedLine]:
    """Lines to train on."""
    rng = np.random.default_rng(SEED)
    return [rendered_line(rng, FACES, VIEWS) for _ in tqdm(range(lines), unit="line", disable=None)]


def first_layers(rng: Rng) -> Layers:
    """Layers before training, after He et al. (doi:10.1109/ICCV.2015.123)."""
    shapes = [(side, side, *pair) for side, pair in zip(SIDES, pairwise(CHANNELS), strict=True)]
    shapes += [(6 * CHANNELS[-1], HIDDEN), (HIDDEN, 1)]
    scaled = [rng.standard_normal(shape) * np.sqrt(2 / np.prod(shape[:-1])) for shape in shapes]
    return [(weights.astype(np.float32), np.zeros(weights.shape[-1], np.float32)) for weights in scaled]


def train(layers: Layers, lines: list[RenderedLine], steps: int, rng: Rng) -> None:
    """Change layers so that they tell tops from bottoms.

    Parameters
    ----------
    layers : list of (weights, bias)
    lines : list of RenderedLine
    steps : int
    rng : numpy.random.Generator
    """
    optimiser = AdamW([one for pair in layers for one in pair])
    for step in tqdm(range(steps), unit="step", disable=None):
        _, slopes = loss_and_slopes(layers, batch_of(lines, rng))
        optimiser.step(slopes, RATE * 0.5 * (1 + np.cos(np.pi * step / FALLING_STEPS)))


def batch_of(lines: list[RenderedLine], rng: Rng) -> Batch:
    """Some ends of some lines, turned over and mirrored at random."""
    numbers: list[int] = rng.integers(len(lines), size=LINES_A_BATCH).tolist()
    chosen = [lines[number] for number in numbers]
    picked = [rng.integers(len(line.ends), size=ENDS_A_LINE) for line in chosen]
    count = LINES_A_BATCH * ENDS_A_LINE
    ends = np.concatenate([line.ends[which] for line, which in zip(chosen, picked, strict=True)])
    references = np.concatenate([line.references for line in chosen])
    images = [_mirrored(image, rng) for image in np.concatenate([ends, references])]
    of = np.repeat(np.arange(LINES_A_BATCH), ENDS_A_LINE)
    strange = rng.random(count) < SHARE_OF_WRONG_REFERENCES
    of = np.where(strange, rng.integers(LINES_A_BATCH, size=count), of)
    labels = np.concatenate([line.tops[which] for line, which in zip(chosen, picked, strict=True)])
    planes = np.stack([relief(image) for image in images])
    return Batch(planes, count + 2 * of, count + 2 * of + 1, labels.astype(np.float32))


def _mirrored(image: NDArray[np.uint8], rng: Rng) -> NDArray[np.uint8]:
    return image[:, ::-1] if rng.random() < 0.5 else image


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
        every.append(np.maximum(around[-1] @ weights.reshape(-1, weights.shape[-1]) + bias, 0))
    return around, every


def _slopes(convolutions: Layers, around: list[Array], planes: list[Array], spread: Array) -> list[Array]:
    """Slopes of the loss in the convolutions' weights and biases, from those in their last planes."""
    slopes: list[Array] = []
    for number in reversed(range(CONVOLUTIONS)):
        weights, seen = convolutions[number][0], around[number]
        spread = spread * (planes[number + 1] > 0)
        slope = seen.reshape(-1, seen.shape[-1]).T @ spread.reshape(-1, spread.shape[-1])
        slopes = [slope.reshape(weights.shape), spread.sum(axis=(0, 1, 2)), *slopes]
        if number:
            spread = _scattered(spread @ weights.reshape(-1, weights.shape[-1]).T, planes[number].shape, len(weights))
    return slopes


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
