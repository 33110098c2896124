"""Trains the network of the classifier `relief` on rendered lines: `python -m appliance.training.ingot_relief`.

Cross entropy, by AdamW. A batch shows some ends of each of its lines beside that line's references, now and then beside
another line's. The later stages leave out the tops that show no more relief than a flat bottom, from which a network
learns to doubt every flat bottom.
"""

import argparse
import json
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from appliance.files.digest import file_sha256
from appliance.training.adamw import AdamW
from appliance.training.edge_forest import TrainingError, check_output
from appliance.training.relief_batches import SeenLine, batch_of, seen
from appliance.training.relief_slopes import first_layers, loss_and_slopes
from appliance.training.rendered_ends import MILLS, Mills, RenderedLine, rendered_line
from vision.ingot.classifiers.relief import MODEL, Layers

SEED = 777  # no study draws faces from it
FACES, VIEWS = 6, 4
LEAST_SHOWN = 0.12  # of a top's relief; on 40 simulated lines of each kind (seeds 7000 to 7039) no top shows less
RISING_SHARE = 0.03  # chosen, of a stage's steps: the rate rises, then falls along half a cosine
# A mean over an end and its mirror images is too near 0: with this factor the cross entropy of the frames of 240
# simulated lines (seeds 7000 to 7039 and 8000 to 8039 of each kind) is least.
LOG_ODDS_FACTOR = np.float32(1.5)


class LineSet(NamedTuple):
    """Lines that are drawn alike.

    Attributes
    ----------
    first : int
        Number of the first; no two sets share a number.
    lines : int
    mills : Mills
    """

    first: int
    lines: int
    mills: Mills = MILLS


class Stage(NamedTuple):
    """What is shown for how long.

    Attributes
    ----------
    line_sets : tuple of LineSet
    steps : int
    rate : float
        The largest.
    least_shown : float
        Tops that show less relief are left out; see `seen`.
    seed : tuple of int
        After `SEED`.
    """

    line_sets: tuple[LineSet, ...]
    steps: int
    rate: float
    least_shown: float
    seed: tuple[int, ...]


BLEMISHED_LINES = LineSet(0, 1000)
PLAIN_LINES = LineSet(2000, 120, Mills(soft_blemishes=False))
FLAKED_LINES = LineSet(3000, 200, Mills(foreign=0.4, scaled_bottoms=0.8, soft_blemishes=False))
STAGES = (
    Stage((BLEMISHED_LINES,), 2500, 3e-3, 0.0, (0,)),
    Stage((BLEMISHED_LINES, PLAIN_LINES), 1500, 2e-3, LEAST_SHOWN, (0, 1)),
    Stage((BLEMISHED_LINES, PLAIN_LINES), 1500, 2e-3, LEAST_SHOWN, (0, 2)),
    Stage((BLEMISHED_LINES, PLAIN_LINES), 1500, 2e-3, LEAST_SHOWN, (0, 3)),
    Stage((BLEMISHED_LINES, PLAIN_LINES, FLAKED_LINES), 1500, 2e-3, LEAST_SHOWN, (0, 5)),
)
# One line of each set and two steps of each stage: whoever changes what is drawn or how is trained sees it in a second.
SAMPLE = tuple(
    stage._replace(line_sets=tuple(one._replace(lines=1) for one in stage.line_sets), steps=2) for stage in STAGES
)


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
    stages : list of str
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
    stages: list[str]
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
    started = time.process_time()
    write(trained(STAGES).layers, output)
    record = Record(
        command="python -m appliance.training.ingot_relief",
        seed=SEED,
        stages=[described(stage) for stage in STAGES],
        log_odds_factor=float(LOG_ODDS_FACTOR),
        sample_losses=sample_losses(),
        cpu_seconds=round(time.process_time() - started, 1),
        sha256=file_sha256(output),
    )
    output.with_suffix(".json").write_text(json.dumps(record._asdict(), indent=2) + "\n", encoding="utf-8")


def described(stage: Stage) -> str:
    """Steps, rate and lines of a stage, for the record."""
    lines = " and ".join(
        f"{one.lines} from {one.first} ({100 * one.mills.foreign:.0f} % foreign, "
        f"{100 * one.mills.scaled_bottoms:.0f} % scaled bottoms, soft blemishes {one.mills.soft_blemishes})"
        for one in stage.line_sets
    )
    return f"{stage.steps} steps, rate {stage.rate:g}, seed {stage.seed}, tops of {stage.least_shown:g} on: {lines}"


def sample_losses() -> list[float]:
    """Losses of `SAMPLE`, to four decimals."""
    return [round(loss, 4) for loss in trained(SAMPLE).losses]


def trained(stages: tuple[Stage, ...]) -> Trained:
    """The network after some stages; on one computer, with one thread, always the same."""
    layers: Layers = []
    losses: list[float] = []
    lines: dict[LineSet, list[RenderedLine]] = {}
    for stage in stages:
        rng = np.random.default_rng([SEED, *stage.seed])
        layers = layers or first_layers(rng)
        lines |= {one: drawn(one) for one in stage.line_sets if one not in lines}
        shown = (seen(line, stage.least_shown) for one in stage.line_sets for line in lines[one])
        losses += train(layers, list(shown), stage, rng)
    weights, bias = layers[-1]
    return Trained([*layers[:-1], (weights * LOG_ODDS_FACTOR, bias * LOG_ODDS_FACTOR)], losses)


def drawn(line_set: LineSet) -> list[RenderedLine]:
    """Lines of a set; a number's line is always the same."""
    numbers = tqdm(range(line_set.first, line_set.first + line_set.lines), unit="line", disable=None)
    return [rendered_line(np.random.default_rng([SEED, number]), FACES, VIEWS, line_set.mills) for number in numbers]


def train(layers: Layers, lines: list[SeenLine], stage: Stage, rng: np.random.Generator) -> list[float]:
    """Change layers so that they tell tops from bottoms.

    Parameters
    ----------
    layers : list of (weights, bias)
    lines : list of SeenLine
    stage : Stage
        Its steps and largest rate.
    rng : numpy.random.Generator

    Returns
    -------
    list of float
        Mean cross entropy of each step's batch.
    """
    losses: list[float] = []
    optimiser = AdamW([one for pair in layers for one in pair])
    for step in tqdm(range(stage.steps), unit="step", disable=None):
        loss, slopes = loss_and_slopes(layers, batch_of(lines, rng))
        rising = min(1.0, (step + 1) / (RISING_SHARE * stage.steps))
        optimiser.step(slopes, stage.rate * rising * 0.5 * (1 + np.cos(np.pi * step / stage.steps)))
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
