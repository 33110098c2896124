"""What stands still around the ingots: rollers, frames, posts, lamps and the dark hall, drawn once by ray casting."""

from dataclasses import dataclass

import cv2
import numpy as np

from appliance.simulation.bars.background import blurred
from appliance.simulation.ingots.faces import Rng, noise
from appliance.simulation.sensor import Blur, Light
from appliance.simulation.true_rig import TrueCamera

TEXTURE_CELLS = 256
FAR_MM = 60_000.0


@dataclass(frozen=True, slots=True, eq=False)
class Hall:
    """The line without ingots.

    Attributes
    ----------
    light : ndarray of float32, shape (rows, columns, 3)
        Linear light, blurred, blue-green-red.
    sheen : ndarray of float32, shape (rows, columns)
        Part of light from above that the place in the picture sends to the camera.
    x_mm, y_mm : ndarray of float32, shape (rows, columns)
        Where each pixel's ray meets the plane of the rollers' tops, far away above the horizon.
    """

    light: Light
    sheen: Light
    x_mm: Light
    y_mm: Light


def draw(camera: TrueCamera, rays: Light, rng: Rng, *, radius_mm: float, brightness: float, blur: Blur) -> Hall:
    """Hall around a line for ingots of a radius.

    Parameters
    ----------
    camera : TrueCamera
    rays : ndarray of float32, shape (rows, columns, 3)
        Unit direction of each pixel's light.
    rng : Generator
    radius_mm : float
        Of the usual ingot.
    brightness : float
        Of the lamps: 1 lets a roller send 4 % of full scale, the dark hall 5 to 25 % of that, the floor 10 to 45 % of
        it more, and the frame beside the line 60 to 140 %.
    blur : Blur
    """
    texture = _texture(rng)
    x, y = _on_plane(camera, rays, 0.0)
    below_horizon = rays[..., 2] < -1e-3
    half_width_mm = radius_mm * rng.uniform(1.4, 2.4)
    frame_mm = radius_mm * rng.uniform(0.25, 0.7)
    floor_x, floor_y = _on_plane(camera, rays, -rng.uniform(300, 900))

    reflectance = np.where(
        below_horizon, rng.uniform(0.1, 0.45) * _textured(texture, floor_x, floor_y, (2500, 4000)), 0
    )
    reflectance += rng.uniform(0.05, 0.25)
    on_frame = below_horizon & (np.abs(x) < half_width_mm + frame_mm)
    reflectance[on_frame] = (rng.uniform(0.6, 1.4) * _textured(texture, x, y, (300, 3000)))[on_frame]
    rollers = _rollers(y, rng) * _textured(texture, x, y, (900, 500))
    on_line = below_horizon & (np.abs(x) < half_width_mm)
    reflectance[on_line] = rollers[on_line]
    gap = below_horizon & (np.abs(np.abs(x) - half_width_mm) < 0.08 * radius_mm)
    reflectance[gap] *= 0.2
    reflectance = reflectance.astype(np.float32)
    for _ in range(int(rng.integers(4, 12))):
        _post(reflectance, camera, half_width_mm + frame_mm, rng)

    tint = rng.uniform((0.7, 0.85, 0.8), (1.2, 1.1, 1.15)).astype(np.float32)
    light = (0.04 * brightness * reflectance)[..., None] * tint
    for _ in range(int(rng.integers(2, 8))):
        light += np.float32(brightness) * _shine(x, y, half_width_mm, rng)[..., None]
    for _ in range(int(rng.integers(0, 4))):
        _lamp(light, rng)
    blurred_light = np.stack([blurred(np.ascontiguousarray(plane), blur) for plane in np.moveaxis(light, 2, 0)], axis=2)
    return Hall(blurred_light, blurred(np.where(on_line, rollers, 0.4 * reflectance).astype(np.float32), blur), x, y)


def _texture(rng: Rng) -> Light:
    sizes = (40.0, 12.0, 4.0)
    return 1 + np.float32(0.13) * sum(
        (noise(rng, (TEXTURE_CELLS, TEXTURE_CELLS), size) for size in sizes), np.zeros((1, 1), np.float32)
    )


