"""Shared parts of all plots of readings: the plotting library, its absence, marks of frames without a value."""

from pathlib import Path
from typing import Any

import numpy as np

from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_place

DOTS_PER_INCH = 100


class PlotsMissingError(HotgaugeError):
    """The plotting library is not installed; the message says what to do."""


def figure_class() -> Any:  # its stubs leave most argument types open
    """Class of the plotting library's figures; raises `PlotsMissingError`."""
    try:
        from matplotlib.figure import Figure  # noqa: PLC0415  takes 200 ms, which only plots need
    except ImportError as error:
        raise PlotsMissingError(
            "plots need Matplotlib, which is not installed; install it with: pip install matplotlib"
        ) from error
    return Figure


class PlotFolder:
    """Plots of a recording in one folder; collects readings, and draws them in `write`.

    Parameters
    ----------
    folder : Path
        Made if it is missing.

    Raises
    ------
    PlotsMissingError
        Matplotlib is not installed.
    OSError
        The folder cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self._new_figure = figure_class()
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def _save(self, figure: Any, name: str) -> None:
        save_figure(figure, self._folder / name)


def save_figure(figure: Any, path: Path) -> None:
    """Write a figure whole or not at all; raises `OSError` that names the file.

    Parameters
    ----------
    figure : Figure
    path : Path
        Its suffix is the format: PNG, PDF or SVG.
    """
    with whole_place(path) as place:
        try:
            figure.savefig(place, format=path.suffix[1:].lower(), dpi=DOTS_PER_INCH)
        except OSError as error:  # of a full disk, which names no file
            raise OSError(error.errno, error.strerror, str(path)) from error


def mark_frames(axes: Any, frames: list[int]) -> None:
    """Mark frames without a value at the foot of a plot.

    Parameters
    ----------
    axes : Axes
        With frame numbers along x.
    frames : list of int
    """
    axes.plot(frames, np.full(len(frames), 0.02), "|", color="tab:red", transform=axes.get_xaxis_transform())
