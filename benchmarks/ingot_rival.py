"""Pictures of the ingot line with an end in them, and what one would write first to judge them."""

import cv2
import numpy as np
from ingot_truth import SETTINGS, simulated
from skimage.metrics import structural_similarity

from appliance.ingot.reader_setup import make_reader
from vision.ingot.classifiers.similarity import as_reference
from vision.ingot.orientation_reader import OrientationReader, References

EVERY = 4  # frames of the sequence from one picture to the next


def ingot_pictures(count: int) -> tuple[OrientationReader, References, list[np.ndarray]]:
    """A reader, its references, and pictures in which it finds an end, none of which it has judged yet."""
    scene = simulated(1, "mixed", 1)
    pictures = [picture for number, (picture, _) in enumerate(scene.frames) if number % EVERY == 0]
    reader = make_reader(SETTINGS, scene.view, pictures[0])
    return reader, scene.view.references, [picture for picture in pictures if reader._finder.find(picture)[0]][:count]


def whole_picture(picture: np.ndarray, references: References) -> list[float]:
    """The whole picture's threshold, its largest region, and its two similarities."""
    red = cv2.extractChannel(picture, 2)
    _, bright = cv2.threshold(red, 0, 255, cv2.THRESH_OTSU)
    _, _, boxes, _ = cv2.connectedComponentsWithStats(bright, connectivity=8)
    x, y, width, height, _ = boxes[1:][boxes[1:, cv2.CC_STAT_AREA].argmax()] if len(boxes) > 1 else boxes[0]
    square = as_reference(picture[max(y, y + height - width) : y + height, x : x + width])
    return [
        structural_similarity(square, as_reference(reference), gaussian_weights=True, sigma=1.5, data_range=255)
        for reference in (references.top, references.bottom)
    ]
