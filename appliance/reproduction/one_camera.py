"""Chapters 3.5 to 3.7: a bar of 265.5 mm before one calibrated optical camera (tables 3.2, 3.3, figures 3.28, 3.29)."""

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from appliance.reproduction.experiment import Case, Experiment, Plot, Result, Section, Table, number
from appliance.reproduction.sampling import rms_with_error, share
from appliance.reproduction.world import FULL, SMALL, calibrated, pair, passing
from appliance.simulation.bars.bars import Oxide
from vision.edges.operators import EdgeOptions
from vision.geometry.turned_region import picture_region
from vision.sizing.gauge import Gauge
from vision.sizing.virtual_board.boundaries_of_interest import boundaries_of_interest, hot_mask
from vision.sizing.virtual_board.one_camera import OneCameraGauge
from vision.sizing.virtual_board.parameters import PRINTED_PARAMETERS
from vision.sizing.virtual_board.random_regression import random_regression, two_sides, windowed
from vision.sizing.virtual_board.reading import AS_PRINTED
from vision.sizing.virtual_board.weighted_deviation import (
    similarity_ratio,
    trusted_windows,
    weighted_deviation,
    window_statistics,
)

DIAMETER_MM = 265.5
FRAMES, QUICK_FRAMES = 24, 4
CORRUPT_EVERY = 2  # every other frame has scale, which corrupts boundaries
TOLERANCE_MM = 3.0  # of the product, section 3.7
PRINTED_TIME_MS = (407, 38, 52)  # table 3.2
PRINTED_RMSE_MM = (0.9684, 1.0401, 1.5649, 7.5128)  # table 3.3
PRINTED_FRAMES_RMSE_MM = 0.5798  # of figure 3.29
WAYS = {
    "as printed": AS_PRINTED,
    "turned rows": replace(AS_PRINTED, turned_rows=True),
    "robust lines, half level": replace(AS_PRINTED, turned_rows=True, robust_lines=True, half_level=True),
}


class OneCamera(Experiment):
    """One camera on the plane of its board, as printed and corrected, beside both cameras as served."""

    name: ClassVar[str] = "one_camera"

    def cases(self, *, quick: bool) -> list[Case]:
        """One frame each."""
        size = SMALL if quick else FULL
        return [{"frame": frame, "size": list(size)} for frame in range(QUICK_FRAMES if quick else FRAMES)]

    def run(self, case: Case) -> Result:
        """Window and frame diameters of each way, the served reading, and times of algorithms 8, 9 and 10."""
        size = (case["size"][0], case["size"][1])
        _, rig = calibrated(size)
        oxide = Oxide(seed=case["frame"], part=0.1) if case["frame"] % CORRUPT_EVERY else None
        left, right = pair(passing(DIAMETER_MM, case["frame"], oxide=oxide), case["frame"], size)
        result: Result = {"corrupt": oxide is not None}
        for name, corrections in WAYS.items():
            reading = OneCameraGauge(rig, corrections=corrections).measure(left, right)
            windows = np.where(reading.window_kept, reading.window_diameters_mm, np.nan)
            result[name] = {
                "diameter_mm": reading.diameter_mm if reading.valid else None,
                "windows_mm": _numbers(reading.window_diameters_mm),
                "kept_mm": _numbers(windows),
                "sigmas_mm": _numbers(reading.window_sigmas_mm),
            }
        served = Gauge(rig).measure(left, right)
        result["served"] = [served.diameter_mm, served.expanded_uncertainty_mm] if served.valid else None
        result["time_ms"] = _times_ms(rig, left)
        return result

    def section(self, results: Sequence[tuple[Case, Result]]) -> Section:
        """Tables 3.2 and 3.3, figures 3.28 and 3.29."""
        found = [result for _, result in results]
        size = results[0][0]["size"]
        offset_mm = {name: _offset(found, name) for name in WAYS}
        return Section(
            "One calibrated camera on the plane of its board (chapters 3.5 to 3.7)",
            f"{len(found)} frames of {size[0]} x {size[1]}, every other one with patches of scale; a bar of "
            f"{DIAMETER_MM:g} mm. As the dissertation does, a fixed compensation (the mean error of the frames without "
            "scale) is taken off before table 3.3 and figure 3.29; it is stated beside them.",
            [_times(found), _windows(found, offset_mm), _frames(found, offset_mm)],
            [
                Plot(
                    "windows",
                    "Figure 3.28: windows of two frames, without and with scale",
                    partial(_figure, found=found, offset_mm=offset_mm),
                ),
                Plot("frames", "Figure 3.29: frames", partial(_figure_frames, found=found, offset_mm=offset_mm)),
            ],
            [
                (
                    "Times are the processor's, of this computer and of our own forest; the dissertation does not "
                    "give its hardware."
                ),
                (
                    f"On its board's plane one camera is off by {number(offset_mm['as printed'], '+.1f')} mm as "
                    "printed: the edges that it sees lie over the plane. The compensation holds for one diameter and "
                    "one place only."
                ),
                "Both cameras need none: the plane is found in every frame.",
                *(_tolerance(found, name, offset_mm[name]) for name in WAYS),
                _discarded(found, offset_mm["as printed"]),
            ],
        )


