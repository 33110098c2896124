"""The crane's tongs: a rod, a hinge, and two bent arms that grip an ingot's side."""

import cv2
import numpy as np

from appliance.simulation.ingots.solid import end_circle_px
from appliance.simulation.ingots.timetable import Sight
from appliance.simulation.sensor import Light
from appliance.simulation.true_rig import TrueCamera

LIGHT = np.array([0.012, 0.014, 0.02], np.float32)  # blue-green-red
# Points of an arm from the hinge to the grip: sideways and up from the middle of the ingot, in its radii.
ARM = np.array([[0.0, 2.6], [1.25, 1.3], [1.2, 0.0], [0.8, -0.15]])
GRIP = 0.45  # of the ingot's length, from the end that is judged
THICKNESS = 0.16  # of the radius
OPENED = 1.5


def coverage(camera: TrueCamera, sight: Sight, corner: tuple[int, int], shape: tuple[int, int]) -> Light:
    """Part that tongs cover of each pixel of a window, given by its corner (x, y) and its shape."""
    axis, across, _ = sight.pose.axes
    radius = sight.ingot.radius_mm
    up = np.array([0.0, 0.0, 1.0])
    grip = np.array(sight.pose.end_mm) + GRIP * sight.ingot.length_mm * axis + sight.tongs_mm * up
    opening = OPENED if sight.tongs_mm > 0 else 1.0
    hinge = grip + ARM[0, 1] * radius * up
    lines = [np.stack([hinge, hinge + 30 * radius * up])]
    lines += [grip + radius * (side * ARM[:, :1] * across + ARM[:, 1:] * up) for side in (-opening, opening)]
    drawn = np.zeros(shape, np.uint8)
    thickness = max(2, round(THICKNESS * end_circle_px(camera, sight.ingot, sight.pose)[2]))
    for line in lines:
        pixels = camera.project(line) - corner
        if np.isfinite(pixels).all():
            points = np.rint(np.clip(pixels, -4000, 4000) * 8).astype(np.int32)
            cv2.polylines(drawn, [points], False, 255, thickness, cv2.LINE_AA, shift=3)
    return drawn.astype(np.float32) / np.float32(255)
