"""Bright reflections of lamps on the line, drawn once each."""

from dataclasses import dataclass

import cv2
import numpy as np

from appliance.simulation.ingots.hall import Hall
from appliance.simulation.ingots.timetable import Glare
from appliance.simulation.sensor import Light

COLOURS = np.array([[1.05, 1.0, 0.97], [0.25, 0.6, 1.05]], np.float32)  # white, warm; blue-green-red
REACH = 2.0  # of its half widths
RAGGED = 0.15  # of its half widths, by which its outline is streaked along the rollers
SOFT = 0.08


@dataclass(frozen=True, slots=True, eq=False)
class GlarePatch:
    """A glare in the picture.

    Attributes
    ----------
    rows, columns : slice
    light : ndarray of float32, shape (rows, columns, 3)
        Linear light, blue-green-red.
    """

    rows: slice
    columns: slice
    light: Light


def draw(glare: Glare, hall: Hall, core_px: float) -> GlarePatch:
    """A patch with a ragged outline on the rollers, blurred; empty when it lies outside the picture."""
    (x, y), (width, depth) = glare.place_mm, glare.size_mm
    square = ((hall.x_mm - x) / width) ** 2 + ((hall.y_mm - y) / depth) ** 2
    near = square < REACH**2
    if not near.any():
        return GlarePatch(slice(0, 0), slice(0, 0), np.zeros((0, 0, 3), np.float32))
    hit_rows, hit_columns = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
    rows, columns = (slice(int(hit[0]), int(hit[-1]) + 1) for hit in (hit_rows, hit_columns))
    square, near = square[rows, columns], near[rows, columns]
    rough = np.random.default_rng(glare.seed).standard_normal(square.shape, dtype=np.float32)
    streaks = cv2.GaussianBlur(rough, (0, 0), sigmaX=12, sigmaY=1.5)
    place = np.sqrt(square) + RAGGED * streaks / max(1e-6, float(np.std(streaks)))
    sheen = 0.6 + 0.4 * np.minimum(hall.sheen[rows, columns], 1)
    patch = np.where(near, glare.level * sheen / (1 + np.exp((place - 1) / SOFT)), 0).astype(np.float32)
    colour = COLOURS[0] + np.float32(glare.warmth) * (COLOURS[1] - COLOURS[0])
    return GlarePatch(rows, columns, cv2.GaussianBlur(patch, (0, 0), core_px)[..., None] * colour)
