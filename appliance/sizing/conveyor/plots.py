"""Plots of the conveyor method along a recording: the dissertation's four experiments by frame, and the diameter."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from appliance.files.atomic_file import whole_file
from appliance.files.columns import FileColumn
from appliance.files.row_writer import row_writer
from appliance.sizing.figures import PlotFolder, mark_frames
from vision.readings import SizeReading
from vision.reasons import Reason
from vision.sizing.conveyor.barriers import Barriers
from vision.sizing.conveyor.published_experiments import EXPERIMENTS, experiment

PANELS = {"(a)": (1, 2), "(b)": (3, 4)}
EXPERIMENT_NAMES = {1: "boundary, original", 2: "boundary, homographic", 3: "lines, original", 4: "lines, homographic"}
EXPERIMENT_OFFSET = 0.3  # frames between the error bars of two experiments

EXPERIMENT_COLUMNS = (
    FileColumn("experiment", "", None, "number of the dissertation's experiment"),
    FileColumn("frame", "", None, "number of the frame"),
    FileColumn("mean_mm", "mm", 4, "mean of the sizes that the experiment finds in the frame"),
    FileColumn("sigma_mm", "mm", 4, "their standard deviation, eq. 3.7 of the dissertation"),
)


class ConveyorPlots(PlotFolder):
    """Collects frames and draws them when all are there.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    barriers : Barriers or Reason
        Barriers of the empty line; with a Reason nothing was measured, and the plots show frames without a value.
    spacing_mm : float
        Distance of the barriers' inner faces, W.

    Raises
    ------
    PlotsMissingError
        Matplotlib is not installed.
    OSError
        The folder cannot be made.
    """

    def __init__(self, folder: Path, barriers: Barriers | Reason, spacing_mm: float) -> None:
        super().__init__(folder)
        self._barriers = barriers
        self._spacing_mm = spacing_mm
        self._readings: list[tuple[int, SizeReading]] = []
        self._counted: dict[int, list[tuple[int, float, float]]] = {number: [] for number in EXPERIMENTS}

    def add(self, frame: int, picture: NDArray[np.uint8], reading: SizeReading) -> None:
        """Add a frame, and size its picture by the four experiments of the dissertation.

        Parameters
        ----------
        frame : int
            Number of the frame.
        picture : ndarray of uint8, shape (rows, columns) or (rows, columns, 3)
        reading : SizeReading
        """
        self._readings.append((frame, reading))
        if isinstance(self._barriers, Reason) or not reading.valid:
            return
        for number in EXPERIMENTS:
            sized_mm = experiment(number, picture, self._barriers, self._spacing_mm)
            if sized_mm.size:
                self._counted[number].append((frame, float(sized_mm.mean()), float(sized_mm.std())))

    def write(self) -> None:
        """Draw `experiments.png` and `frames.png`, and write the experiments' figures to `experiments.csv`."""
        self._figures()
        self._experiments()
        self._frames()

    def _figures(self) -> None:
        """Mean and deviation of each frame in the four experiments, eq. 3.7, as rows."""
        path = self._folder / "experiments.csv"
        with whole_file(path) as file:
            write = row_writer(path, file, [column.name for column in EXPERIMENT_COLUMNS])
            for number, sized in self._counted.items():
                for frame, mean_mm, sigma_mm in sized:
                    values = (number, frame, mean_mm, sigma_mm)
                    cells = zip(EXPERIMENT_COLUMNS, values, strict=True)
                    write({column.name: column.written(value) for column, value in cells})

    def _experiments(self) -> None:
        """Mean and deviation of each frame in the four experiments, like figure 3.22 of the dissertation."""
        figure = self._new_figure(figsize=(11, 5.5), layout="constrained")
        for axes, (panel, numbers) in zip(figure.subplots(1, 2, sharey=True), PANELS.items(), strict=True):
            for place, number in enumerate(numbers):
                self._experiment(axes, number, (place - 0.5) * EXPERIMENT_OFFSET, f"C{place}")
            self._served(axes)
            axes.set(xlabel="frame", ylabel="diameter, mm", title=f"{panel} Experiment {numbers[0]}-{numbers[1]}")
            axes.grid(alpha=0.3)
            axes.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.13))  # clear of the frames
        self._save(figure, "experiments.png")

    def _experiment(self, axes: Any, number: int, aside: float, colour: str) -> None:
        if not self._counted[number]:
            return
        frame, mean_mm, sigma_mm = np.array(self._counted[number]).T
        label = (
            f"{number}: {EXPERIMENT_NAMES[number]}; l {mean_mm.mean():.1f}, RMSE {mean_mm.std():.2f}, "
            f"mean sigma {sigma_mm.mean():.2f} mm"
        )
        axes.errorbar(frame + aside, mean_mm, yerr=sigma_mm, fmt="o", ms=3, capsize=2, color=colour, label=label)
        axes.axhline(mean_mm.mean(), color=colour, linewidth=0.8, linestyle="--")

    def _frames(self) -> None:
        """Served diameter of each frame with its expanded uncertainty."""
        figure = self._new_figure(figsize=(9, 4.5), layout="constrained")
        axes = figure.subplots()
        self._served(axes)
        mark_frames(axes, [number for number, reading in self._readings if not reading.valid])
        axes.set(xlabel="frame", ylabel="diameter, mm", title="Between barriers, frame by frame; red: no value")
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
        self._save(figure, "frames.png")

    def _served(self, axes: Any) -> None:
        valid = [(frame, one) for frame, one in self._readings if one.valid]
        axes.errorbar(
            [frame for frame, _ in valid],
            [one.diameter_mm for _, one in valid],
            yerr=[one.expanded_uncertainty_mm for _, one in valid],
            fmt="s", ms=3, capsize=2, color="black", label="served diameter ± U",
        )  # fmt: skip
