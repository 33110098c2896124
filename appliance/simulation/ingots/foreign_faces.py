"""Ends of ingots as other mills cast and handle them, drawn unlike those of our own line (`faces.py`).

Tops wrinkle in other patterns. Whatever else an end may show is drawn on both kinds alike, so that none of it tells
one from the other: a cooler middle that looks like a cap of scale, flakes, chips, scratches alone and in bundles, saw
marks, blotches, a chamfer.
"""

import math
from collections.abc import Callable

import cv2
import numpy as np

from appliance.simulation.ingots.faces import FACE_CELLS, Label, Rng, flanks, noise, smooth_step, wrinkles
from appliance.simulation.sensor import Light

SHARE_OF_FAINT_TOPS = 0.25
LEAST_RELIEF = np.float32(1e-3)
CAMERA_BLUR_CELLS = FACE_CELLS / 64  # chosen: 1 px where an end has a radius of 32 px
SHAPE = FACE_CELLS, FACE_CELLS
_across = np.linspace(-1, 1, FACE_CELLS, dtype=np.float32)
_x, _y = np.meshgrid(_across, _across)


def foreign_face(label: Label, rng: Rng) -> Light:
    """Relative light of an end of another mill.

    Parameters
    ----------
    label : {"top", "bottom"}
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float32, shape (FACE_CELLS, FACE_CELLS)
    """
    light = foreign_blemishes(rng)
    if label == "top":
        light = no_stronger(foreign_skin(rng), light)
    return np.maximum(light, np.float32(0.05))


def foreign_blemishes(rng: Rng) -> Light:
    """What an end of either kind may show, as factors of light, shape (FACE_CELLS, FACE_CELLS)."""
    light = np.ones(SHAPE, np.float32)
    light *= 1 + np.float32(rng.uniform(0.01, 0.06)) * noise(rng, SHAPE, FACE_CELLS / rng.uniform(2, 7))
    for blemish, share in _BLEMISHES:
        if rng.random() < share:
            light *= blemish(rng)
    return light


def no_stronger(skin: Light, blemishes: Light) -> Light:
    """Skin under blemishes whose relief is at most as strong as its own, else nobody could say that it is a top.

    Parameters
    ----------
    skin, blemishes : ndarray of float32, shape (FACE_CELLS, FACE_CELLS)
        Factors of light.

    Returns
    -------
    ndarray of float32, shape (FACE_CELLS, FACE_CELLS)
    """
    weaker = min(1.0, _relief(skin) / max(_relief(blemishes), LEAST_RELIEF))
    return (skin * np.maximum(blemishes, LEAST_RELIEF) ** np.float32(weaker)).astype(np.float32)


def _relief(light: Light) -> float:
    """Standard deviation of what a camera shows and what changes over less than a tenth of the face.

    In natural logarithms of light. Without the camera's blur, hairlines that no picture shows would count.
    """
    codes = np.log(np.maximum(light, LEAST_RELIEF))
    fine = np.asarray(cv2.GaussianBlur(codes, (0, 0), CAMERA_BLUR_CELLS), np.float32)
    fine = fine - np.asarray(cv2.GaussianBlur(codes, (0, 0), FACE_CELLS / 10), np.float32)
    return float(fine[np.hypot(_x, _y) < 0.8].std())


def foreign_skin(rng: Rng) -> Light:
    """Wrinkles inside a rim that is smooth, sometimes hardly there, and rarely as bright as the face.

    Factors of light, shape (FACE_CELLS, FACE_CELLS).
    """
    rim = rng.uniform(0.03, 0.28)
    off_x, off_y = rng.normal(0, 0.03, 2)
    ragged = np.float32(rng.uniform(0, 0.03)) * noise(rng, SHAPE, FACE_CELLS / 8)
    inner = smooth_step((1 - rim - np.hypot(_x - off_x, _y - off_y) + ragged) / np.float32(rng.uniform(0.04, 0.15)))
    number = math.exp(rng.uniform(math.log(3.5), math.log(12)))
    height = _folds(number, rng) if rng.random() < 0.6 else wrinkles(number, rng)
    faint = rng.random() < SHARE_OF_FAINT_TOPS
    contrast = rng.uniform(0.06, 0.14) if faint else rng.uniform(0.14, 0.5)
    light = 1 - np.float32(contrast) * (1 - height) * inner
    light *= 1 + np.float32(rng.uniform(0, 0.2)) * flanks(height, rng.uniform(0, 2 * np.pi)) * inner
    return (light * (1 - np.float32(rng.uniform(0, 0.2)) * inner)).astype(np.float32)