def _numbers(values: Any) -> list[float | None]:
    return [None if value != value else round(float(value), 4) for value in values]  # noqa: PLR0124  NaN


def _times_ms(rig: Any, picture: Any) -> list[float]:
    """Times of algorithms 8, 9 and 10 on one frame, as printed, the second time that they run."""
    region = picture_region(rig.left, picture, rig.region_y_mm)
    rows = PRINTED_PARAMETERS.window_rows
    windows = region.shape[0] // rows
    times: list[float] = []
    for _ in range(2):
        started = time.process_time()
        found = boundaries_of_interest(region.picture, hot_mask(region.picture), EdgeOptions(method="forest"))
        eighth = time.process_time()
        sides = two_sides(windowed(found.traced(), rows, windows))
        rng = np.random.default_rng(9)
        lines = [random_regression(side, 4, 10, rng) for side in sides]
        at = np.arange(windows * rows, dtype=np.float64).reshape(windows, rows)
        widths = (lines[1].at(at) - lines[0].at(at)).mean(axis=-1)
        ninth = time.process_time()
        _, sigma = window_statistics(widths)
        areas = found.band[: windows * rows].reshape(windows, -1).sum(axis=1, keepdims=True).astype(np.float64)
        trusted_windows(weighted_deviation(similarity_ratio(areas, max(1.0, float(np.median(areas)))), sigma))
        times = [1000 * (eighth - started), 1000 * (ninth - eighth), 1000 * (time.process_time() - ninth)]
    return times


def _offset(found: Sequence[Result], name: str) -> float:
    """The fixed compensation: mean error of the frames without scale."""
    values = [one[name]["diameter_mm"] for one in found if not one["corrupt"] and one[name]["diameter_mm"] is not None]
    return float(np.mean(values)) - DIAMETER_MM if values else float("nan")


def _times(found: Sequence[Result]) -> Table:
    ours = np.median([one["time_ms"] for one in found], axis=0)
    rows = [
        (f"algorithm {algorithm}", f"{printed}", number(float(measured), ".1f"))
        for algorithm, printed, measured in zip((8, 9, 10), PRINTED_TIME_MS, ours, strict=True)
    ]
    note = "The dissertation's pictures have 2,704 columns; the size of those here is said above."
    return Table("Table 3.2: time of a frame, ms", ("", "dissertation", "here, median"), rows, note)


def _window_errors(one: Result, name: str, offset_mm: float, which: str = "windows_mm") -> list[float | None]:
    return [None if value is None else value - DIAMETER_MM - offset_mm for value in one[name][which]]


def _windows(found: Sequence[Result], offset_mm: dict[str, float]) -> Table:
    """RMSE of the windows of frames: two without scale (a, b) and two with it (c, d)."""
    chosen = [one for one in found if not one["corrupt"]][:2] + [one for one in found if one["corrupt"]][:2]
    rows: list[tuple[str, ...]] = [("dissertation", *(number(value, ".2f") for value in PRINTED_RMSE_MM))]
    for name in WAYS:
        cells = [rms_with_error(_window_errors(one, name, offset_mm[name])) for one in chosen]
        rows.append((f"{name}, less {number(offset_mm[name], '+.1f')} mm", *cells, *("-",) * (4 - len(cells))))
    title = "Table 3.3: RMSE of a frame's windows, mm, ± as if windows were independent; c and d have scale"
    return Table(title, ("", "a", "b", "c", "d"), rows, "All windows count here, those too that are discarded later.")


