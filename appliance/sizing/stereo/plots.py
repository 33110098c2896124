"""Plots of route V along a recording: diameter and trust per window, diameter per frame, Q_R and height over frames."""

import math
from pathlib import Path

import numpy as np

from appliance.sizing.figures import PlotFolder, mark_frames
from appliance.sizing.stereo.overlays import write_overlays
from vision.sizing.virtual_board.aligned_pair import AlignedPair
from vision.sizing.virtual_board.reading import VirtualBoardReading

TOLERANCE_BAND_MM = 3.0  # rolling tolerance of the dissertation, above and below
OVERLAY_FRAMES = 8  # chosen: frames, the first with windows, whose pictures are drawn over
WINDOW_PLOTS = 8  # chosen: frames, spread over the recording, whose windows are drawn


class Plots(PlotFolder):
    """Collects readings, and draws them in `write`; parameters and errors as of `PlotFolder`."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._readings: list[tuple[int, VirtualBoardReading]] = []
        self._overlays = 0

    def add(self, frame: int, reading: VirtualBoardReading, pair: AlignedPair | None = None) -> None:
        """Add a frame's reading; of the first frames with windows, what was seen is drawn over the pictures at once.

        Parameters
        ----------
        frame : int
            Number of the frame.
        reading : VirtualBoardReading
        pair : AlignedPair or None
            Views, edges and board of the frame.
        """
        self._readings.append((frame, reading))
        if pair is not None and reading.windows_total and self._overlays < OVERLAY_FRAMES:
            self._overlays += 1
            write_overlays(self._folder, frame, pair, reading)

    def write(self) -> None:
        """Draw `windows_NNNNNN.png` of up to eight frames, `frames.png` and `alignment.png`."""
        if not self._readings:
            return
        with_windows = [pair for pair in self._readings if pair[1].windows_kept]
        count = min(WINDOW_PLOTS, len(with_windows))
        for place in range(count):
            self._windows(*with_windows[place * len(with_windows) // count])
        self._frames()
        self._alignment()

    def _windows(self, frame: int, reading: VirtualBoardReading) -> None:
        """Diameter per window with tolerance band and one Sigma, like figure 3.28 of the dissertation."""
        figure = self._new_figure(figsize=(9, 4.5), layout="constrained")
        axes = figure.subplots()
        number = np.arange(1, reading.windows_total + 1)
        kept = reading.window_kept
        axes.axhspan(
            reading.diameter_mm - TOLERANCE_BAND_MM, reading.diameter_mm + TOLERANCE_BAND_MM,
            color="tab:green", alpha=0.12, label=f"frame's diameter ± {TOLERANCE_BAND_MM:g} mm",
        )  # fmt: skip
        axes.plot(number, reading.window_diameters_mm, color="tab:blue", linewidth=0.8)
        axes.plot(number[kept], reading.window_diameters_mm[kept], "o", color="tab:blue", ms=4, label="window, kept")
        axes.plot(number[~kept], reading.window_diameters_mm[~kept], "x", color="tab:red", label="window, discarded")
        trust = axes.twinx()
        trust.fill_between(
            number, -reading.window_sigmas_mm, reading.window_sigmas_mm, color="tab:orange", alpha=0.3, label="± Sigma"
        )
        largest = float(np.nanmax(reading.window_sigmas_mm))
        trust.set(ylabel="Sigma, mm", ylim=(-4 * largest, 4 * largest))
        axes.set(xlabel="window along the bar", ylabel="diameter, mm")
        axes.set_title(f"frame {frame}: {reading.diameter_mm:.2f} mm, Sigma {reading.weighted_deviation_mm:.3f} mm")
        handles = [*axes.get_legend_handles_labels()[0], *trust.get_legend_handles_labels()[0]]
        axes.legend(handles=handles, loc="best", fontsize="small")
        self._save(figure, f"windows_{frame:06d}.png")

    def _frames(self) -> None:
        """Diameter per frame with one standard deviation of its windows, like figure 3.29."""
        figure = self._new_figure(figsize=(9, 4.5), layout="constrained")
        axes = figure.subplots()
        frame = [number for number, _ in self._readings]
        diameter_mm = np.array([reading.diameter_mm for _, reading in self._readings])
        spread_mm = np.array([_spread_mm(reading) for _, reading in self._readings])
        axes.errorbar(frame, diameter_mm, yerr=spread_mm, fmt="o", ms=3, capsize=2, label="diameter ± sigma of windows")
        mark_frames(axes, [number for number, reading in self._readings if not reading.valid])
        axes.set(xlabel="frame", ylabel="diameter, mm", title="Route V, frame by frame; red: no value")
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
        self._save(figure, "frames.png")

    def _alignment(self) -> None:
        """Q_R and the board's height over frames, like figures 4.8 and 4.9."""
        figure = self._new_figure(figsize=(9, 5.5), layout="constrained")
        quality, height = figure.subplots(2, 1, sharex=True)
        frame = [number for number, _ in self._readings]
        quality.plot(frame, [abs(reading.alignment_quality) for _, reading in self._readings], "o-", ms=3)
        quality.set(ylabel="|Q_R|, percent", title="Virtual board, frame by frame")
        height.plot(frame, [reading.plane_height_mm for _, reading in self._readings], "o-", ms=3, color="tab:green")
        height.set(xlabel="frame", ylabel="height of the board, mm")
        for axes in (quality, height):
            axes.grid(alpha=0.3)
        self._save(figure, "alignment.png")


def _spread_mm(reading: VirtualBoardReading) -> float:
    return float(np.std(reading.window_diameters_mm[reading.window_kept])) if reading.valid else math.nan
