"""What the network of the classifier `relief` is shown while it is trained: ends of lines beside references."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.training.rendered_ends import Picture, RenderedLine
from vision.ingot.classifiers.relief import relief
from vision.ingot.classifiers.similarity import SIZE

Array = NDArray[np.float32]
Indices = NDArray[np.int64]
Rng = np.random.Generator

LINES_A_BATCH, ENDS_A_LINE = 10, 7
SHARE_OF_WRONG_REFERENCES = 0.1  # chosen, of the ends: compared with another line's, so that poor ones do little harm
SHARE_OF_LAYERED_ENDS = 0.35  # chosen, of the ends: bear what a bottom of another line of the batch bears, too
LEAST_SPREAD = np.float32(1e-3)  # of relief, where an end is clipped all over

_across = (np.arange(SIZE) - (SIZE - 1) / 2) / (SIZE / 2)
_middle = np.hypot(_across[:, None], _across) < 0.8


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


def without_flat_tops(line: RenderedLine, least_shown: float) -> RenderedLine:
    """The line without the tops that show no more relief than a flat bottom.

    Parameters
    ----------
    line : RenderedLine
    least_shown : float
        Standard deviation of a top's relief; tops that show less are left out.
    """
    kept = np.array(
        [not top or _shown(relief(end)) >= least_shown for end, top in zip(line.ends, line.tops, strict=True)]
    )
    return line._replace(ends=line.ends[kept], tops=line.tops[kept])


def _shown(planes: Array) -> float:
    """Standard deviation of an end's relief, less what its noise adds."""
    inside = (planes[..., 2] > 0) & _middle
    smooth = np.asarray(cv2.GaussianBlur(planes[..., 0], (0, 0), 1.0), np.float32)
    return float(smooth[inside].std()) if inside.any() else 0.0


def batch_of(lines: list[RenderedLine], rng: Rng) -> Batch:
    """Some ends of some lines and these lines' references, mirrored or not, turned over or not, each for itself.

    Parameters
    ----------
    lines : list of RenderedLine
    rng : numpy.random.Generator
    """
    numbers: list[int] = rng.integers(len(lines), size=LINES_A_BATCH).tolist()
    chosen = [lines[number] for number in numbers]
    picked = [rng.integers(len(line.ends), size=ENDS_A_LINE) for line in chosen]
    count = LINES_A_BATCH * ENDS_A_LINE
    tops = np.concatenate([line.tops[which] for line, which in zip(chosen, picked, strict=True)])
    ends = _reliefs([line.ends[which] for line, which in zip(chosen, picked, strict=True)])
    references = _reliefs([line.references for line in chosen])
    planes = np.concatenate([layered(_turned(ends, rng), tops, rng), _turned(references, rng)])
    of = np.repeat(np.arange(LINES_A_BATCH), ENDS_A_LINE)
    strange = rng.random(count) < SHARE_OF_WRONG_REFERENCES
    of = np.where(strange, rng.integers(LINES_A_BATCH, size=count), of)
    return Batch(planes, count + 2 * of, count + 2 * of + 1, tops.astype(np.float32))


def _reliefs(pictures: list[Picture]) -> Array:
    """What the network is given of pictures, one after the other."""
    return np.stack([relief(image) for image in np.concatenate(pictures)])


def _turned(planes: Array, rng: Rng) -> Array:
    """Each end mirrored or not, and turned over or not."""
    for axis in (1, 2):
        chosen = rng.random(len(planes)) < 0.5
        planes[chosen] = np.flip(planes[chosen], axis)
    return planes


def layered(ends: Array, tops: NDArray[np.bool_], rng: Rng) -> Array:
    """Ends of which some bear what one of the bottoms bears, too, on a top no stronger than what it shows itself.

    Factors of light are sums of logarithms, which the planes are.

    Parameters
    ----------
    ends : ndarray of float32, shape (n, 64, 64, 3)
        As `relief` gives them.
    tops : ndarray of bool, shape (n,)
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float32, shape (n, 64, 64, 3)
    """
    bottoms = np.flatnonzero(~tops)
    if not len(bottoms):
        return ends
    chosen = np.flatnonzero(rng.random(len(ends)) < SHARE_OF_LAYERED_ENDS)
    others = rng.choice(bottoms, len(chosen))
    spread = np.maximum(ends[..., 0].std(axis=(1, 2)), LEAST_SPREAD)
    weaker = np.where(tops[chosen], np.minimum(1, spread[chosen] / spread[others]), 1)
    weaker = (weaker * rng.uniform(0.3, 1, len(chosen))).astype(np.float32)[:, None, None, None]
    both = ends.copy()
    both[chosen, ..., :2] += weaker * ends[others, ..., :2]
    both[chosen, ..., 2] *= ends[others, ..., 2]
    both[chosen, ..., :2] *= both[chosen, ..., 2:]
    return both
