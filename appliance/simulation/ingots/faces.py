"""What is on an ingot's surface: wrinkles of a top, mottling and flakes of a bottom, scale of the side.

A face is a square map of relative light around 1, the disc inscribed in it; rows run down, columns right.
"""

import math
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.sensor import Light

Label = Literal["top", "bottom"]
Rng = np.random.Generator

LABELS: tuple[Label, Label] = ("top", "bottom")
FACE_CELLS = 160
SIDE_CELLS = (64, 192)  # along, around
SHARE_OF_FAINT_TOPS = 0.2
SHARE_OF_SCALED_BOTTOMS = 0.25
# Feed and kill rates of Gray and Scott's reaction at which stripes, mazes and corals grow.
REACTIONS = ((0.037, 0.060), (0.055, 0.062), (0.046, 0.060))
REACTION_STEPS = 1800
CELLS_PER_WRINKLE = 11  # of the reaction's grid
NEIGHBOURS = np.array([[0.0, 1.0, 0.0], [1.0, -4.0, 1.0], [0.0, 1.0, 0.0]], np.float32)


@dataclass(frozen=True, slots=True)
class Looks:
    """How strongly a face shows what it has; everything is a part of the face's light.

    Attributes
    ----------
    wrinkles : float
        Number of wrinkles across the diameter.
    contrast : float
        How much darker the bottom of a wrinkle is.
    relief : float
        Light and dark flanks of the wrinkles, lit by the hall's lamps.
    rim : float
        Width of the smooth rim over the radius.
    recess : float
        How much darker the face is inside its rim.
    mottling : float
        Standard deviation of slow unevenness.
    flakes : float
        Part of the face that flakes of scale cover.
    flake_depth : float
        How much darker a flake is.
    flake_size : float
        Over the diameter.
    scratches : int
    """

    wrinkles: float = 0.0
    contrast: float = 0.0
    relief: float = 0.0
    rim: float = 0.1
    recess: float = 0.0
    mottling: float = 0.03
    flakes: float = 0.02
    flake_depth: float = 0.2
    flake_size: float = 0.06
    scratches: int = 0


TYPICAL: dict[Label, Looks] = {
    "top": Looks(wrinkles=6.0, contrast=0.3, relief=0.12, rim=0.18, recess=0.12),
    "bottom": Looks(recess=0.03, scratches=2),
}


def random_looks(label: Label, rng: Rng, scaled_bottoms: float = SHARE_OF_SCALED_BOTTOMS) -> Looks:
    """What faces of one kind differ in; a part of both kinds is hard to tell from the other.

    Tops have 3 to 11 wrinkles across, of a contrast of 15 to 45 %, of faint ones 7 to 15 %, a relief of up to 20 %, a
    rim of 5 to 28 % of the radius and a recess of up to 25 %. Bottoms have a rim of 3 to 25 % and a recess of -3 to
    6 %, those with scale of up to 15 %; flakes of 20 to 45 % then cover 8 to 40 %, else those of 5 to 25 % up to 5
    (tops: 6) %. Mottling is 1 to 6 %; there are up to 1 scratch on tops and 5 on bottoms.

    Parameters
    ----------
    label : {"top", "bottom"}
    rng : numpy.random.Generator
    scaled_bottoms : float
        Share of the bottoms with scale.
    """
    if label == "top":
        faint = rng.random() < SHARE_OF_FAINT_TOPS
        return Looks(
            wrinkles=math.exp(rng.uniform(math.log(3), math.log(11))),
            contrast=rng.uniform(0.07, 0.15) if faint else rng.uniform(0.15, 0.45),
            relief=rng.uniform(0.0, 0.2),
            rim=rng.uniform(0.05, 0.28),
            recess=rng.uniform(0.0, 0.25),
            mottling=rng.uniform(0.01, 0.06),
            flakes=rng.uniform(0.0, 0.06),
            flake_depth=rng.uniform(0.05, 0.25),
            scratches=int(rng.integers(0, 2)),
        )
    scaled = rng.random() < scaled_bottoms
    return Looks(
        rim=rng.uniform(0.03, 0.25),
        recess=rng.uniform(0.0, 0.15) if scaled else rng.uniform(-0.03, 0.06),
        mottling=rng.uniform(0.01, 0.06),
        flakes=rng.uniform(0.08, 0.4) if scaled else rng.uniform(0.0, 0.05),
        flake_depth=rng.uniform(0.2, 0.45) if scaled else rng.uniform(0.05, 0.25),
        flake_size=rng.uniform(0.08, 0.25) if scaled else rng.uniform(0.03, 0.09),
        scratches=int(rng.integers(0, 6)),
    )


