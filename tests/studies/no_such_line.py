"""Pictures that show no bar between barriers: a reason or a sentence for each, never an error, never a value."""

import math
from functools import cache

import cv2
import numpy as np
from skimage import data

from appliance.cameras.section import EmptyLine
from appliance.simulation.bars.bars import Bar
from appliance.simulation.thermal_line import ThermalLine, thermal_camera
from appliance.sizing.conveyor.empty_line import EmptyLineError, TimedConveyorGauge
from vision.sent_picture import SentPicture
from vision.sizing.conveyor.camera_view import ConveyorReference
from vision.sizing.conveyor.gauge import ConveyorGauge

TEXT = (
    "Clutter, noise, single and crossing edges, photographs that scikit-image ships, and sizes from 1 x 1 to "
    "4000 x 3000. Each picture is the empty line (itself), then a hot stripe is drawn on it (striped), and last it is "
    "shown to a gauge of a line that has barriers (elsewhere). What comes of it: a value, the reading's reasons, or "
    "the first words of the sentence that refuses it."
)
GIVEN = (ConveyorReference(500), ConveyorReference(500, 80), ConveyorReference(500, 80, 2600))
SIZES = ((1, 1), (1, 40), (40, 1), (31, 31), (32, 32), (33, 64), (64, 33), (480, 640), (3000, 4000))
PHOTOGRAPHS = (
    *("astronaut", "brick", "camera", "chelsea", "clock", "coffee", "coins", "grass", "gravel", "moon", "page"),
    *("rocket", "text"),
)
PALETTES = ("AUTUMN", "COOL", "HOT", "HSV", "INFERNO", "JET", "OCEAN", "RAINBOW", "TURBO", "WINTER")
SMALL = 240, 320
HOT = 240
SAMPLE = 6


def uniform(number):
    """Black, white and noise of each size."""
    rows, columns = SIZES[number // 3]
    if number % 3 < 2:
        return np.full((rows, columns), 255 * (number % 3), np.uint8)
    return np.random.default_rng(number).integers(0, 256, (rows, columns), np.uint8)


def photograph(number):
    picture = getattr(data, PHOTOGRAPHS[number])()
    return np.ascontiguousarray(picture if picture.ndim == 2 else picture[:, :, :3])


def palette(number):
    """A line between barriers in false colours."""
    return cv2.applyColorMap(line_pictures()[number % 2], getattr(cv2, f"COLORMAP_{PALETTES[number]}"))


def strokes(number):
    """Straight edges that cross."""
    rng = np.random.default_rng(number)
    picture = np.full(SMALL, 30, np.uint8)
    for _ in range(1 + number % 8):
        ends = [(int(rng.integers(-320, 640)), int(rng.integers(-240, 480))) for _ in range(2)]
        cv2.line(picture, *ends, int(rng.integers(60, 256)), int(rng.integers(1, 30)), cv2.LINE_AA)
    return np.clip(picture + rng.normal(0, 3, SMALL), 0, 255).astype(np.uint8)


def one_edge(number):
    rng = np.random.default_rng(number)
    picture, column = np.full(SMALL, 20, np.uint8), int(rng.integers(0, 320))
    corners = np.array([[column, 0], [320, 0], [320, 240], [column + int(rng.integers(-200, 200)), 240]])
    return cv2.fillPoly(picture, [corners], 200)


def two_edges(number):
    """Two long edges, bright outside, that cross in the picture as barriers never do."""
    rng = np.random.default_rng(number)
    row, column, lean = rng.uniform(180, 235), rng.uniform(110, 210), rng.uniform(0.25, 0.6, 2)
    y, x = np.mgrid[: SMALL[0], : SMALL[1]]
    left, right = x < column + lean[0] * (y - row), x > column - lean[1] * (y - row)
    picture = cv2.GaussianBlur(40 + 90.0 * left + 90.0 * right, (0, 0), 1.3)
    return np.clip(picture + rng.normal(0, 2, SMALL), 0, 255).astype(np.uint8)


def discs(number):
    rng = np.random.default_rng(number)
    picture = np.zeros(SMALL, np.uint8)
    for _ in range(40):
        at = int(rng.integers(0, 320)), int(rng.integers(0, 240))
        cv2.circle(picture, at, int(rng.integers(2, 40)), int(rng.integers(0, 256)), -1)
    return picture


def clouds(number):
    noise = np.random.default_rng(number).integers(0, 256, SMALL, np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 1 + number)


KINDS = {
    uniform: 3 * len(SIZES), photograph: len(PHOTOGRAPHS), palette: len(PALETTES), strokes: 70, one_edge: 30,
    two_edges: 20, discs: 30, clouds: 20,
}  # fmt: skip
DRAWN = {kind.__name__: kind for kind in KINDS}


def cases():
    return [{"kind": kind.__name__, "number": number} for kind, count in KINDS.items() for number in range(count)]


@cache
def line_pictures():
    """A line with barriers, empty and with a bar."""
    return ThermalLine(thermal_camera(), bar=Bar(165.0)).pictures(1, 1)


def gauge_of(picture, reference):
    return TimedConveyorGauge(
        EmptyLine([SentPicture.of(picture)], "picture"), lambda shown: ConveyorGauge(shown, reference)
    )


@cache
def gauge_elsewhere():
    return gauge_of(line_pictures()[0], ConveyorReference(500, 100))


def run(case):
    picture, reference = DRAWN[case["kind"]](case["number"]), GIVEN[case["number"] % len(GIVEN)]
    striped = picture.copy()
    columns = picture.shape[1]
    striped[:, 3 * columns // 8 : 5 * columns // 8] = HOT
    of_size = cv2.resize(picture, line_pictures()[0].shape[::-1], interpolation=cv2.INTER_LINEAR)
    gauge = cache(lambda: gauge_of(picture, reference))
    return {
        "itself": outcome(lambda: gauge().measure(picture)),
        "striped": outcome(lambda: gauge().measure(striped)),
        "elsewhere": outcome(lambda: gauge_elsewhere().measure(of_size)),
    }


def outcome(measure):
    try:
        reading, _ = measure()
    except EmptyLineError as error:
        return " ".join(str(error).split()[:5])
    return "value" if math.isfinite(reading.diameter_mm) else reading.reasons.names


def summary(rows):
    return {
        kind: {"pictures": len(found)}
        | {name: _counts([row[name] for row in found]) for name in ("itself", "striped", "elsewhere")}
        for kind in DRAWN
        if (found := [row for row in rows if row["kind"] == kind])
    }


def _counts(outcomes):
    values, sentences = outcomes.count("value"), sum(isinstance(one, str) for one in outcomes)
    return {"values": values, "sentences": sentences - values, "reasons": len(outcomes) - sentences}
