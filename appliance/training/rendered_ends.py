"""Ends of ingots as pictures of 64 x 64, rendered without a mill: `relief_network` trains on them.

Faces of our own line and of other mills, under more blemishes still, beside a body and a dark line, through any lens,
exposure, response and JPEG. Nothing but wrinkled skin depends on the label.
"""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from appliance.simulation.ingots.faces import FACE_CELLS, Label, Rng, face, random_looks
from appliance.simulation.ingots.foreign_faces import foreign_face
from vision.ingot.classifiers.similarity import SIZE

Plane = NDArray[np.float32]
Picture = NDArray[np.uint8]

SHARE_OF_FOREIGN_FACES = 0.65
_across = np.linspace(-1, 1, FACE_CELLS, dtype=np.float32)
_x, _y = np.meshgrid(_across, _across)
_columns = np.arange(SIZE, dtype=np.float32)


def random_face(label: Label, rng: Rng) -> Plane:
    """Relative light of a face of any mill, shape (FACE_CELLS, FACE_CELLS)."""
    if rng.random() < SHARE_OF_FOREIGN_FACES:
        return foreign_face(label, rng)
    return face(random_looks(label, rng), rng)


def rendered_end(light: Plane, rng: Rng) -> Picture:
    """A picture of an end, as `end_image` would cut it out.

    Parameters
    ----------
    light : ndarray of float32, shape (FACE_CELLS, FACE_CELLS)
        Relative light of the face.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of uint8, shape (64, 64)
    """
    light = light * soft_blemishes(rng)
    scene = _scene(light / max(1e-6, float(light.mean())), rng)
    scene = np.asarray(
        cv2.GaussianBlur(scene, (0, 0), math.exp(rng.uniform(math.log(0.35), math.log(1.5)))), np.float32
    )
    peak = rng.uniform(0.3, 0.95) if rng.random() < 0.8 else rng.uniform(0.9, 1.7)
    return _coded(np.maximum(scene * np.float32(peak * 0.7) + np.float32(rng.uniform(0, 0.04)), 0), rng)


def soft_blemishes(rng: Rng) -> Plane:
    """Soft dark patches, streaks and a cooler middle, as factors of light."""
    light = np.ones((FACE_CELLS, FACE_CELLS), np.float64)
    if rng.random() < 0.5:
        along, across = (math.exp(rng.uniform(math.log(2), math.log(14))) for _ in range(2))
        rough = rng.standard_normal((FACE_CELLS, FACE_CELLS), dtype=np.float32)
        rough = np.asarray(cv2.GaussianBlur(rough, (0, 0), along, sigmaY=across), np.float32)
        middle = FACE_CELLS / 2, FACE_CELLS / 2
        turn = cv2.getRotationMatrix2D(middle, rng.uniform(0, 180), 1)
        rough = rough / np.float32(rough.std())
        size = (FACE_CELLS, FACE_CELLS)
        rough = np.asarray(cv2.warpAffine(rough, turn, size, borderMode=cv2.BORDER_REFLECT), np.float32)
        patch = 1 / (1 + np.exp(-(rough - rng.uniform(0.5, 2.2)) / rng.uniform(0.1, 0.6)))
        light = light * (1 - rng.uniform(0.05, 0.4) * patch)
    for _ in range(int(rng.integers(2, 25)) if rng.random() < 0.4 else 0):
        (x, y), turned = rng.uniform(-0.85, 0.85, 2).tolist(), rng.uniform(0, np.pi)
        width, longer = rng.uniform(0.02, 0.08), rng.uniform(1, 4)
        u = ((_x - x) * np.cos(turned) + (_y - y) * np.sin(turned)) / (width * longer)
        v = (-(_x - x) * np.sin(turned) + (_y - y) * np.cos(turned)) / width
        light = light * (1 - rng.uniform(0.03, 0.35) * np.exp(-(u**2 + v**2) / 2))
    if rng.random() < 0.3:
        size, (x, y) = rng.uniform(0.2, 0.7), rng.normal(0, 0.2, 2)
        light = light * (1 - rng.uniform(0.05, 0.35) * np.exp(-((_x - x) ** 2 + (_y - y) ** 2) / (2 * size**2)))
    return light.astype(np.float32)