def _folds(number: float, rng: Rng) -> Light:
    """Height of skin folded along creases: ridged noise, borders of cells, or stripes bent by slow displacements."""
    kind = rng.integers(3)
    if kind == 0:
        rough = noise(rng, SHAPE, FACE_CELLS / number) + np.float32(0.3) * noise(rng, SHAPE, FACE_CELLS / number / 2)
        height = np.abs(rough) / np.float32(rng.uniform(0.5, 1.2))
    elif kind == 1:
        seeds = rng.uniform(-1.1, 1.1, (max(8, round(number * number / 2)), 2)).astype(np.float32)
        distance = np.hypot(_x[..., None] - seeds[:, 0], _y[..., None] - seeds[:, 1])
        near = np.partition(distance, 1, axis=-1)
        height = (near[..., 1] - near[..., 0]) * np.float32(number / rng.uniform(1.5, 3))
    else:
        turn = rng.uniform(0, np.pi)
        bend = np.float32(rng.uniform(0.1, 0.35)) * noise(rng, SHAPE, FACE_CELLS / rng.uniform(2, 4))
        phase = np.float32(np.pi * number) * (_x * np.cos(turn) + _y * np.sin(turn) + bend)
        height = np.abs(np.sin(phase)) ** np.float32(rng.uniform(0.4, 1.5))
    height = smooth_step(height.astype(np.float32))
    return np.asarray(cv2.GaussianBlur(height, (0, 0), rng.uniform(0.5, 2.0)), np.float32)


def _cool_middle(rng: Rng) -> Light:
    """A middle darker by 5 to 40 %, its edge soft or ragged like that of scale: by up to 15 %, 4 to 12 blobs across."""
    (x, y), size = rng.normal(0, 0.15, 2), rng.uniform(0.25, 0.85)
    ragged = np.float32(rng.uniform(0, 0.15)) * noise(rng, SHAPE, FACE_CELLS / rng.uniform(4, 12))
    distance = np.hypot(_x - np.float32(x), (_y - np.float32(y)) * np.float32(rng.uniform(0.8, 1.25)))
    soft = np.float32(rng.uniform(0.03, 0.6))
    cap = smooth_step(((np.float32(size) - distance + ragged) / soft + np.float32(0.5)).astype(np.float32))
    return 1 - np.float32(rng.uniform(0.05, 0.4)) * cap


def _flakes(rng: Rng) -> Light:
    """Flakes of scale with broken outlines, darker by 5 to 45 %, over 2 to 30 % of the end."""
    size = FACE_CELLS * rng.uniform(0.07, 0.3)
    rough = noise(rng, SHAPE, size) + np.float32(rng.uniform(0.1, 0.6)) * noise(rng, SHAPE, size / 3)
    edge = np.quantile(rough, 1 - rng.uniform(0.02, 0.3))
    soft = np.float32(rng.uniform(0.1, 0.5))
    flake = smooth_step(((rough - np.float32(edge)) / soft + np.float32(0.5)).astype(np.float32))
    return 1 - np.float32(rng.uniform(0.05, 0.45)) * flake


def _chips(rng: Rng) -> Light:
    """Single chips with straight edges, darker by up to 40 % or lighter by up to 12 %."""
    drawn = np.zeros(SHAPE, np.float32)
    for _ in range(int(rng.integers(1, 25))):
        turn = np.sort(rng.uniform(0, 2 * np.pi, int(rng.integers(3, 7))))
        reach = rng.uniform(0.01, 0.1) * rng.uniform(0.5, 1, len(turn))
        corners = rng.uniform(0.05, 0.95, 2) + np.stack([np.cos(turn), np.sin(turn)], axis=1) * reach[:, None]
        cv2.fillPoly(drawn, [np.rint(16 * FACE_CELLS * corners).astype(np.int32)], rng.uniform(-1, 0.3), shift=4)
    return 1 + np.float32(rng.uniform(0.1, 0.4)) * drawn


