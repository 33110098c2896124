"""Relief of an ingot's end beside that of its line's references, judged by a small convolutional network.

The network is given what is left of the logarithm of grey values once slow changes of light are taken out, the same
less its mean alone, and a mask from which glare and clipped pixels are left out. It sees wrinkles, flakes, scratches
and rims, and no exposure. What it finds in an end is compared with what it finds in both references. It has been
trained on rendered lines alone, with every blemish on tops and bottoms alike (`appliance/training/ingot_relief.py`),
so that nothing but wrinkled skin tells one from the other.
"""

from functools import cache, lru_cache
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
GLARE_PX = 3  # chosen: rows and columns around a clipped pixel that its glare has brightened
RELIEF_SCALE, LEVEL_SCALE = 8.0, 3.0  # bring both logarithms near 1
PLANES = 3
STRIDE = 2
CONVOLUTIONS = 4
KEPT_ENDS = 64  # chosen: ends whose findings are kept, 2 kB each

_across = (np.arange(SIZE) - (SIZE - 1) / 2) / (SIZE / 2)
_disc = (np.hypot(_across[:, None], _across) < FACE_RADIUS).astype(np.float32)
_glare = np.ones((GLARE_PX, GLARE_PX), np.uint8)


def relief(image: Picture) -> Plane:
    """What the network is given.

    Parameters
    ----------
    image : ndarray of uint8, shape (64, 64)
        As `end_image` gives it.

    Returns
    -------
    ndarray of float32, shape (64, 64, 3)
        Relief, level over the end's mean, and the mask of pixels that show any.
    """
    light = np.log(image.astype(np.float32) + np.float32(DARK_CODE))
    clipped = cv2.dilate((image >= CLIPPED_CODE).astype(np.uint8), _glare)
    mask = _disc * (1 - clipped)
    cover = np.maximum(cv2.GaussianBlur(mask, (0, 0), SLOW_PX), np.float32(LEAST_COVER))
    slow = cv2.GaussianBlur(light * mask, (0, 0), SLOW_PX) / cover
    mean = (light * mask).sum() / max(float(mask.sum()), 1.0)
    planes = [np.float32(RELIEF_SCALE) * (light - slow) * mask, np.float32(LEVEL_SCALE) * (light - mean) * mask, mask]
    return np.stack(planes, axis=-1).astype(np.float32)


@cache
def _layers() -> Layers:
    with np.load(MODEL) as model:
        return [(model[f"W{number}"], model[f"b{number}"]) for number in range(CONVOLUTIONS + 2)]


def found(image: Picture, layers: Layers) -> Plane:
    """What the convolutions find in an end and in its mirror images: mean and maximum of each of their last planes.

    Parameters
    ----------
    image : ndarray of uint8, shape (64, 64)
    layers : list of (weights, bias)

    Returns
    -------
    ndarray of float32, shape (4, n)
        As it is, upside down, left for right, and both.
    """
    seen = relief(image)
    values = np.stack([seen, seen[::-1], seen[:, ::-1], seen[::-1, ::-1]])
    for weights, bias in layers[:CONVOLUTIONS]:
        values = _convolved(values, weights, bias)
    return np.concatenate([values.mean(axis=(1, 2)), values.max(axis=(1, 2))], axis=1)


@lru_cache(KEPT_ENDS)
def _found_again(codes: bytes) -> Plane:
    """What the shipped network finds; references that learn judge the same ends again and again."""
    return found(np.frombuffer(codes, np.uint8).reshape(SIZE, SIZE), _layers())


def _convolved(values: Plane, weights: Plane, bias: Plane) -> Plane:
    """Convolution of some pictures at every second place in both directions, what of it is above 0."""
    side, size = len(weights), values.shape[1]
    padding = max((-(-size // STRIDE) - 1) * STRIDE + side - size, 0)
    around = (padding // 2, padding - padding // 2)
    values = np.pad(values, ((0, 0), around, around, (0, 0)))
    lines = values.reshape(*values.shape[:2], -1)  # so that a kernel's row is one run of numbers
    channels = values.shape[3]
    kernels = np.lib.stride_tricks.sliding_window_view(lines, (side, side * channels), axis=(1, 2))
    kernels = kernels[:, ::STRIDE, :: STRIDE * channels]
    flat = kernels.reshape(np.prod(kernels.shape[:3]), -1) @ weights.reshape(-1, weights.shape[-1]) + bias
    return np.maximum(flat, 0).reshape(*kernels.shape[:3], -1)


class ReliefOdds(FaceClassifier):
    """Odds that an end is a top, from its relief and that of two references.

    Parameters
    ----------
    top, bottom : ndarray of uint8, shape (64, 64)
        References.
    layers : list of (weights, bias), optional
        Of the network; the one that is shipped by default.
    """

    def __init__(self, top: Picture, bottom: Picture, layers: Layers | None = None) -> None:
        self._network = layers if layers is not None else _layers()
        self._top, self._bottom = (found(reference, self._network).mean(axis=0) for reference in (top, bottom))

    def log_odds(self, image: Picture) -> float:
        """Natural logarithm of the odds of a top against a bottom, mean over the end's mirror images."""
        hidden, last = self._network[CONVOLUTIONS:]
        end = _found_again(image.tobytes()) if self._network is _layers() else found(image, self._network)
        compared = np.concatenate([end, end - self._top, end - self._bottom], axis=1)
        return float(np.mean(np.maximum(compared @ hidden[0] + hidden[1], 0) @ last[0] + last[1]))

    def judge(self, face: Face) -> Verdict:
        """Top where the odds are in its favour."""
        log_odds = self.log_odds(face.image)
        return Verdict("top" if log_odds > 0 else "bottom", log_odds)
