"""How long one picture of the ingot line takes, beside the two similarities that the source compares, on one core.

Both run in turn on the same pictures in one process; processor time, since others may use the computer.
"""

import statistics
import time

import cv2
from ingot_truth import SETTINGS, simulated
from skimage.metrics import structural_similarity

from appliance.ingot.reader_setup import make_reader
from vision.ingot.classifiers.similarity import as_reference

SEEDS = (1, 2, 3)
EVERY = 4


def whole_picture(picture, references):
    """What one would write first: the whole picture's threshold, its largest region, and two similarities."""
    red = cv2.extractChannel(picture, 2)
    _, bright = cv2.threshold(red, 0, 255, cv2.THRESH_OTSU)
    _, _, boxes, _ = cv2.connectedComponentsWithStats(bright, connectivity=8)
    x, y, width, height, _ = boxes[1:][boxes[1:, cv2.CC_STAT_AREA].argmax()] if len(boxes) > 1 else boxes[0]
    square = as_reference(picture[max(y, y + height - width) : y + height, x : x + width])
    return [
        structural_similarity(square, as_reference(reference), gaussian_weights=True, sigma=1.5, data_range=255)
        for reference in references
    ]


def timed_ms(work, *arguments):
    started = time.process_time()
    work(*arguments)
    return 1000 * (time.process_time() - started)


def main():
    cv2.setNumThreads(1)
    ours, plain, found = [], [], []
    for seed in SEEDS:
        scene = simulated(seed, "mixed", 1)
        references = scene.view.references.top, scene.view.references.bottom
        reader = None
        for number, (picture, _) in enumerate(scene.frames):
            reader = reader or make_reader(SETTINGS, scene.view, picture)
            if number % EVERY:
                continue
            ours.append(timed_ms(reader.read, picture))
            plain.append(timed_ms(whole_picture, picture, references))
            if reader.read(picture).present:
                found.append(ours[-1])
    height, width = picture.shape[:2]
    ours_ms, plain_ms = statistics.median(found), statistics.median(plain)
    print(
        f"ingot line {width} x {height}: {ours_ms:.1f} ms a picture with an end ({max(ours):.1f} at most), "
        f"whole-picture threshold and two similarities {plain_ms:.1f} ms, ratio {ours_ms / plain_ms:.2f}"
    )


if __name__ == "__main__":
    main()