def _scratches(rng: Rng) -> Light:
    """Single scratches in all directions, two in three dark and the others light."""
    return _strokes(rng, int(rng.integers(1, 15)), lambda: rng.uniform(0, 2 * np.pi), rng.uniform(0.05, 0.3))


def _bundle(rng: Rng) -> Light:
    """Scratches side by side, as dragging leaves them."""
    turn = rng.uniform(0, 2 * np.pi)
    return _strokes(rng, int(rng.integers(4, 18)), lambda: turn + rng.normal(0, 0.06), rng.uniform(0.04, 0.2))


def _strokes(rng: Rng, number: int, turn: Callable[[], float], depth: float) -> Light:
    light = np.ones(SHAPE, np.float32)
    for _ in range(number):
        stroke, angle = np.zeros(SHAPE, np.float32), turn()
        along, middle = rng.uniform(0.05, 0.5) * np.array([np.cos(angle), np.sin(angle)]), rng.uniform(0.1, 0.9, 2)
        bent = middle + rng.normal(0, 0.02, 2)
        points = np.rint(16 * FACE_CELLS * np.array([middle - along, bent, middle + along])).astype(np.int32)
        cv2.polylines(stroke, [points], False, 1.0, int(rng.integers(1, 4)), cv2.LINE_AA, shift=4)
        stroke = cv2.GaussianBlur(stroke, (0, 0), rng.uniform(0.4, 1.2))
        light *= 1 + np.float32(rng.choice([-1, -1, 1]) * depth * rng.uniform(0.3, 1)) * stroke
    return light


def _saw_marks(rng: Rng) -> Light:
    """Shallow arcs of one centre far outside, as a saw leaves them, of 1 to 5 % of the light."""
    turn, away = rng.uniform(0, 2 * np.pi), rng.uniform(1.5, 8)
    distance = np.hypot(_x - np.float32(away * np.cos(turn)), _y - np.float32(away * np.sin(turn)))
    waves = np.sin(np.float32(2 * np.pi * rng.uniform(6, 25)) * distance + rng.uniform(0, 2 * np.pi))
    shown = smooth_step(noise(rng, SHAPE, FACE_CELLS / 2) * np.float32(0.5) + np.float32(0.5))
    return (1 + np.float32(rng.uniform(0.01, 0.05)) * waves * shown).astype(np.float32)


def _blotches(rng: Rng) -> Light:
    """Unevenness of any size, as of scale that grew and fell off, of 1 to 7 % of the light (standard deviation)."""
    return 1 + np.float32(rng.uniform(0.01, 0.07)) * noise(rng, SHAPE, FACE_CELLS * rng.uniform(0.04, 0.25))


def _chamfer(rng: Rng) -> Light:
    """A ring at the edge, darker by up to 20 % or brighter by up to 12 %."""
    ring = smooth_step((np.hypot(_x, _y) - np.float32(1 - rng.uniform(0.03, 0.2))) / np.float32(0.05))
    return 1 + np.float32(rng.uniform(-0.2, 0.12)) * ring


def _slope(rng: Rng) -> Light:
    """Light that falls off to one side, as where a lamp's glare lies on the end or one side cooled.

    By up to 20 % of the light from the middle to the edge, or behind a soft border by up to half.
    """
    turn = rng.uniform(0, 2 * np.pi)
    place = (_x * np.cos(turn) + _y * np.sin(turn)).astype(np.float32)
    if rng.random() < 0.5:
        return 1 + np.float32(rng.uniform(0, 0.2)) * place
    soft = np.float32(rng.uniform(0.05, 0.4))
    return 1 + np.float32(rng.uniform(0, 0.5)) * smooth_step((place - np.float32(rng.uniform(0.1, 0.9))) / soft)


# What either end may show, and how many ends do.
_BLEMISHES = (
    (_cool_middle, 0.4), (_flakes, 0.4), (_chips, 0.3), (_scratches, 0.5), (_bundle, 0.2), (_saw_marks, 0.15),
    (_blotches, 0.4), (_chamfer, 0.4), (_slope, 0.5),
)  # fmt: skip