def _textured(texture: Light, x_mm: Light, y_mm: Light, size_mm: tuple[float, float]) -> Light:
    """The texture, which repeats after `size_mm` in x and y."""
    u, v = (
        (np.mod(place / size, 1) * TEXTURE_CELLS).astype(np.float32)
        for place, size in zip((x_mm, y_mm), size_mm, strict=True)
    )
    wrapped = cv2.remap(texture, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    return np.maximum(wrapped, np.float32(0.1)).astype(np.float32)


def _on_plane(camera: TrueCamera, rays: Light, z_mm: float) -> tuple[Light, Light]:
    falling = np.minimum(rays[..., 2], np.float32(-1e-6))
    depth = np.minimum((z_mm - camera.centre_mm[2]) / falling, FAR_MM)
    x, y = (np.float32(camera.centre_mm[axis]) + depth * rays[..., axis] for axis in range(2))
    return x.astype(np.float32), y.astype(np.float32)


def _rollers(y: Light, rng: Rng) -> Light:
    """Reflectance along the line: round rollers with dark gaps, each worn in its own way."""
    pitch_mm = rng.uniform(250, 700)
    worn = rng.uniform(0.75, 1.25, 1024)
    number = np.floor(y / pitch_mm)
    across = 2 * (y / pitch_mm - number) - 1  # -1 to 1 over one roller
    highlight = rng.uniform(-0.4, 0.4)
    shape = rng.uniform(0.4, 0.9) + rng.uniform(0.2, 0.9) * np.exp(-(((across - highlight) / 0.35) ** 2))
    shape *= np.clip((1 - np.abs(across)) / rng.uniform(0.05, 0.3), 0.1, 1)
    return (shape * worn[number.astype(np.int64) % len(worn)]).astype(np.float32)


def _post(reflectance: Light, camera: TrueCamera, beside_mm: float, rng: Rng) -> None:
    """An upright post or box 150 to 2500 mm beside the line, 60 to 350 mm wide and 300 to 2500 mm high.

    It reaches 600 mm below the rollers' tops and sends 5 to 50 % of what a roller does. One with a corner 10,000 px
    from the picture or further is left out: OpenCV's fixed-point numbers end at 32,767 px.
    """
    x = rng.choice([-1, 1]) * (beside_mm + rng.uniform(150, 2500))
    y = rng.uniform(-8000, 3000)
    height, width = rng.uniform(300, 2500), rng.uniform(60, 350)
    corners = np.array([[x, y, -600], [x + width, y, -600], [x + width, y, height], [x, y, height]])
    pixels = camera.project(corners)
    if not np.isnan(pixels).any() and np.abs(pixels).max() < 1e4:
        level = rng.uniform(0.05, 0.5)
        cv2.fillPoly(reflectance, [np.rint(pixels * 16).astype(np.int32)], level, cv2.LINE_AA, shift=4)


def _shine(x: Light, y: Light, half_width_mm: float, rng: Rng) -> Light:
    """A lamp's weak reflection on the line: 30 to 120 mm beside, 80 to 300 mm along, 3 to 12 % of full scale."""
    place = rng.uniform(-1, 1) * half_width_mm, rng.uniform(-2500, 2500)
    size = rng.uniform(30, 120), rng.uniform(80, 300)
    blob = np.exp(-((((x - place[0]) / size[0]) ** 2 + ((y - place[1]) / size[1]) ** 2) ** 2))
    return (rng.uniform(0.03, 0.12) * blob).astype(np.float32)


def _lamp(light: Light, rng: Rng) -> None:
    """A warm or white lamp on the wall or beside the line."""
    rows, columns, _ = light.shape
    side = rng.choice([rng.uniform(0.02, 0.25), rng.uniform(0.75, 0.98)])
    centre = round(16 * side * columns), round(16 * rng.uniform(0.02, 0.6) * rows)
    warm = rng.random() < 0.6
    colour = np.array((0.15, 0.5, 1.0) if warm else (1.0, 1.0, 1.0)) * rng.uniform(0.2, 1.5)
    spot = np.zeros((rows, columns), np.float32)
    cv2.circle(spot, centre, round(16 * rng.uniform(2, 9)), 1.0, -1, cv2.LINE_AA, shift=4)
    light += spot[..., None] * colour.astype(np.float32)
