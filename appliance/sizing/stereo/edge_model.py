"""Reads an edge forest that `hotgauge train-edges` wrote."""

from pathlib import Path

from appliance.errors import reading_advice
from appliance.sizing.method import ScaleError
from vision.edges.forest.model import StructuredForest


class EdgeModelError(ScaleError):
    """A forest cannot be read; the message says which, why and what to do."""

    fault = "rig_unusable"


def load_edge_model(path: Path) -> StructuredForest:
    """Read a forest.

    Parameters
    ----------
    path : Path
        `.npz` file of `hotgauge train-edges`.

    Raises
    ------
    EdgeModelError
        The file is missing, damaged, or no forest.
    """
    try:
        return StructuredForest.load(path)
    except OSError as error:
        raise EdgeModelError(
            f"{path}: cannot be read ({error.strerror}); {reading_advice(error, 'make it with `hotgauge train-edges`')}"
        ) from error
    except ValueError as error:
        raise EdgeModelError(f"{error}; make the file anew with `hotgauge train-edges`") from error
