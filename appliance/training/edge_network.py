"""Trains a network to see edges: `python -m appliance.training.edge_network --output FILE.onnx`.

It learns from the forest's scenes and is not served: the forest sees fewer false edges (docs/methods/edges.md). A chain
of convolutions at half resolution, dilated (Yu and Koltun, arXiv:1511.07122) so that 16 channels see 70 x 70 pixels;
the last layer's four planes are the four pixels of a cell. Cross entropy of each pixel against the outlines of
`edge_scenes`, as the forest's masks have them: both pixels at each border between segments. Needs the extra `training`,
whose library writes ONNX.
"""

import argparse
import importlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from appliance.training.adamw import AdamW
from appliance.training.edge_scenes import UNSEEN_MARGIN_PX, edge_examples
from vision.edges.forest.training import Example

Array = NDArray[np.float32]
Weights = list[tuple[Array, Array]]
Rng = np.random.Generator
Scalar = TypeVar("Scalar", bound=np.generic)

DARK_CODE = 0.02  # chosen: added to codes (0 to 1) before their logarithm, so that black noise stays small
MIDDLE_LOG = 2.0  # brings the logarithms near 0
CELL_PX = 2  # side of a cell: the first layer goes over every second row and column
SEED = 31  # no study draws scenes from it
EXAMPLES, EXAMPLES_A_BATCH = 1600, 12  # chosen: a quarter of an hour of one core in all
# Chosen: the rate rises, then falls along half a cosine, and training ends before it is 0.
RATE, WARM_STEPS, STEPS, FALLING_STEPS = 4e-3, 50, 1000, 1200
BORDER_PX = 16  # chosen: pixels at a crop's sides, where the network sees its padding, are not judged
EDGE_WEIGHT = 3.0  # chosen: of pixels on an edge, which are one in 30
OPSET, IR_VERSION = 13, 8  # of ONNX; old ones, that every reader knows
DTYPE_KEPT = np.float16  # of the examples' pictures, which would not fit memory otherwise


