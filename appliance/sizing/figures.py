"""Shared parts of all plots of readings: the plotting library, its absence, marks of frames without a value."""

from typing import Any

import numpy as np

from appliance.errors import HotgaugeError

DOTS_PER_INCH = 100


class PlotsMissingError(HotgaugeError):
    """The plotting library is not installed; the message says what to do."""


def figure_class() -> Any:  # its stubs leave most argument types open
    """Class of the plotting library's figures; raises `PlotsMissingError`."""
    try:
        from matplotlib.figure import Figure  # noqa: PLC0415  takes 200 ms, which only plots need
    except ImportError as error:
        raise PlotsMissingError(
            "--plot: plots need Matplotlib, which is not installed; install it with: pip install 'hotgauge[plots]'"
        ) from error
    return Figure


def mark_frames(axes: Any, frames: list[int]) -> None:
    """Mark frames without a value at the foot of a plot.

    Parameters
    ----------
    axes : Axes
        With frame numbers along x.
    frames : list of int
    """
    axes.plot(frames, np.full(len(frames), 0.02), "|", color="tab:red", transform=axes.get_xaxis_transform())
