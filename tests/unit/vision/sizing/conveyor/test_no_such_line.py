"""Two hundred pictures that show no bar between barriers: a reason, never an error and never a value."""

import math

import cv2
import numpy as np
import pytest
from skimage import data

from vision.reasons import Reason
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

REFERENCES = (ConveyorReference(500), ConveyorReference(500, 80), ConveyorReference(500, 80, 2600))
SIZES = ((1, 1), (1, 40), (40, 1), (31, 31), (32, 32), (33, 64), (64, 33))
SHIPPED = {"camera", "coins", "page", "text", "clock", "moon", "chelsea", "coffee", "rocket", "brick", "astronaut"}
SMALL = 240, 320


def _uniform():
    for rows, columns in SIZES:
        for name, picture in (("black", np.zeros((rows, columns))), ("white", np.full((rows, columns), 255))):
            yield f"{name} {columns} x {rows}", picture.astype(np.uint8)
        noise = np.random.default_rng(rows).integers(0, 256, (rows, columns))
        yield f"noise {columns} x {rows}", noise.astype(np.uint8)


def _strokes(number):
    rng = np.random.default_rng(number)
    picture = np.full(SMALL, 30, np.uint8)
    for _ in range(1 + number % 8):
        ends = [(int(rng.integers(-320, 640)), int(rng.integers(-240, 480))) for _ in range(2)]
        cv2.line(picture, *ends, int(rng.integers(60, 256)), int(rng.integers(1, 30)), cv2.LINE_AA)
    return np.clip(picture + rng.normal(0, 3, SMALL), 0, 255).astype(np.uint8)


def _one_edge(number):
    rng = np.random.default_rng(number)
    picture, column = np.full(SMALL, 20, np.uint8), int(rng.integers(0, 320))
    corners = np.array([[column, 0], [320, 0], [320, 240], [column + int(rng.integers(-200, 200)), 240]])
    return cv2.fillPoly(picture, [corners], 200)


def _discs(number):
    rng = np.random.default_rng(number)
    picture = np.zeros(SMALL, np.uint8)
    for _ in range(40):
        at = int(rng.integers(0, 320)), int(rng.integers(0, 240))
        cv2.circle(picture, at, int(rng.integers(2, 40)), int(rng.integers(0, 256)), -1)
    return picture


def _clouds(number):
    noise = np.random.default_rng(number).integers(0, 256, SMALL).astype(np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 1 + number)


def pictures():
    """Names and pictures."""
    yield from _uniform()
    for name in sorted(SHIPPED):
        yield name, np.ascontiguousarray(getattr(data, name)()[..., :3] if name in COLOURED else getattr(data, name)())
    for make, count in ((_strokes, 80), (_one_edge, 40), (_discs, 30), (_clouds, 20)):
        for number in range(count):
            yield f"{make.__name__} {number}", make(number)


COLOURED = {"astronaut", "chelsea", "coffee", "rocket"}


def test_no_picture_raises_and_none_that_shows_no_line_has_a_value():
    valued, count = [], 0
    for count, (name, picture) in enumerate(pictures(), 1):
        gauge = ConveyorGauge([picture], REFERENCES[count % 3])
        hot = picture.copy()
        columns = hot.shape[1]
        hot[:, 3 * columns // 8 : 5 * columns // 8] = 240
        readings = [gauge.measure(one) for one in (picture, hot)]
        assert all(reading.reasons or math.isfinite(reading.diameter_mm) for reading in readings), name
        valued += [name for reading in readings if math.isfinite(reading.diameter_mm)]
    assert count >= 200
    assert not valued


@pytest.mark.parametrize("noise", [False, True])
def test_a_picture_of_twelve_megapixels_has_a_reason(noise):
    picture = np.zeros((3000, 4000), np.uint8)
    if noise:
        cv2.randu(picture, 0, 256)
    assert ConveyorGauge([picture], REFERENCES[0]).measure(picture).reasons & Reason.EDGE_NOT_FOUND
