"""Fits the evidence of both similarity classifiers on simulated lines: `python -m appliance.training.similarity_odds`.

Logistic regression of the true end on what a classifier compares (Platt, Probabilistic outputs for support vector
machines, 1999): the similarity with the top less the threshold, or less the similarity with the bottom. Lines are
drawn from seeds that no study uses. The ends look like the references: of another mill's, similarity says nothing.
"""

import argparse
import itertools
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from appliance.ingot.reader_setup import make_reader
from appliance.ingot.settings import IngotSettings
from appliance.simulation.ingots.conditions import ingot_sequence
from appliance.training.ingot_faces import fit
from vision.ingot.classifiers.ssim import SIMILARITY_THRESHOLD
from vision.ingot.end_finder import Box
from vision.ingot.orientation_reader import IngotView, References

Array = NDArray[np.float64]

FIRST_SEED = 20_000  # training draws seeds from here on, studies below
LINES = 200  # chosen
FRAME_STEP = 8  # chosen: frames in between show nearly the same face
CONDITION = "mixed"


def main() -> None:
    """Fit and print weight and constant of each classifier."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lines", type=int, default=LINES)
    lines = int(parser.parse_args().lines)
    with ProcessPoolExecutor(2) as pool:
        found = list(tqdm(pool.map(ends, range(FIRST_SEED, FIRST_SEED + lines)), total=lines, disable=None))
    rows = np.array([row for line in found for row in line])
    print(f"{len(rows)} ends")
    compared = {"single": rows[:, 1] - SIMILARITY_THRESHOLD, "dual": rows[:, 1] - rows[:, 2]}
    for name, values in compared.items():
        weight, constant = fit(values[:, None], rows[:, 0])
        right = float(np.mean((values > 0) == (rows[:, 0] > 0.5)))
        print(f"{name}: weight {weight[0]:.2f}, constant {constant:+.3f}, accuracy {right:.3f}")


def ends(seed: int) -> list[tuple[float, float, float]]:
    """Whether it is a top, and both similarities, of the ends of two ingots of a line."""
    return list(_ends(seed))


def _ends(seed: int) -> Iterator[tuple[float, float, float]]:
    sequence = ingot_sequence(seed, CONDITION, 2)
    references = References(sequence.references["top"], sequence.references["bottom"])
    view = IngotView(references, Box(*sequence.roi_crop), Box(*sequence.roi_centroid))
    reader = None
    for frame in itertools.count(0, FRAME_STEP):
        try:
            picture, truth = sequence.picture(frame)
        except StopIteration:
            return
        if truth.present and truth.state == "placed":
            reader = reader or make_reader(IngotSettings(classifier="dual"), view, picture)
            reading = reader.read(picture)
            if reading.present:
                yield float(truth.label == "top"), reading.ssim_top, reading.ssim_bottom


if __name__ == "__main__":
    main()
