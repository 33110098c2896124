"""Ends of ingots as their geometry shows them: a height, and the light that glows from it and falls on it.

No network is trained on these faces; they judge one that was trained on the others (`faces.py`,
`foreign_faces.py`). A top is a dish inside a rim with skin that flowed and folded; a bottom is flat, was cooled by the
mould in the middle, and bears what the mould, tongs and chains left. Blemishes come on both.
"""

import math

import cv2
import numpy as np

from appliance.simulation.ingots.faces import FACE_CELLS, Label, Rng, noise, smooth_step
from appliance.simulation.sensor import Light

SHAPE = FACE_CELLS, FACE_CELLS
FLOW_STEPS = 24
_across = np.linspace(-1, 1, FACE_CELLS, dtype=np.float32)
_x, _y = np.meshgrid(_across, _across)
_radius = np.hypot(_x, _y)
_cells_x, _cells_y = np.meshgrid(np.arange(FACE_CELLS, dtype=np.float32), np.arange(FACE_CELLS, dtype=np.float32))


def cast_face(label: Label, rng: Rng) -> Light:
    """Relative light of an end whose height is shaded.

    Parameters
    ----------
    label : {"top", "bottom"}
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float32, shape (FACE_CELLS, FACE_CELLS)
    """
    height = np.float32(0.01) * noise(rng, SHAPE, FACE_CELLS / 6)
    cooling = np.float32(rng.uniform(0.01, 0.05)) * noise(rng, SHAPE, FACE_CELLS / rng.uniform(2, 5))
    if label == "top":
        folds, cooler = _dish(rng)
        height, cooling, marks = height + folds, cooling + cooler, 0.4
    else:
        cooling, marks = cooling + _mould(rng), 1.0
    height = height + np.float32(marks) * (_scratches(rng) + _dents(rng))
    plates, cooler = _plates(rng)
    height, cooling = height + np.float32(marks) * plates, cooling + np.float32(marks) * cooler
    return _shaded(height.astype(np.float32), cooling.astype(np.float32), rng)


def _shaded(height: Light, cooling: Light, rng: Rng) -> Light:
    """Light of a surface: less where it is cooler, other in its hollows, and lit by a lamp from one side."""
    height = np.asarray(cv2.GaussianBlur(height, (0, 0), rng.uniform(0.6, 1.4)), np.float32)
    hollow = np.asarray(cv2.GaussianBlur(height, (0, 0), FACE_CELLS / 14), np.float32) - height
    lamp, tall = rng.uniform(0, 2 * np.pi), np.float32(rng.uniform(0.0, 0.25))
    slope = math.cos(lamp) * cv2.Sobel(height, cv2.CV_32F, 1, 0) + math.sin(lamp) * cv2.Sobel(height, cv2.CV_32F, 0, 1)
    scale = np.float32(rng.uniform(2.0, 4.0))
    return np.exp(-cooling - scale * hollow + tall * np.clip(4 * slope, -1, 1)).astype(np.float32)


def _dish(rng: Rng) -> tuple[Light, Light]:
    """Height and cooling of the skin: lower inside the rim, folded as it flowed."""
    inner = _inside(rng)
    folds = _flow(rng) if rng.random() < 0.5 else _rings(rng)
    height = np.float32(rng.uniform(0.04, 0.1)) * folds - np.float32(rng.uniform(0.0, 0.03))
    return (inner * height).astype(np.float32), np.float32(rng.uniform(0.0, 0.15)) * inner


def _inside(rng: Rng) -> Light:
    rim = rng.uniform(0.06, 0.24)
    edge = _radius + np.float32(0.02) * noise(rng, SHAPE, FACE_CELLS / 5)
    return smooth_step(((np.float32(1 - rim) - edge) / np.float32(rng.uniform(0.03, 0.1))).astype(np.float32))


def _flow(rng: Rng) -> Light:
    """Grain drawn out along a flow that turns: folds beside one another, standard deviation 1."""
    width = FACE_CELLS / rng.uniform(9, 26)
    grain, angle = noise(rng, SHAPE, width), np.float32(np.pi) * noise(rng, SHAPE, FACE_CELLS / rng.uniform(1.0, 2.5))
    step_x, step_y = np.cos(angle) * np.float32(width / 6), np.sin(angle) * np.float32(width / 6)
    total = grain.copy()
    for sign in (1, -1):
        x, y = _cells_x.copy(), _cells_y.copy()
        for _ in range(FLOW_STEPS):
            x, y = (x + sign * _at(step_x, x, y)).astype(np.float32), (y + sign * _at(step_y, x, y)).astype(np.float32)
            total += _at(grain, x, y)
    return ((total - total.mean()) / total.std()).astype(np.float32)


