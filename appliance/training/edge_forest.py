"""Trains the edge forest on rendered scenes, or on a folder in the layout of BSDS500."""

import json
import resource
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol, cast

import cv2
import numpy as np
from scipy import io  # pyright: ignore[reportMissingTypeStubs]
from scipy.io.matlab import MatReadError  # pyright: ignore[reportMissingTypeStubs]

from appliance.errors import HotgaugeError
from appliance.training import edge_scenes
from vision.edges.forest.model import StructuredForest
from vision.edges.forest.training import Example, forest_of, train_tree
from vision.edges.forest.tree import Criterion, Growth, Tree

TREES = 8  # as Dollar and Zitnick, doi:10.1109/TPAMI.2014.2377715
TREES_EVALUATED = 4  # of each pixel; as in the same paper
SCENE_EXAMPLES = 400  # chosen: rendered pictures for each tree


class TrainingError(HotgaugeError):
    """Training pictures are missing or the model cannot be written; the message says what, where and what to do."""


class Source(Protocol):
    """Supplies the examples of each tree."""

    @property
    def version(self) -> str:
        """Name and version of the examples, for the record."""
        ...

    @property
    def uneven_part(self) -> float:
        """Share of uneven patches without an edge; see `train_tree`."""
        ...

    def examples(self, rng: np.random.Generator) -> tuple[int, Iterable[Example]]:
        """Number of examples for one tree, and the examples."""
        ...


@dataclass(frozen=True, slots=True)
class SceneSource:
    """Rendered scenes of the mill, and shapes."""

    version: str = edge_scenes.DATA_VERSION
    uneven_part: float = 0.5  # chosen: steep places that are no edge are rare on a bar, so they are drawn more often

    def examples(self, rng: np.random.Generator) -> tuple[int, Iterable[Example]]:
        """Render examples for one tree; no other tree has the same ones."""
        return SCENE_EXAMPLES, edge_scenes.edge_examples(int(rng.integers(1 << 31)), SCENE_EXAMPLES)


class BsdsSource:
    """Training pictures of a folder in the layout of BSDS500.

    Parameters
    ----------
    folder : Path
        Holds `images/train/NAME.jpg` and `groundTruth/train/NAME.mat`.

    Raises
    ------
    TrainingError
        The folder holds no such pictures.
    """

    version = "BSDS500 train"
    uneven_part = 0.0

    def __init__(self, folder: Path) -> None:
        self._pairs = bsds_pairs(folder, "train")

    def examples(self, rng: np.random.Generator) -> tuple[int, Iterable[Example]]:  # noqa: ARG002  all pictures are used
        """All pictures; each tree draws its own patches of them."""
        return len(self._pairs), (bsds_example(*pair) for pair in self._pairs)


def bsds_pairs(folder: Path, part: str) -> list[tuple[Path, Path]]:
    """Pairs of picture and ground truth, sorted by name.

    Parameters
    ----------
    folder : Path
        Folder in the layout of BSDS500.
    part : {"train", "val", "test"}

    Raises
    ------
    TrainingError
        The part has no pictures, or a picture has no ground truth.
    """
    pictures = sorted((folder / "images" / part).glob("*.jpg"))
    if not pictures:
        raise TrainingError(f"{folder}: no pictures in images/{part}; give a folder in the layout of BSDS500")
    truths = [folder / "groundTruth" / part / f"{picture.stem}.mat" for picture in pictures]
    for picture, truth in zip(pictures, truths, strict=True):
        if not truth.is_file():
            raise TrainingError(f"{picture}: its ground truth {truth} is missing")
    return list(zip(pictures, truths, strict=True))


def bsds_example(picture: Path, truth: Path) -> Example:
    """Read a picture and the segments that each person drew.

    Parameters
    ----------
    picture : Path
        JPEG.
    truth : Path
        MATLAB file with the segmentations.

    Raises
    ------
    TrainingError
        A file cannot be read.
    """
    image = cv2.imread(str(picture), cv2.IMREAD_COLOR)
    if image is None:
        raise TrainingError(f"{picture}: no readable picture")
    try:
        loaded = cast("dict[str, Any]", io.loadmat(truth))  # pyright: ignore[reportUnknownMemberType]
        people: list[Any] = list(loaded["groundTruth"][0])
        segments = tuple(np.asarray(person["Segmentation"][0, 0], np.int32) for person in people)
    except (OSError, MatReadError, NotImplementedError, KeyError, ValueError, IndexError) as error:
        raise TrainingError(f"{truth}: no ground truth as BSDS500 has it") from error
    return Example(np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.float32) / np.float32(255), segments)


@dataclass(frozen=True, slots=True)
class Record:
    """How a model was trained; written beside it as JSON."""

    command: str
    seed: int
    data: str
    trees: int
    patches_per_tree: int
    nodes: int
    cpu_seconds: float
    peak_memory_mb: float


def train(
    source: Source,
    seed: int,
    patches: int,
    command: str,
    on_progress: Callable[[int, int], None],
    *,
    criterion: Criterion = "gini",
) -> tuple[StructuredForest, Record]:
    """Train a forest.

    Parameters
    ----------
    source : Source
    seed : int
        The same seed and source give the same forest.
    patches : int
        Patches for each tree.
    command : str
        Command line, for the record.
    on_progress : callable
        Receives steps done and steps in all; each patch is two steps, drawn and sorted into its leaf.
    criterion : {"gini", "entropy"}
        See `Growth`.

    Returns
    -------
    tuple of StructuredForest and Record

    Raises
    ------
    TrainingError
        A picture or its ground truth cannot be read.
    """
    started = time.process_time()
    done = 0

    def advance(count: int) -> None:
        nonlocal done
        done += count
        on_progress(done, 2 * patches * TREES)

    growth = Growth(criterion=criterion)
    trees: list[Tree] = []
    for number in range(TREES):
        rng = np.random.default_rng([seed, number])
        count, examples = source.examples(rng)
        trees.append(
            train_tree(examples, max(1, patches // count), growth, rng, advance, uneven_part=source.uneven_part)
        )
    forest = forest_of(trees, TREES_EVALUATED)
    record = Record(
        command=command,
        seed=seed,
        data=source.version,
        trees=TREES,
        patches_per_tree=patches,
        nodes=len(forest.left_children),
        cpu_seconds=round(time.process_time() - started, 1),
        peak_memory_mb=round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024),
    )
    return forest, record


def check_output(output: Path) -> None:
    """Check, before training, that the model can be written.

    Raises
    ------
    TrainingError
        The folder is missing, the name does not end in `.npz`, or a `.json` of this name is not of a model.
    """
    if output.suffix != ".npz":
        raise TrainingError(f"{output}: a model's name ends in .npz")
    if not output.parent.is_dir():
        raise TrainingError(f"{output.parent}: no such folder; make it first")
    record = output.with_suffix(".json")
    if record.exists() and not output.exists():
        raise TrainingError(f"{record}: would be replaced by the record of this model; give another name")


def write(forest: StructuredForest, record: Record, output: Path) -> None:
    """Write the model, and beside it, with the suffix `.json`, its record.

    Parameters
    ----------
    forest : StructuredForest
    record : Record
    output : Path
        Model to write, `.npz`.

    Raises
    ------
    TrainingError
        The files cannot be written.
    """
    try:
        forest.save(output)
        output.with_suffix(".json").write_text(json.dumps(asdict(record), indent=2) + "\n")
    except OSError as error:
        raise TrainingError(f"{output}: {error.strerror}; give a file in a writable folder") from error
