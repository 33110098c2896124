"""Rays that are tangent to a cylinder by the geometry of a point and a circle, not by the code's own formula."""

import numpy as np

from vision.sizing.tangent.cylinder_fit import EdgeRays

CAMERAS = np.array([[-700.0, -900.0, 2400.0], [800.0, -1100.0, 2200.0]])
X0, Z0, RADIUS = 35.0, 120.0, 110.0
FOCAL_PX = 2200.0
TRUTH = np.array([X0, Z0, 0.0, 0.0, RADIUS])
START = TRUTH + np.array([1.0, -2.0, 0.002, -0.001, 1.5])


def tangent_rays(rng=None, noise_px=0.0, limbs=(0, 1, 2, 3), points=60, inwards=1.0):
    """Rays from both cameras that graze a cylinder along y; noise turns them across the bar."""
    parts = []
    for limb in limbs:
        camera, side = CAMERAS[limb // 2], (-1.0, 1.0)[limb % 2]
        to_axis = np.array([X0 - camera[0], Z0 - camera[2]])
        distance = np.hypot(*to_axis)
        y = np.linspace(-250, 250, points)
        angle = np.arctan2(to_axis[0], -to_axis[1]) + side * np.arcsin(RADIUS / distance)
        length = np.sqrt(distance**2 - RADIUS**2)
        touch = np.column_stack(
            [camera[0] + length * np.sin(angle) + 0 * y, y, camera[2] - length * np.cos(angle) + 0 * y]
        )
        if rng is not None:
            away = np.linalg.norm(touch - camera, axis=1)
            across = np.array([np.cos(angle), 0.0, np.sin(angle)])
            touch = touch + np.outer(rng.normal(0, noise_px, points) * away / FOCAL_PX, across)
        direction = touch - camera
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        window = np.arange(points) // 4
        parts.append(
            (
                np.tile(camera, (points, 1)),
                direction,
                np.full(points, side),
                np.full(points, FOCAL_PX),
                np.full(points, limb),
                window,
                np.full(points, inwards),
            )
        )
    return EdgeRays(*(np.concatenate(column) for column in zip(*parts, strict=True)))
