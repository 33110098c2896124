"""Plots of a comparison: errors with U over frames, or similarities with both references over frames."""

import contextlib
from collections.abc import Generator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from appliance.comparison.files import EndTruth
from appliance.comparison.sizes import Sizes
from appliance.sizing.figures import figure_class, mark_frames, save_figure
from vision.ingot.classifiers.ssim import SIMILARITY_THRESHOLD

TRUTH_COLOURS = {"top": "tab:red", "bottom": "tab:blue"}


def plot_sizes(sizes: Sizes, path: Path) -> None:
    """Draw error with U, frame by frame; frames with a bar and without a value are marked at the foot.

    Raises like `_axes`.

    Parameters
    ----------
    sizes : Sizes
    path : Path
        Picture to write.
    """
    with _axes(path) as axes:
        error = sizes.error_mm
        there = np.isfinite(error)
        expanded = np.nan_to_num(sizes.expanded_mm[there])
        axes.errorbar(sizes.frame[there], error[there], yerr=expanded, fmt="o", ms=3, capsize=2, label="diameter ± U")
        beside = sizes.virtual_board_mm - sizes.truth_mm
        if np.isfinite(beside).any():
            axes.plot(sizes.frame, beside, "x", ms=4, color="tab:orange", label="virtual board")
        mark_frames(axes, sizes.frame[np.isfinite(sizes.truth_mm) & ~there].tolist())
        axes.axhline(0, color="black", linewidth=0.8)
        axes.set(xlabel="frame", ylabel="error, mm", title="Reading less truth; red at the foot: a bar and no value")


def plot_ends(rows: Sequence[dict[str, Any]], truth: Mapping[int, EndTruth], path: Path) -> None:
    """Draw both similarities over frames, like figures 6.12 to 6.20; the ground says which end it truly is.

    Raises like `_axes`.

    Parameters
    ----------
    rows : sequence of dict
        Of `orient`.
    truth : mapping of int to EndTruth
    path : Path
        Picture to write.
    """
    with _axes(path) as axes:
        seen = [row for row in rows if row.get("frame") in truth and row["present"]]
        frame = [row["frame"] for row in seen]
        for name, mark, words in (("ssim_top", "o", "with the top"), ("ssim_bottom", "s", "with the bottom")):
            axes.plot(frame, [row[name] for row in seen], mark, ms=3, label=f"similarity {words}")
        for label, colour in TRUTH_COLOURS.items():
            of_label = [number for number, true in truth.items() if true.present and true.label == label]
            shown = f"truly {label}"
            for number in of_label:
                axes.axvspan(number - 0.5, number + 0.5, color=colour, alpha=0.1, linewidth=0, label=shown)
                shown = "_"
        axes.axhline(
            SIMILARITY_THRESHOLD, color="black", linewidth=0.8, linestyle="--", label=f"{SIMILARITY_THRESHOLD:g}"
        )
        axes.set(xlabel="frame", ylabel="structural similarity", title="Similarity with the references")


@contextlib.contextmanager
def _axes(path: Path) -> Generator[Any]:
    """Axes of a figure that is written at the end.

    Raises
    ------
    PlotsMissingError
        Matplotlib is not installed.
    OSError
        The file cannot be written.
    """
    figure = figure_class()(figsize=(9, 4.5), layout="constrained")
    axes = figure.subplots()
    yield axes
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    save_figure(figure, path)
