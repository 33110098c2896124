"""Blemishes of ingots' ends with soft outlines, beyond those that the simulated mills draw: `rendered_ends` adds them.

Each is a factor of light on a map of FACE_CELLS x FACE_CELLS. They come alone and together, in one place and all over:
a bottom that lay in the mould is cooler in the middle, mottled there, scraped and flaked, and is still a bottom.
"""

import math
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.ingots.faces import FACE_CELLS, Rng, noise, smooth_step

Plane = NDArray[np.float32]

SHAPE = FACE_CELLS, FACE_CELLS
LONGEST_WAVE, SHORTEST_WAVE = 0.7, 0.02  # of mottling, over the diameter
_across = np.linspace(-1, 1, FACE_CELLS, dtype=np.float32)
_x, _y = np.meshgrid(_across, _across)
_rate = np.hypot(np.fft.fftfreq(FACE_CELLS)[:, None], np.fft.rfftfreq(FACE_CELLS)[None, :]) * FACE_CELLS


def soft_blemishes(rng: Rng) -> Plane:
    """Some of the blemishes, none or all, as factors of light.

    Parameters
    ----------
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float32, shape (FACE_CELLS, FACE_CELLS)
        Between 0.1 and 1.2.
    """
    light = np.ones(SHAPE, np.float32)
    often = rng.choice([0.0, 0.5, 1.0, 1.5])  # ends without, with some and with many
    for blemish, share in BLEMISHES:
        if rng.random() < often * share:
            light = light * blemish(rng)
    return np.maximum(light, np.float32(0.1))


def _patches(rng: Rng) -> Plane:
    """Soft dark patches, all in one direction."""
    along, across = (math.exp(rng.uniform(math.log(2), math.log(14))) for _ in range(2))
    rough = rng.standard_normal(SHAPE, dtype=np.float32)
    rough = np.asarray(cv2.GaussianBlur(rough, (0, 0), along, sigmaY=across), np.float32)
    turn = cv2.getRotationMatrix2D((FACE_CELLS / 2, FACE_CELLS / 2), rng.uniform(0, 180), 1)
    rough = np.asarray(cv2.warpAffine(rough, turn, SHAPE, borderMode=cv2.BORDER_REFLECT), np.float32)
    rough = rough / rough.std()
    patch = 1 / (1 + np.exp(-(rough - np.float32(rng.uniform(0.5, 2.2))) / np.float32(rng.uniform(0.1, 0.6))))
    return 1 - np.float32(rng.uniform(0.05, 0.4)) * patch


def _streaks(rng: Rng) -> Plane:
    """Dark streaks with soft ends, near one another or all over, in one direction or in all, straight or bent."""
    light = np.ones(SHAPE, np.float32)
    direction, spread = rng.uniform(0, np.pi), rng.choice([0.08, 0.3, 3.0])
    (middle_x, middle_y), reach = rng.uniform(-0.4, 0.4, 2), rng.uniform(0.25, 0.9)
    longest, deepest = math.exp(rng.uniform(math.log(1.5), math.log(14))), rng.uniform(0.06, 0.45)
    for _ in range(int(rng.integers(1, 22))):
        x, y = middle_x + reach * rng.uniform(-1, 1), middle_y + reach * rng.uniform(-1, 1)
        turned, width, longer = direction + spread * rng.normal(), rng.uniform(0.012, 0.07), rng.uniform(1, longest)
        u = ((_x - x) * np.cos(turned) + (_y - y) * np.sin(turned)) / (width * longer)
        v = (-(_x - x) * np.sin(turned) + (_y - y) * np.cos(turned)) / width + rng.normal(0, 0.3) * u**2
        light *= 1 - deepest * rng.uniform(0.3, 1) * np.exp(-(u**2 + v**2) / 2)
    return light


def _spots(rng: Rng) -> Plane:
    """A group of dark flakes of crooked outline."""
    depth = np.zeros(SHAPE, np.float32)
    crooked = np.float32(rng.uniform(0.0, 0.04))
    x, y = (axis + crooked * noise(rng, SHAPE, FACE_CELLS / 16) for axis in (_x, _y))
    (middle_x, middle_y), reach = rng.uniform(-0.5, 0.5, 2), rng.uniform(0.1, 0.9)
    deepest, largest = rng.uniform(0.08, 0.5), rng.uniform(0.03, 0.14)
    for _ in range(int(rng.integers(1, 25))):
        place_x, place_y = middle_x + reach * rng.normal(0, 0.5), middle_y + reach * rng.normal(0, 0.5)
        wide, high = largest * rng.uniform(0.2, 1, 2)
        distance = np.hypot((x - np.float32(place_x)) / wide, (y - np.float32(place_y)) / high)
        flake = 1 / (1 + np.exp(np.minimum((distance - 1) / rng.uniform(0.08, 0.5), 50)))
        depth = np.maximum(depth, (deepest * rng.uniform(0.3, 1) * flake).astype(np.float32))
    return 1 - depth


def _mottling(rng: Rng) -> Plane:
    """Unevenness of many sizes at once."""
    return np.exp(np.float32(rng.uniform(0.01, 0.1)) * _clouds(rng)).astype(np.float32)


def _clouds(rng: Rng) -> Plane:
    """Noise whose amplitude falls with a power of its spatial frequency, standard deviation 1."""
    spectrum = np.fft.rfft2(rng.standard_normal(SHAPE)) / np.maximum(_rate, 1) ** rng.uniform(0.5, 2.2)
    spectrum[(_rate < 1 / LONGEST_WAVE) | (_rate > 1 / SHORTEST_WAVE)] = 0
    clouds = np.fft.irfft2(spectrum, SHAPE)
    return (clouds / clouds.std()).astype(np.float32)


def _cool_middle(rng: Rng) -> Plane:
    """A cooler middle, its border soft, crooked and perhaps steep, mottled or not."""
    (x, y), size, turn = rng.normal(0, 0.18, 2), rng.uniform(0.3, 0.85), rng.uniform(0, np.pi)
    crooked = np.float32(rng.uniform(0.0, 0.15)) * noise(rng, SHAPE, FACE_CELLS / rng.uniform(2, 9))
    u = (_x - x) * math.cos(turn) + (_y - y) * math.sin(turn)
    v = ((_y - y) * math.cos(turn) - (_x - x) * math.sin(turn)) * rng.uniform(0.75, 1.3)
    soft = np.float32(rng.uniform(0.08, 0.9))
    cap = smooth_step(((np.float32(size) - np.hypot(u, v) + crooked) / soft + np.float32(0.5)).astype(np.float32))
    depth = np.float32(rng.uniform(0.04, 0.4))
    if rng.random() < 0.5:
        depth = depth * (1 + np.float32(rng.uniform(0.05, 0.4)) * _clouds(rng))
    return np.exp(-depth * cap).astype(np.float32)


# What either end may show, and how many ends do.
BLEMISHES: tuple[tuple[Callable[[Rng], Plane], float], ...] = (
    (_cool_middle, 0.5), (_patches, 0.35), (_streaks, 0.45), (_spots, 0.4), (_mottling, 0.4),
)  # fmt: skip
