"""Plain pictures of ingots whose ends are known from how they are drawn: flat colours, no light, no camera."""

import cv2
import numpy as np

HOT = (40, 130, 240)  # blue-green-red
WHITE = (250, 250, 250)
DARK = (45, 45, 45)
ROWS, COLUMNS = 540, 960
CROP = (350, 110, 260, 340)
CENTROID = (390, 165, 180, 245)


def line():
    return np.full((ROWS, COLUMNS, 3), DARK, np.uint8)


def ingot(picture, x=480.0, y=280.0, radius=40.0, *, length=1.45, colour=HOT, lean=0.0):
    """Draw an end with its body above it; `length` in diameters, `lean` sideways in pixels."""
    up = (length - 1) * 2 * radius
    corners = [(x - radius, y), (x + radius, y), (x + 0.9 * radius + lean, y - up), (x - 0.9 * radius + lean, y - up)]
    cv2.fillPoly(picture, [np.rint(np.array(corners) * 16).astype(np.int32)], colour, cv2.LINE_AA, shift=4)
    _disc(picture, x + lean, y - up, 0.9 * radius, colour)
    _disc(picture, x, y, radius, colour)
    return cv2.GaussianBlur(picture, (0, 0), 1.2)


def _disc(picture, x, y, radius, colour):
    center = round(x * 16), round(y * 16)
    cv2.circle(picture, center, round(radius * 16), colour, -1, cv2.LINE_AA, shift=4)


def glare(picture, x, y, width, height):
    cv2.ellipse(picture, (round(x), round(y)), (round(width), round(height)), 0, 0, 360, WHITE, -1, cv2.LINE_AA)
    return picture
