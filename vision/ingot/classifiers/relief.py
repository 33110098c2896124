"""Relief of an ingot's end, judged by a small convolutional network that has seen rendered faces alone.

The network is given what is left of the logarithm of grey values once slow changes of light are taken out, and a mask
from which glare and clipped pixels are left out: it sees wrinkles, flakes and scratches, and neither brightness nor
exposure. Training drew every blemish on tops and bottoms alike (`python -m appliance.training.ingot_relief`), so
that nothing but wrinkled skin tells one from the other.
"""

from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.ingot.classifiers.classifier import Face, FaceClassifier, Picture, Verdict
from vision.ingot.classifiers.similarity import SIZE

Plane = NDArray[np.float32]
Layers = list[tuple[Plane, Plane]]

MODEL = Path(__file__).parent / "model" / "relief.npz"
DARK_CODE = 4.0  # chosen: added to grey values before their logarithm, which is -infinity at 0
CLIPPED_CODE = 250  # from here a pixel says nothing of relief: glare, or overexposed
FACE_RADIUS = 0.95  # chosen, of the end's radius: outside lies the line
SLOW_PX = 6.0  # standard deviation of the Gaussian beyond whose width changes of light are slow
LEAST_COVER = 0.02  # chosen: least weight of a mean of light around a pixel
SCALE = 8.0  # brings the relief's logarithms near 1
STRIDE = 2
CONVOLUTIONS = 3

_across = (np.arange(SIZE) - (SIZE - 1) / 2) / (SIZE / 2)
_disc = (np.hypot(_across[:, None], _across) < FACE_RADIUS).astype(np.float32)


def relief(image: Picture) -> Plane:
    """What the network is given.

    Parameters
    ----------
    image : ndarray of uint8, shape (64, 64)
        As `end_image` gives it.

    Returns
    -------
    ndarray of float32, shape (64, 64, 2)
        Relief, and the mask of pixels that show any.
    """
    light = np.log(image.astype(np.float32) + np.float32(DARK_CODE))
    mask = _disc * (image < CLIPPED_CODE)
    cover = np.maximum(cv2.GaussianBlur(mask, (0, 0), SLOW_PX), np.float32(LEAST_COVER))
    slow = cv2.GaussianBlur(light * mask, (0, 0), SLOW_PX) / cover
    return np.stack([np.float32(SCALE) * (light - slow) * mask, mask], axis=-1).astype(np.float32)


@cache
def _layers() -> Layers:
    with np.load(MODEL) as model:
        return [(model[f"W{number}"], model[f"b{number}"]) for number in range(CONVOLUTIONS + 2)]


def log_odds_of(image: Picture) -> float:
    """Natural logarithm of the odds of a top against a bottom."""
    (*convolutions, hidden, last), values = _layers(), relief(image)
    for weights, bias in convolutions:
        values = _convolved(values, weights, bias)
    pooled = np.concatenate([values.mean(axis=(0, 1)), values.max(axis=(0, 1))])
    return float((np.maximum(pooled @ hidden[0] + hidden[1], 0) @ last[0] + last[1])[0])


def _convolved(values: Plane, weights: Plane, bias: Plane) -> Plane:
    """Convolution at every second place in both directions, what of it is above 0."""
    side, size = len(weights), len(values)
    padding = max((-(-size // STRIDE) - 1) * STRIDE + side - size, 0)
    before = padding // 2
    values = np.pad(values, ((before, padding - before), (before, padding - before), (0, 0)))
    around = np.lib.stride_tricks.sliding_window_view(values, (side, side), axis=(0, 1))[::STRIDE, ::STRIDE]
    kernels = np.ascontiguousarray(weights.transpose(2, 0, 1, 3)).reshape(-1, weights.shape[-1])
    rows, columns = around.shape[:2]
    flat = around.reshape(rows * columns, -1) @ kernels + bias
    return np.maximum(flat, 0).reshape(rows, columns, -1)


class ReliefOdds(FaceClassifier):
    """Odds that an end is a top, from its relief alone.

    Parameters
    ----------
    top, bottom : ndarray of uint8, shape (64, 64)
        References, which the network does without.
    """

    def __init__(self, top: Picture, bottom: Picture) -> None:
        """Nothing of the references is needed; the network is loaded with the first face."""

    def judge(self, face: Face) -> Verdict:
        """Top where the odds are in its favour."""
        log_odds = log_odds_of(face.image)
        return Verdict("top" if log_odds > 0 else "bottom", log_odds)
