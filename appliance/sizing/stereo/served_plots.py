"""Plots of the served method along a recording: the diameter with its uncertainty, and what that is made of."""

from pathlib import Path
from typing import Any

import numpy as np

from appliance.files.row_writer import Row
from appliance.sizing.figures import PlotFolder, mark_frames
from vision.readings import SizeReading

# Okabe and Ito's colours, told apart without red and green, and a mark for each decision
DECISIONS = {
    None: ("o", "#000000", "not judged"),
    "in": ("o", "#0072b2", "in tolerance"),
    "undecided": ("D", "#e69f00", "undecided: nearer to a limit than U"),
    "out": ("X", "#d55e00", "out of tolerance"),
}
PARTS = {
    "edge": ("#0072b2", "edges"),
    "calibration": ("#56b4e9", "calibration of the cameras"),
    "board": ("#009e73", "print and heights of the board"),
    "light": ("#f0e442", "light"),
    "shape": ("#cc79a7", "section that is not round"),
    "model": ("#d55e00", "edges that lie off as a whole"),
}


class ServedPlots(PlotFolder):
    """Collects readings, and draws them in `write`; parameters and errors as of `PlotFolder`."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._readings: list[tuple[int, SizeReading, Row]] = []

    def add(self, frame: int, reading: SizeReading, row: Row) -> None:
        """Add a frame's reading.

        Parameters
        ----------
        frame : int
            Number of the frame.
        reading : SizeReading
        row : dict
            As it is written: `target_mm` and `decision` are drawn.
        """
        self._readings.append((frame, reading, row))

    def write(self) -> None:
        """Draw `diameter.png` and `uncertainty.png`; nothing without a reading."""
        if self._readings:
            self._diameter()
            self._uncertainty()

    def _diameter(self) -> None:
        axes, figure = self._axes("Diameter of the hot bar, frame by frame", "diameter, mm")
        for decision, (mark, colour, label) in DECISIONS.items():
            chosen = [(frame, one) for frame, one, row in self._readings if one.valid and row["decision"] == decision]
            if chosen:
                axes.errorbar(
                    [frame for frame, _ in chosen],
                    [one.diameter_mm for _, one in chosen],
                    yerr=[one.expanded_uncertainty_mm for _, one in chosen],
                    fmt=mark, ms=4, capsize=2, color=colour, label=f"diameter ± U (k = 2), {label}",
                )  # fmt: skip
        both = [(frame, one.diameter_virtual_board_mm) for frame, one, _ in self._readings if one.valid]
        axes.plot(*zip(*both, strict=True) if both else ([], []), "_", color="grey", label="by virtual boards")
        targets = [(frame, row["target_mm"]) for frame, _, row in self._readings if row["target_mm"] is not None]
        if targets:
            axes.plot(*zip(*targets, strict=True), "--", color="black", linewidth=1, label="target")
        self._finish(axes, figure, "diameter.png")

    def _uncertainty(self) -> None:
        axes, figure = self._axes("What the uncertainty is made of, frame by frame", "share of the variance, %")
        valid = [(frame, one) for frame, one, _ in self._readings if one.valid]
        parts = np.array([[getattr(one, f"u_{part}_mm") ** 2 for part in PARTS] for _, one in valid]).reshape(-1, 6)
        shares = 100 * parts / np.maximum(parts.sum(axis=1, keepdims=True), 1e-12)
        below = np.zeros(len(valid))
        for column, (colour, label) in enumerate(PARTS.values()):
            axes.bar([frame for frame, _ in valid], shares[:, column], 1.0, bottom=below, color=colour, label=label)
            below += shares[:, column]
        axes.set_ylim(0, 100)
        self._finish(axes, figure, "uncertainty.png")

    def _axes(self, title: str, quantity: str) -> tuple[Any, Any]:
        figure = self._new_figure(figsize=(9, 5), layout="constrained")
        axes = figure.subplots()
        axes.set(xlabel="frame", ylabel=quantity, title=title)
        axes.ticklabel_format(useOffset=False)
        axes.grid(alpha=0.3)
        return axes, figure

    def _finish(self, axes: Any, figure: Any, name: str) -> None:
        without = [frame for frame, one, _ in self._readings if not one.valid]
        mark_frames(axes, without)
        if without:
            axes.plot([], [], "|", color="tab:red", label="no value")
        axes.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False)
        self._save(figure, name)