def _frames(found: Sequence[Result], offset_mm: dict[str, float]) -> Table:
    """Frame by frame, after windows were discarded."""
    rows: list[tuple[str, ...]] = [("dissertation", "-", "-", number(PRINTED_FRAMES_RMSE_MM, ".2f"), "2.5")]
    for name in WAYS:
        values = [one[name]["diameter_mm"] for one in found]
        errors = [None if value is None else value - DIAMETER_MM - offset_mm[name] for value in values]
        there = [abs(error) for error in errors if error is not None]
        worst = max(there, default=float("nan"))
        count = f"{len(there)} of {len(found)}"
        rows.append((name, count, number(offset_mm[name], "+.2f"), rms_with_error(errors), number(worst, ".2f")))
    served = [float(one["served"][0]) - DIAMETER_MM for one in found if one["served"] is not None]
    worst = max((abs(error) for error in served), default=float("nan"))
    count = f"{len(served)} of {len(found)}"
    rows.append(("served, both cameras", count, "none", rms_with_error(served, ".3f"), number(worst)))
    columns = ("", "frames with a value", "compensation, mm", "RMSE, mm", "worst, mm")
    note = "The dissertation gives neither how many frames its figure shows nor the compensation."
    return Table("Figure 3.29: diameters of frames", columns, rows, note)


def _tolerance(found: Sequence[Result], name: str, offset_mm: float) -> str:
    """Share of the frames within the product's tolerance, which the dissertation says that all are."""
    values = [one[name]["diameter_mm"] for one in found if one[name]["diameter_mm"] is not None]
    inside = sum(abs(value - DIAMETER_MM - offset_mm) <= TOLERANCE_MM for value in values)
    said = "confirmed" if inside == len(values) else "contradicted"
    return f"Every frame lies within ± {TOLERANCE_MM:g} mm, {name}: {said}, {share(inside, len(values))}."


def _discarded(found: Sequence[Result], offset_mm: float) -> str:
    """Whether a jump of Sigma tells the windows that are off, as figure 3.28 says."""
    counts = {True: [0, 0], False: [0, 0]}  # of windows that are off, and of the others: discarded, all
    for one in found:
        errors, kept = _window_errors(one, "as printed", offset_mm), one["as printed"]["kept_mm"]
        for error, value in zip(errors, kept, strict=True):
            if error is not None:
                count = counts[abs(error) > TOLERANCE_MM]
                count[0] += value is None
                count[1] += 1
    return (
        f"A jump of Sigma tells windows that are off by more than {TOLERANCE_MM:g} mm: as printed it discards "
        f"{share(*counts[True])} of them, and {share(*counts[False])} of the others."
    )


def _figure(axes: Any, found: Sequence[Result], offset_mm: dict[str, float]) -> None:
    axes.axhspan(-3, 3, color="tab:green", alpha=0.12, label="tolerance ± 3 mm")
    for corrupt, colour in ((False, "tab:blue"), (True, "tab:red")):
        frames = [one for one in found if one["corrupt"] == corrupt]
        if frames:
            errors = _window_errors(frames[0], "as printed", offset_mm["as printed"])
            values = [np.nan if error is None else error for error in errors]
            label = "as printed, with scale" if corrupt else "as printed, without scale"
            axes.plot(range(1, len(values) + 1), values, ".-", color=colour, linewidth=0.8, label=label)
    axes.set_yscale("symlog", linthresh=TOLERANCE_MM)
    axes.set(xlabel="window along the bar", ylabel="compensated error, mm")


def _figure_frames(axes: Any, found: Sequence[Result], offset_mm: dict[str, float]) -> None:
    axes.axhspan(-3, 3, color="tab:green", alpha=0.12, label="tolerance ± 3 mm")
    for name in WAYS:
        values = [one[name]["diameter_mm"] for one in found]
        errors = [np.nan if value is None else value - DIAMETER_MM - offset_mm[name] for value in values]
        axes.plot(errors, "o", ms=4, label=name)
    served = [np.nan if one["served"] is None else one["served"][0] - DIAMETER_MM for one in found]
    axes.plot(served, "s", ms=4, color="black", label="served, both cameras")
    axes.set(xlabel="frame", ylabel="compensated error, mm")