class Layer(NamedTuple):
    """One convolution: side of its kernels, distance between what they see, planes in and out."""

    side: int
    dilation: int
    stride: int
    planes_in: int
    planes_out: int

    @property
    def padding(self) -> int:
        """Rows and columns of zeros on each side that keep the size."""
        return self.dilation * (self.side // 2)


LAYERS = (
    Layer(5, 1, CELL_PX, 3, 16),
    Layer(3, 1, 1, 16, 16),
    Layer(3, 2, 1, 16, 16),
    Layer(3, 4, 1, 16, 16),
    Layer(3, 8, 1, 16, 16),
    Layer(3, 1, 1, 16, CELL_PX**2),
)
# Pixels further away do not change a strength.
REACH_PX = CELL_PX * sum(layer.padding for layer in LAYERS[1:]) + LAYERS[0].padding + CELL_PX


def network_input(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """What the network is given: logarithms of the codes, in which a change of exposure is a constant.

    Parameters
    ----------
    image : ndarray of float32, shape (..., rows, columns, 3)
        Red-green-blue, 0 to 1; grey three times.

    Returns
    -------
    ndarray of float32, same shape
    """
    return np.log(image + np.float32(DARK_CODE)) + np.float32(MIDDLE_LOG)


class Examples(NamedTuple):
    """Crops with their outlines.

    Attributes
    ----------
    images : ndarray of float16, shape (n, CROP_PX, CROP_PX, 3)
    edges : ndarray of uint8, shape (n, CROP_PX, CROP_PX)
        1 on both pixels beside an outline.
    weights : ndarray of float16, same shape
        Of each pixel in the loss; 0 where an outline cannot be seen.
    """

    images: NDArray[np.float16]
    edges: NDArray[np.uint8]
    weights: NDArray[np.float16]


def main() -> None:
    """Draw, train, write the model."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--examples", type=int, default=EXAMPLES)
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--output", type=Path, required=True)
    given = parser.parse_args()
    drawn = edge_examples(SEED, given.examples)
    examples = kept(tqdm(drawn, total=given.examples, unit="crop", disable=None))
    rng = np.random.default_rng(SEED)
    weights = first_weights(rng)
    train(weights, examples, given.steps, rng)
    write(weights, given.output)


def kept(drawn: Iterable[Example]) -> Examples:
    """Examples in memory, grey ones as three equal colours."""
    images: list[NDArray[np.float16]] = []
    edges: list[NDArray[np.uint8]] = []
    weights: list[NDArray[np.float16]] = []
    for example in drawn:
        image = example.image if example.image.ndim == 3 else np.repeat(example.image[..., None], 3, axis=2)
        images.append(image.astype(DTYPE_KEPT))
        segments = example.segments[0]
        edges.append(outlines(segments))
        weights.append(_pixel_weights(segments, edges[-1]))
    return Examples(np.stack(images), np.stack(edges), np.stack(weights))


def outlines(segments: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Both pixels at each border between segments that are known, shape as `segments`."""
    known = segments >= 0
    edges = np.zeros(segments.shape, np.uint8)
    for here, there in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        border = (segments[here] != segments[there]) & known[here] & known[there]
        edges[here] |= border
        edges[there] |= border
    return edges


def _pixel_weights(segments: NDArray[np.integer], edges: NDArray[np.uint8]) -> NDArray[np.float16]:
    side = 2 * UNSEEN_MARGIN_PX + 1
    unseen = cv2.dilate((segments < 0).astype(np.uint8), np.ones((side, side), np.uint8)) > 0
    weights = np.where(unseen, 0.0, 1.0 + (EDGE_WEIGHT - 1.0) * edges)
    inside = np.zeros(weights.shape)
    inside[BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX] = 1
    return (weights * inside).astype(np.float16)


def first_weights(rng: Rng) -> Weights:
    """Weights before training, after He et al. (doi:10.1109/ICCV.2015.123)."""
    shapes = [(layer.side, layer.side, layer.planes_in, layer.planes_out) for layer in LAYERS]
    scaled = [rng.standard_normal(shape) * np.sqrt(2 / np.prod(shape[:-1])) for shape in shapes]
    return [(weights.astype(np.float32), np.zeros(weights.shape[-1], np.float32)) for weights in scaled]


def train(weights: Weights, examples: Examples, steps: int, rng: Rng) -> None:
    """Change weights so that strengths are the probabilities of an outline.

    Parameters
    ----------
    weights : list of (kernels, bias)
    examples : Examples
    steps : int
    rng : numpy.random.Generator
    """
    optimiser = AdamW([one for pair in weights for one in pair])
    for step in tqdm(range(steps), unit="step", disable=None):
        _, slopes = loss_and_slopes(weights, batch_of(examples, rng))
        rising = min(1.0, (step + 1) / WARM_STEPS)
        optimiser.step(slopes, RATE * rising * 0.5 * (1 + np.cos(np.pi * step / FALLING_STEPS)))


def batch_of(examples: Examples, rng: Rng) -> Examples:
    """Some examples, mirrored and turned over at random."""
    chosen = rng.integers(len(examples.images), size=EXAMPLES_A_BATCH)
    swapped = rng.random() < 0.5
    down, right = rng.choice((1, -1), size=2).tolist()

    def turned(part: NDArray[Scalar]) -> NDArray[Scalar]:
        part = part[chosen]
        return (part.swapaxes(1, 2) if swapped else part)[:, ::down, ::right]

    return Examples(turned(examples.images), turned(examples.edges), turned(examples.weights))


def loss_and_slopes(weights: Weights, batch: Examples) -> tuple[float, list[Array]]:
    """Weighted mean cross entropy of a batch, and its slope in every kernel and bias, in the order of the layers.

    Parameters
    ----------
    weights : list of (kernels, bias)
    batch : Examples
    """
    planes = [network_input(batch.images.astype(weights[0][0].dtype))]
    seen: list[Array] = []
    for layer, (kernels, bias) in zip(LAYERS, weights, strict=True):
        seen.append(_seen(planes[-1], layer))
        above = seen[-1] @ kernels.reshape(-1, layer.planes_out) + bias
        planes.append(above if layer is LAYERS[-1] else np.maximum(above, 0))
    wanted, weight = (_cells(part.astype(np.float32)) for part in (batch.edges, batch.weights))
    weight = weight / max(float(weight.sum()), 1.0)
    odds = planes[-1]
    loss = float(np.sum(weight * (np.logaddexp(0, odds) - wanted * odds)))
    back = cast("Array", weight * (1 / (1 + np.exp(-odds)) - wanted))
    return loss, _slopes(weights, seen, planes, back)


def _slopes(weights: Weights, seen: list[Array], planes: list[Array], back: Array) -> list[Array]:
    """Slopes of the loss in kernels and biases, from those in the last planes."""
    slopes: list[Array] = []
    for number in reversed(range(len(LAYERS))):
        layer, kernels = LAYERS[number], weights[number][0]
        if layer is not LAYERS[-1]:
            back = back * (planes[number + 1] > 0)
        flat = back.reshape(-1, layer.planes_out)
        slope = seen[number].reshape(len(flat), -1).T @ flat
        slopes = [slope.reshape(kernels.shape), flat.sum(axis=0), *slopes]
        if number:
            back = _scattered(back @ kernels.reshape(-1, layer.planes_out).T, planes[number].shape, layer)
    return slopes


def _cells(plane: Array) -> Array:
    """Pixels as the planes of their cells: shape (n, rows, columns) to (n, rows / 2, columns / 2, 4)."""
    count, rows, columns = plane.shape
    parts = plane.reshape(count, rows // CELL_PX, CELL_PX, columns // CELL_PX, CELL_PX)
    return parts.transpose(0, 1, 3, 2, 4).reshape(count, rows // CELL_PX, columns // CELL_PX, -1)


def _taps(layer: Layer, shape: tuple[int, ...]) -> list[tuple[slice, slice, slice]]:
    """Which places of a padded plane each tap of a kernel sees, row by row."""
    rows, columns = (-(-size // layer.stride) for size in shape[1:3])
    reach = layer.stride * (rows - 1) + 1, layer.stride * (columns - 1) + 1
    offsets = range(0, layer.side * layer.dilation, layer.dilation)
    return [
        (np.s_[:], slice(down, down + reach[0], layer.stride), slice(right, right + reach[1], layer.stride))
        for down in offsets
        for right in offsets
    ]


def _seen(values: Array, layer: Layer) -> Array:
    """What each kernel sees, shape (n, rows, columns, side * side * planes)."""
    pad = (layer.padding, layer.padding)
    padded = np.pad(values, ((0, 0), pad, pad, (0, 0)))
    return np.concatenate([padded[tap] for tap in _taps(layer, values.shape)], axis=-1)


def _scattered(slopes: Array, shape: tuple[int, ...], layer: Layer) -> Array:
    """Slopes of what kernels see, added up at the places that they see; the inverse of `_seen`."""
    pad = layer.padding
    whole = np.zeros((shape[0], shape[1] + 2 * pad, shape[2] + 2 * pad, shape[3]), slopes.dtype)
    for number, tap in enumerate(_taps(layer, shape)):
        whole[tap] += slopes[..., number * shape[3] : (number + 1) * shape[3]]
    return whole[:, pad : pad + shape[1], pad : pad + shape[2]]


def write(weights: Weights, output: Path) -> None:
    """Write the network as ONNX: pictures of any even size in, strengths 0 to 1 out.

    Parameters
    ----------
    weights : list of (kernels, bias)
    output : Path
    """
    onnx: Any = importlib.import_module("onnx")
    nodes: list[Any] = []
    parts: list[Any] = []
    name = "picture"
    for number, (layer, (kernels, bias)) in enumerate(zip(LAYERS, weights, strict=True)):
        arrays = {f"kernels{number}": np.ascontiguousarray(kernels.transpose(3, 2, 0, 1)), f"bias{number}": bias}
        parts += [onnx.numpy_helper.from_array(array, key) for key, array in arrays.items()]
        shape = {"strides": [layer.stride] * 2, "dilations": [layer.dilation] * 2, "pads": [layer.padding] * 4}
        nodes.append(onnx.helper.make_node("Conv", [name, *arrays], [f"sum{number}"], **shape))
        name = f"planes{number}"
        above = "Sigmoid" if layer is LAYERS[-1] else "Relu"
        nodes.append(onnx.helper.make_node(above, [f"sum{number}"], [name]))
    nodes.append(onnx.helper.make_node("DepthToSpace", [name], ["strength"], blocksize=CELL_PX))
    given, found = (
        onnx.helper.make_tensor_value_info(key, onnx.TensorProto.FLOAT, [1, planes, "rows", "columns"])
        for key, planes in (("picture", 3), ("strength", 1))
    )
    graph = onnx.helper.make_graph(nodes, "edges", [given], [found], parts)
    opset = onnx.helper.make_opsetid("", OPSET)
    onnx.save_model(onnx.helper.make_model(graph, opset_imports=[opset], ir_version=IR_VERSION), output)


if __name__ == "__main__":
    main()