def _at(plane: Light, x: Light, y: Light) -> Light:
    return np.asarray(cv2.remap(plane, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT), np.float32)


def _rings(rng: Rng) -> Light:
    """Folds around one or two places, pushed aside by slow displacements, standard deviation 1."""
    number, bend = rng.uniform(3, 9), np.float32(rng.uniform(0.05, 0.25))
    x, y = (_x + bend * noise(rng, SHAPE, FACE_CELLS / rng.uniform(2, 5)) for _ in range(2))
    waves = np.zeros(SHAPE, np.float32)
    for _ in range(int(rng.integers(1, 3))):
        middle_x, middle_y = rng.uniform(-0.7, 0.7, 2)
        phase = np.float32(np.pi * number) * np.hypot(x - np.float32(middle_x), y - np.float32(middle_y))
        waves += np.sin(phase + np.float32(rng.uniform(0, 2 * np.pi))).astype(np.float32)
    sharp = np.tanh(np.float32(rng.uniform(0.6, 2)) * waves)
    return ((sharp - sharp.mean()) / sharp.std()).astype(np.float32)


def _mould(rng: Rng) -> Light:
    """How much cooler the mould left the middle, its border soft and crooked."""
    if rng.random() < 0.4:
        return np.zeros(SHAPE, np.float32)
    (x, y), crooked = rng.normal(0, 0.12, 2), np.float32(rng.uniform(0.03, 0.2))
    distance = np.hypot(_x - np.float32(x), _y - np.float32(y)) + crooked * noise(rng, SHAPE, FACE_CELLS / 5)
    border = (np.float32(rng.uniform(0.3, 0.8)) - distance) / np.float32(rng.uniform(0.15, 0.7))
    return np.float32(rng.uniform(0.05, 0.35)) * smooth_step((border + np.float32(0.5)).astype(np.float32))


def _scratches(rng: Rng) -> Light:
    """Height of furrows, 0.01 to 0.06 deep, between the two lips that they threw up."""
    height = np.zeros(SHAPE, np.float32)
    turn = rng.uniform(0, 2 * np.pi)
    for _ in range(int(rng.integers(0, 12))):
        angle = turn + rng.normal(0, 0.3 if rng.random() < 0.6 else 3.0)
        x, y = rng.uniform(-0.7, 0.7, 2)
        along = (_x - np.float32(x)) * math.cos(angle) + (_y - np.float32(y)) * math.sin(angle)
        aside = (_y - np.float32(y)) * math.cos(angle) - (_x - np.float32(x)) * math.sin(angle)
        aside = (aside + np.float32(rng.normal(0, 0.3)) * along**2) / np.float32(rng.uniform(0.012, 0.035))
        shape = (1 - aside**2) * np.exp(-(aside**2) / 2 - (along / np.float32(rng.uniform(0.08, 0.4))) ** 4)
        height -= np.float32(rng.uniform(0.01, 0.06)) * shape.astype(np.float32)
    return height


def _dents(rng: Rng) -> Light:
    """Height of the hollows that tongs and chains press, 0.01 to 0.07 deep and 0.02 to 0.12 of the radius wide."""
    height = np.zeros(SHAPE, np.float32)
    for _ in range(int(rng.integers(0, 5))):
        x, y = rng.uniform(-0.8, 0.8, 2)
        wide, high = rng.uniform(0.02, 0.12, 2)
        distance = ((_x - np.float32(x)) / np.float32(wide)) ** 2 + ((_y - np.float32(y)) / np.float32(high)) ** 2
        height -= np.float32(rng.uniform(0.01, 0.07)) * np.exp(-distance).astype(np.float32)
    return height


def _plates(rng: Rng) -> tuple[Light, Light]:
    """Height and cooling of plates of scale: cells of a broken crust, some of which are still there."""
    if rng.random() < 0.5:
        return np.zeros(SHAPE, np.float32), np.zeros(SHAPE, np.float32)
    seeds = rng.uniform(-1.1, 1.1, (int(rng.integers(12, 90)), 2)).astype(np.float32)
    bend = np.float32(0.04) * noise(rng, SHAPE, FACE_CELLS / 12)
    cell = np.hypot((_x + bend)[..., None] - seeds[:, 0], (_y - bend)[..., None] - seeds[:, 1]).argmin(axis=-1)
    there = (rng.random(len(seeds)) < rng.uniform(0.05, 0.35)).astype(np.float32)
    crust = there[cell]
    return np.float32(0.01) * crust, np.float32(rng.uniform(0.05, 0.3)) * crust