def _scene(face_light: Plane, rng: Rng) -> Plane:
    """Light of the face, the body above it and the line around both, with glare beside them."""
    radius = SIZE / 2 * rng.uniform(0.93, 1.06)
    x, y = (SIZE - 1) / 2 + rng.normal(0, 0.8, 2) + np.array([0.0, rng.uniform(-0.03, 0.12) * SIZE / 2])
    across, down = np.broadcast_arrays(
        (_columns[None, :] - x) / radius, (_columns[:, None] - y) / (radius * rng.uniform(0.88, 1))
    )
    turn, mirror, half = rng.uniform(0, 2 * np.pi), rng.choice([-1, 1]), (FACE_CELLS - 1) / 2
    map_x = half * (1 + mirror * (across * np.cos(turn) - down * np.sin(turn)))
    map_y = half * (1 + across * np.sin(turn) + down * np.cos(turn))
    smooth = cv2.GaussianBlur(face_light, (0, 0), 1.0)
    shown = cv2.remap(
        smooth, map_x.astype(np.float32), map_y.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    rough = np.asarray(cv2.GaussianBlur(rng.standard_normal((SIZE, SIZE)), (0, 0), rng.uniform(1, 5)), np.float64)
    rough = rough / rough.std()
    inside = np.clip(0.5 + (1 - np.hypot(across, down)) * radius, 0, 1)
    body = np.clip(0.5 + (1 - np.abs(across)) * radius, 0, 1) * (down < 0)
    line_light, side_light = rng.uniform(0.01, 0.25) * (1 + 0.4 * rough), rng.uniform(0.65, 1.08) * (1 + 0.05 * rough)
    scene = line_light * (1 - body) + side_light * body
    scene = scene * (1 - inside) + shown * inside
    if rng.random() < 0.35:
        turn, away = rng.uniform(-0.3, np.pi + 0.3), rng.uniform(0.95, 1.5)
        wide, high = rng.uniform(0.2, 0.8), rng.uniform(0.1, 0.5)
        place = np.hypot((across - away * np.cos(turn)) / wide, (down - away * np.sin(turn)) / high)
        scene = scene + rng.uniform(0.5, 2) * (1 - inside) / (1 + np.exp(np.minimum((place - 1) / 0.1, 50)))
    if rng.random() < 0.3:
        bloom = rng.uniform(0.01, 0.08)
        scene = (1 - bloom) * scene + bloom * np.asarray(cv2.GaussianBlur(scene, (0, 0), 6), np.float64)
    return scene.astype(np.float32)


def _coded(light: Plane, rng: Rng) -> Picture:
    """Grey of an orange picture whose channels clip one after the other, with noise, perhaps as JPEG."""
    gains = rng.uniform(1.0, 1.5), rng.uniform(0.5, 1.0), rng.uniform(0.1, 0.6)  # red, green, blue
    channels = [np.clip(light * gain, 0, 1) ** (1 / 2.2) for gain in gains]
    noise = rng.standard_normal((SIZE, SIZE))
    if rng.random() < 0.6:
        noise = 1.8 * cv2.GaussianBlur(noise, (0, 0), 0.6)
    code = 255 * (0.299 * channels[0] + 0.587 * channels[1] + 0.114 * channels[2]) + rng.uniform(0.2, 3.0) * noise
    picture = np.clip(code, 0, 255).astype(np.uint8)
    if rng.random() < 0.6:
        _, packed = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(60, 96))])
        picture = np.asarray(cv2.imdecode(packed, cv2.IMREAD_GRAYSCALE), np.uint8)
    return picture
