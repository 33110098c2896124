"""Trains the network of the classifier `relief` on rendered lines: `python -m appliance.training.ingot_relief`.

Cross entropy, by AdamW. A batch shows some ends of each of its lines beside that line's references, now and then beside
another line's. Tops that show no more relief than a flat bottom are left out: from them a network learns to doubt every
flat bottom.
"""

import argparse
import json
import os
from collections.abc import Iterable
from concurrent.futures import Executor, ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from appliance.files.digest import file_sha256
from appliance.training.adamw import AdamW
from appliance.training.edge_forest import TrainingError, check_output
from appliance.training.relief_batches import batch_of, without_flat_tops
from appliance.training.relief_slopes import first_layers, loss_and_slopes
from appliance.training.rendered_ends import MILLS, Mills, RenderedLine, rendered_line
from vision.ingot.classifiers.relief import MODEL, Layers

SEED = 777  # no study draws faces from it
FACES = 6
LINES_A_TASK = 25
RATE = 3e-3  # chosen, the largest
LEAST_SHOWN = 0.12  # of a top's relief; on 40 simulated lines of each kind (seeds 7000 to 7039) no top shows less
RISING_SHARE = 0.03  # chosen, of the steps: the rate rises, then falls along half a cosine
# A mean over an end and its mirror images is too near 0: with this factor the cross entropy of the frames of 840
# simulated lines (seeds 5000 to 5099, 7000 to 7039, 8000 to 8039 and 11000 to 11099 of each kind) is least.
LOG_ODDS_FACTOR = 1.3


class LineSet(NamedTuple):
    """Lines that are drawn alike.

    Attributes
    ----------
    first : int
        Number of the first; no two sets share a number.
    lines : int
    views : int
        Pictures of each face.
    mills : Mills
    """

    first: int
    lines: int
    views: int
    mills: Mills = MILLS


class Plan(NamedTuple):
    """What is shown for how long.

    Attributes
    ----------
    line_sets : tuple of LineSet
    steps : int
    """

    line_sets: tuple[LineSet, ...]
    steps: int


PLAN = Plan(
    (
        LineSet(0, 7000, 4),
        LineSet(10000, 4800, 2, Mills(soft_blemishes=False)),
        LineSet(20000, 1200, 2, Mills(foreign=0.4, scaled_bottoms=0.8, soft_blemishes=False)),
    ),
    steps=22_000,
)
# Two lines of each set and ten steps: whoever changes what is drawn or how is trained sees it in a second.
SAMPLE = Plan(tuple(one._replace(lines=2) for one in PLAN.line_sets), steps=10)


class Trained(NamedTuple):
    """A network and how it came about.

    Attributes
    ----------
    layers : list of (weights, bias)
    losses : list of float
        Mean cross entropy of each step's batch.
    """

    layers: Layers
    losses: list[float]


class Record(NamedTuple):
    """How a model was trained; written beside it as JSON.

    Attributes
    ----------
    command : str
    seed : int
    steps : int
    rate : float
        The largest.
    line_sets : list of str
    log_odds_factor : float
        By which the last layer was multiplied.
    sample_losses : list of float
        Of `SAMPLE`.
    cpu_seconds : float
    sha256 : str
        Of the model.
    """

    command: str
    seed: int
    steps: int
    rate: float
    line_sets: list[str]
    log_odds_factor: float
    sample_losses: list[float]
    cpu_seconds: float
    sha256: str


def main() -> None:
    """Draw, train, write the model and its record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=MODEL, help="model to write, .npz; the served one by default")
    output: Path = parser.parse_args().output
    try:
        check_output(output)
    except TrainingError as error:
        parser.error(str(error))
    write(trained(PLAN).layers, output)
    record = Record(
        command="python -m appliance.training.ingot_relief",
        seed=SEED,
        steps=PLAN.steps,
        rate=RATE,
        line_sets=[described(one) for one in PLAN.line_sets],
        log_odds_factor=LOG_ODDS_FACTOR,
        sample_losses=sample_losses(),
        cpu_seconds=round(sum(os.times()[:4]), 1),
        sha256=file_sha256(output),
    )
    output.with_suffix(".json").write_text(json.dumps(record._asdict(), indent=2) + "\n", encoding="utf-8")


def described(line_set: LineSet) -> str:
    """Number and kind of a set's lines, for the record."""
    mills = line_set.mills
    return (
        f"{line_set.lines} lines from {line_set.first}, {FACES} faces of {line_set.views} pictures, "
        f"{100 * mills.foreign:.0f} % foreign, {100 * mills.scaled_bottoms:.0f} % scaled bottoms, "
        f"soft blemishes {mills.soft_blemishes}"
    )


def sample_losses() -> list[float]:
    """Losses of `SAMPLE`, to four decimals."""
    return [round(loss, 4) for loss in trained(SAMPLE).losses]


def trained(plan: Plan) -> Trained:
    """The network after a plan; on one computer, with one thread, always the same."""
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        lines = [line for one in plan.line_sets for line in drawn(one, pool)]
    rng = np.random.default_rng([SEED, 0])
    layers = first_layers(rng)
    losses = train(layers, lines, plan.steps, rng)
    weights, bias = layers[-1]
    return Trained([*layers[:-1], (weights * LOG_ODDS_FACTOR, bias * LOG_ODDS_FACTOR)], losses)


def drawn(line_set: LineSet, pool: Executor) -> Iterable[RenderedLine]:
    """Lines of a set; a number's line is always the same."""
    numbers = range(line_set.first, line_set.first + line_set.lines)
    lines = pool.map(partial(numbered_line, line_set), numbers, chunksize=LINES_A_TASK)
    return tqdm(lines, total=line_set.lines, unit="line", disable=None)


def numbered_line(line_set: LineSet, number: int) -> RenderedLine:
    """One line of a set."""
    line = rendered_line(np.random.default_rng([SEED, number]), FACES, line_set.views, line_set.mills)
    return without_flat_tops(line, LEAST_SHOWN)


def train(layers: Layers, lines: list[RenderedLine], steps: int, rng: np.random.Generator) -> list[float]:
    """Change layers so that they tell tops from bottoms.

    Parameters
    ----------
    layers : list of (weights, bias)
    lines : list of RenderedLine
    steps : int
    rng : numpy.random.Generator

    Returns
    -------
    list of float
        Mean cross entropy of each step's batch.
    """
    losses: list[float] = []
    optimiser = AdamW([one for pair in layers for one in pair])
    for step in tqdm(range(steps), unit="step", disable=None):
        loss, slopes = loss_and_slopes(layers, batch_of(lines, rng))
        rising = min(1.0, (step + 1) / (RISING_SHARE * steps))
        optimiser.step(slopes, RATE * rising * 0.5 * (1 + np.cos(np.pi * step / steps)))
        losses.append(loss)
    return losses


def write(layers: Layers, output: Path) -> None:
    """Write a model; the same layers give the same bytes.

    Parameters
    ----------
    layers : list of (weights, bias)
    output : Path
    """
    arrays = {
        f"{kind}{number}": one for number, pair in enumerate(layers) for kind, one in zip("Wb", pair, strict=True)
    }
    np.savez(output, allow_pickle=False, **arrays)


if __name__ == "__main__":
    main()
