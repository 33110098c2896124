"""Training of the edge forest: from our own rendered scenes, or from a folder in the layout of BSDS500."""

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
from vision.edges.forest.tree import Growth, Tree

TREES = 8
TREES_EVALUATED = 4
SCENE_EXAMPLES = 400  # of each tree


class TrainingError(HotgaugeError):
    """There is nothing to train from, or nowhere to write to; the message says what to do."""


class Source(Protocol):
    """Where examples come from."""

    @property
    def version(self) -> str:
        """What they are, for the record."""
        ...

    @property
    def uneven_part(self) -> float:
        """See `train_tree`."""
        ...

    def examples(self, rng: np.random.Generator) -> tuple[int, Iterable[Example]]:
        """How many examples, and the examples, for one tree."""
        ...


@dataclass(frozen=True, slots=True)
class SceneSource:
    """Our own rendered scenes and shapes."""

    version: str = edge_scenes.DATA_VERSION
    uneven_part: float = 0.5  # on a bar what is steep and no edge is rare, and has to be learnt

    def examples(self, rng: np.random.Generator) -> tuple[int, Iterable[Example]]:
        """Examples that no other tree sees."""
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

    def examples(self, rng: np.random.Generator) -> tuple[int, Iterable[Example]]:  # noqa: ARG002  none is left out
        """All pictures; each tree draws its own patches of them."""
        return len(self._pairs), (bsds_example(*pair) for pair in self._pairs)


def bsds_pairs(folder: Path, part: str) -> list[tuple[Path, Path]]:
    """Pictures and ground truths of a part, `train`, `val` or `test`, sorted by name.

    Raises
    ------
    TrainingError
        There are none, or a picture has no ground truth.
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
    """A picture and the segments that each person saw.

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
    """How a model was made; stands beside it as JSON."""

    command: str
    seed: int
    data: str
    trees: int
    patches_per_tree: int
    nodes: int
    cpu_seconds: float
    peak_memory_mb: float


def train(
    source: Source, seed: int, patches: int, command: str, on_progress: Callable[[int, int], None]
) -> tuple[StructuredForest, Record]:
    """Train a forest.

    Parameters
    ----------
    source : Source
    seed : int
        The same seed and source give the same forest.
    patches : int
        Of each tree.
    command : str
        For the record.
    on_progress : callable
        Gets how much is done, of how much: each patch counts when it is drawn and when it has reached its leaf.
    """
    started = time.process_time()
    done = 0

    def advance(count: int) -> None:
        nonlocal done
        done += count
        on_progress(done, 2 * patches * TREES)

    trees: list[Tree] = []
    for number in range(TREES):
        rng = np.random.default_rng([seed, number])
        count, examples = source.examples(rng)
        trees.append(
            train_tree(examples, max(1, patches // count), Growth(), rng, advance, uneven_part=source.uneven_part)
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
    """Refuse, before anything is trained, a place where the model cannot be written.

    Raises
    ------
    TrainingError
        The folder is missing, or the name does not end in `.npz`.
    """
    if output.suffix != ".npz":
        raise TrainingError(f"{output}: a model's name ends in .npz")
    if not output.parent.is_dir():
        raise TrainingError(f"{output.parent}: no such folder; make it first")


def write(forest: StructuredForest, record: Record, output: Path) -> None:
    """Write the model, and beside it, with the ending `.json`, how it was made.

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