def face(looks: Looks, rng: Rng) -> Light:
    """Relative light of an end face, ndarray of float32, shape (FACE_CELLS, FACE_CELLS)."""
    across = np.linspace(-1, 1, FACE_CELLS, dtype=np.float32)
    radius = np.hypot(across[:, None], across[None, :])
    inner = smooth_step((1 - np.float32(looks.rim) - radius) / np.float32(0.06))
    light = 1 - np.float32(looks.recess) * inner
    light *= 1 + np.float32(looks.mottling) * noise(rng, (FACE_CELLS, FACE_CELLS), FACE_CELLS / 5)
    if looks.wrinkles:
        height = wrinkles(looks.wrinkles, rng)
        light *= 1 - np.float32(looks.contrast) * (1 - height) * inner
        light *= 1 + np.float32(looks.relief) * flanks(height, rng.uniform(0, 2 * np.pi)) * inner
    flaking = noise(rng, (FACE_CELLS, FACE_CELLS), FACE_CELLS * looks.flake_size)
    flaking += np.float32(0.4) * noise(rng, (FACE_CELLS, FACE_CELLS), FACE_CELLS * looks.flake_size / 3)
    flake = smooth_step((flaking - np.quantile(flaking, 1 - looks.flakes)) / np.float32(0.3) + np.float32(0.5))
    light *= 1 - np.float32(looks.flake_depth) * flake
    _scratch(light, looks.scratches, rng)
    light *= 1 + np.float32(rng.uniform(0, 0.08)) * _slope(across, rng)
    return np.maximum(light, np.float32(0.05))


def side(rng: Rng) -> Light:
    """Relative light of the side, ndarray of float32, shape SIDE_CELLS: away from the end, around the axis."""
    along, _ = SIDE_CELLS
    rings = noise(rng, (along, 1), along * rng.uniform(0.05, 0.2))
    patches = noise(rng, SIDE_CELLS, along * rng.uniform(0.06, 0.2))
    scale = smooth_step((patches - np.float32(rng.uniform(0.5, 2.5))) / np.float32(0.3))
    light = 1 + np.float32(rng.uniform(0.0, 0.06)) * rings + np.float32(rng.uniform(0.01, 0.06)) * patches
    light *= 1 - np.float32(rng.uniform(0.05, 0.25)) * scale
    light *= 1 - np.linspace(0, rng.uniform(0, 0.25), along, dtype=np.float32)[:, None]
    return np.maximum(light, np.float32(0.05)).astype(np.float32)


def noise(rng: Rng, shape: tuple[int, int], cells: float) -> Light:
    """Smooth noise of mean 0 and standard deviation 1 whose blobs are about `cells` wide."""
    rough = rng.standard_normal(shape, dtype=np.float32)
    smooth = cv2.GaussianBlur(rough, (0, 0), max(0.3, cells / 3), borderType=cv2.BORDER_REFLECT)
    smooth = smooth.reshape(shape) - smooth.mean()
    return (smooth / max(1e-6, float(smooth.std()))).astype(np.float32)


