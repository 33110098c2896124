"""Fits the weights of `WrinkleOdds` on the simulated ingot line: `python -m appliance.training.ingot_faces`.

Each line shows two ingots, drawn from seeds that no study uses. The simulated faces are varied further, so that the
weights also hold for faces that the simulation does not draw: bottoms get mottling, a darker middle, flakes and
streaks, tops lose contrast, and both are blurred, shifted and noisy.
"""

import argparse
import itertools
from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from appliance.ingot.reader_setup import make_reader
from appliance.ingot.settings import IngotSettings
from appliance.simulation.ingots.conditions import ingot_sequence
from vision.ingot.classifiers.similarity import SIZE, as_reference
from vision.ingot.classifiers.wrinkles import LARGEST_DEVIATION, WrinkleOdds
from vision.ingot.end_finder import Box, End
from vision.ingot.end_image import end_image
from vision.ingot.orientation_reader import IngotView, References
from vision.readings import OrientationReading

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
Rng = np.random.Generator

FIRST_SEED = 10000  # training draws seeds from here on, studies below
LINES = 200  # chosen
FRAME_STEP = 8  # chosen: frames in between show nearly the same face
VARIANTS = 2  # chosen: varied faces of each frame, beside the face itself
PENALTY = 1e-4  # chosen: of the squared weights, for each sample
NEWTON_STEPS = 30  # chosen
_across = (np.arange(SIZE) - (SIZE - 1) / 2) / (SIZE / 2)
_x, _y = np.meshgrid(_across, _across)
_disc = np.clip(20 * (1 - np.hypot(_x, _y)), 0, 1)


class Face(NamedTuple):
    """Picture of an end, its true label, and the classifier with its line's references."""

    image: Picture
    is_top: bool
    judge: WrinkleOdds


def main() -> None:
    """Fit the weights and print them as constants."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lines", type=int, default=LINES)
    lines = int(parser.parse_args().lines)
    rng = np.random.default_rng(FIRST_SEED)
    measured: list[Array] = []
    tops: list[bool] = []
    for seed in tqdm(range(FIRST_SEED, FIRST_SEED + lines), unit="line", disable=None):
        for face in faces(seed):
            images = [face.image] + [varied(face.image, rng, is_top=face.is_top) for _ in range(VARIANTS)]
            measured += [face.judge.relative(image) for image in images]
            tops += [face.is_top] * len(images)
    values, labels = np.array(measured), np.array(tops, float)
    mean, deviation = values.mean(axis=0), values.std(axis=0)
    weights, constant = fit(np.clip((values - mean) / deviation, -LARGEST_DEVIATION, LARGEST_DEVIATION), labels)
    for name, numbers in (("MEAN", mean), ("DEVIATION", deviation), ("WEIGHT", weights)):
        print(f"{name} = np.array([{', '.join(f'{number:.4g}' for number in numbers)}])")
    print(f"CONSTANT = {constant:.4g}")


def faces(seed: int) -> Iterator[Face]:
    """Ends of two ingots of a line, in every FRAME_STEP-th frame."""
    sequence = ingot_sequence(seed, "mixed", 2)
    references = References(sequence.references["top"], sequence.references["bottom"])
    view = IngotView(references, Box(*sequence.roi_crop), Box(*sequence.roi_centroid))
    judge = WrinkleOdds(as_reference(references.top), as_reference(references.bottom))
    reader = None
    for frame in itertools.count(0, FRAME_STEP):
        try:
            picture, truth = sequence.picture(frame)
        except StopIteration:
            return
        if truth.present and truth.state == "placed":
            reader = reader or make_reader(IngotSettings(), view, picture)
            reading = reader.read(picture)
            if reading.present:
                yield Face(end_image(picture, _end(reading)), truth.label == "top", judge)


def _end(reading: OrientationReading) -> End:
    return End(reading.center_x, reading.center_y, reading.radius, "region")


def varied(image: Picture, rng: Rng, *, is_top: bool) -> Picture:
    """Vary a face at random without changing its label.

    Parameters
    ----------
    image : ndarray of uint8, shape (SIZE, SIZE)
    rng : Generator
    is_top : bool
        Label of the face.
    """
    light = np.log(image.astype(float) + 4)
    if is_top and rng.random() < 0.4:
        slow = cv2.GaussianBlur(light, (0, 0), 12)
        light = np.where(_disc > 0, slow + (light - slow) * rng.uniform(0.5, 1), light)
    if not is_top and rng.random() < 0.8:
        light = light + _blemishes(rng) * _disc
    shown = np.exp(light) - 4
    if rng.random() < 0.5:
        shown = cv2.GaussianBlur(shown, (0, 0), rng.uniform(0.3, 0.9))
    if rng.random() < 0.5:
        shown = shown + rng.normal(0, rng.uniform(0, 3), shown.shape)
    shift = np.array([[1, 0, rng.normal(0, 0.5)], [0, 1, rng.normal(0, 0.5)]])
    moved = cv2.warpAffine(shown, shift, (SIZE, SIZE), borderMode=cv2.BORDER_REPLICATE)
    return np.clip(moved, 0, 255).astype(np.uint8)


def _blemishes(rng: Rng) -> Array:
    """Mottling, a darker middle, flakes and streaks, in logarithms of light.

    Mottling has a standard deviation of up to 0.1; the middle is darker by up to 0.14, and by 1/e of that 0.2 to 0.6 of
    the radius from it.
    """
    mottling = cv2.GaussianBlur(rng.standard_normal((SIZE, SIZE)), (0, 0), SIZE / rng.uniform(8, 20))
    x, y = rng.uniform(-0.3, 0.3, 2)
    middle = np.exp(-((_x - x) ** 2 + (_y - y) ** 2) / rng.uniform(0.2, 0.6) ** 2)
    change = rng.uniform(0, 0.1) * mottling / mottling.std() - rng.uniform(0, 0.14) * middle
    for _ in range(int(rng.integers(0, 14))):
        (x, y), turn, width = rng.uniform(-0.75, 0.75, 2), rng.uniform(0, np.pi), rng.uniform(0.03, 0.07)
        along = ((_x - x) * np.cos(turn) + (_y - y) * np.sin(turn)) / (width * rng.uniform(1, 3))
        across = (-(_x - x) * np.sin(turn) + (_y - y) * np.cos(turn)) / width
        change -= rng.uniform(0.02, 0.2) * np.exp(-(along**2 + across**2) / 2)
    return change


def fit(values: Array, labels: Array) -> tuple[Array, float]:
    """Logistic regression with an L2 penalty by Newton's method: weights and constant.

    Parameters
    ----------
    values : ndarray of float64, shape (n, features)
        Standardised.
    labels : ndarray of float64, shape (n,)
        1 top, 0 bottom.
    """
    design = np.column_stack([values, np.ones(len(values))])
    penalty = PENALTY * len(values) * np.append(np.ones(values.shape[1]), 0)
    weights = np.zeros(design.shape[1])
    for _ in range(NEWTON_STEPS):
        probability = 1 / (1 + np.exp(-design @ weights))
        slope = design.T @ (labels - probability) - penalty * weights
        curvature = (design * (probability * (1 - probability))[:, None]).T @ design + np.diag(penalty + 1e-9)
        weights = weights + np.linalg.solve(curvature, slope)
    return weights[:-1], float(weights[-1])


if __name__ == "__main__":
    main()