def wrinkles(number: float, rng: Rng) -> Light:
    """Height of wrinkled skin, 0 in the valleys and 1 on the ridges, its pattern bent by slow displacements."""
    pattern = _reaction(number, rng) if rng.random() < 0.5 else _labyrinth(number, rng)
    cells = np.arange(FACE_CELLS, dtype=np.float32)
    bend = np.float32(0.3 * FACE_CELLS / number)
    x, y = (bend * noise(rng, (FACE_CELLS, FACE_CELLS), FACE_CELLS / 3) for _ in range(2))
    bent = cv2.remap(pattern, x + cells, y + cells[:, None], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return np.asarray(bent, np.float32)


def _reaction(number: float, rng: Rng) -> Light:
    """Stripes and mazes that Gray and Scott's two substances grow, scaled to 0 to 1.

    Pearson, doi:10.1126/science.261.5118.189.
    """
    size = max(24, round(CELLS_PER_WRINKLE * number))
    feed, kill = REACTIONS[rng.integers(len(REACTIONS))]
    seeds = (cv2.GaussianBlur(rng.random((size, size), dtype=np.float32), (0, 0), 1.5) > 0.5).astype(np.float32)
    u, v = 1 - 0.5 * seeds, 0.25 * seeds
    for _ in range(REACTION_STEPS):
        eaten = u * v * v
        u += 0.16 * cv2.filter2D(u, -1, NEIGHBOURS, borderType=cv2.BORDER_REFLECT) - eaten + feed * (1 - u)
        v += 0.08 * cv2.filter2D(v, -1, NEIGHBOURS, borderType=cv2.BORDER_REFLECT) + eaten - (feed + kill) * v
    low, high = np.quantile(v, (0.02, 0.98))
    scaled = np.clip((v - low) / max(1e-6, high - low), 0, 1).astype(np.float32)
    return np.asarray(cv2.resize(scaled, (FACE_CELLS, FACE_CELLS), interpolation=cv2.INTER_CUBIC), np.float32)


def _labyrinth(number: float, rng: Rng) -> Light:
    """Noise of one wave length, its slopes made steep by 0.8 to 2.5, scaled to 0 to 1.

    The amplitude of waves falls to 1/e 15 to 40 % of their number beside it.
    """
    spectrum = np.fft.rfft2(rng.standard_normal((FACE_CELLS, FACE_CELLS)))
    rate = np.hypot(np.fft.fftfreq(FACE_CELLS)[:, None], np.fft.rfftfreq(FACE_CELLS)[None, :]) * FACE_CELLS
    spectrum *= np.exp(-(((rate - number) / (rng.uniform(0.15, 0.4) * number)) ** 2))
    waves = np.fft.irfft2(spectrum, (FACE_CELLS, FACE_CELLS))
    return (0.5 + 0.5 * np.tanh(rng.uniform(0.8, 2.5) * waves / waves.std())).astype(np.float32)


def flanks(height: Light, lamp: float) -> Light:
    """Slope of the height towards a lamp, about -1 to 1."""
    slope = np.cos(lamp) * cv2.Sobel(height, cv2.CV_32F, 1, 0) + np.sin(lamp) * cv2.Sobel(height, cv2.CV_32F, 0, 1)
    return np.clip(slope / max(1e-6, float(2 * slope.std())), -1, 1).astype(np.float32)


def _scratch(light: Light, number: int, rng: Rng) -> None:
    for _ in range(number):
        start, turn, length = rng.uniform(0.1, 0.9, 2), rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 0.6)
        end = start + length * np.array([np.cos(turn), np.sin(turn)])
        stroke = np.zeros_like(light)
        (x0, y0), (x1, y1) = np.rint(np.stack([start, end]) * FACE_CELLS * 16).astype(int).tolist()
        cv2.line(stroke, (x0, y0), (x1, y1), 1.0, int(rng.integers(1, 4)), cv2.LINE_AA, shift=4)
        light *= 1 + np.float32(rng.choice([-1, 1]) * rng.uniform(0.03, 0.2)) * stroke


def _slope(across: NDArray[np.float32], rng: Rng) -> Light:
    """Uneven cooling: a slope over the face."""
    turn = rng.uniform(0, 2 * np.pi)
    return (np.cos(turn) * across[None, :] + np.sin(turn) * across[:, None]).astype(np.float32)


def smooth_step(place: Light) -> Light:
    """0 below 0, 1 above 1, without a kink between."""
    place = np.clip(place, 0, 1)
    return (place * place * (3 - 2 * place)).astype(np.float32)
