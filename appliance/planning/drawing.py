"""The picture of a planned mounting: seen along the line, and from the side."""

import math
from pathlib import Path
from typing import Any

from appliance.planning.mounting import AIM_HEIGHT_MM, Mounting
from appliance.sizing.figures import figure_class, save_figure

LABEL_ROOM_M = 0.7  # chosen: beside the cameras, for their names
AIM_M = AIM_HEIGHT_MM / 1000
CAMERA_COLOUR, BAR_COLOUR = "#0072b2", "#e69f00"


def draw_mounting(mounting: Mounting, largest_mm: float, region_y_mm: tuple[float, float], output: Path) -> None:
    """Write the picture of a mounting.

    Parameters
    ----------
    mounting : Mounting
    largest_mm : float
        Diameter of the largest bar.
    region_y_mm : tuple of float
        Measuring region along the line.
    output : Path
        PNG, PDF or SVG, by its suffix.

    Raises
    ------
    PlotsMissingError
        Matplotlib is not installed.
    OSError
        The file cannot be written.
    """
    save_figure(mounting_figure(mounting, largest_mm, region_y_mm), output)


def mounting_figure(mounting: Mounting, largest_mm: float, region_y_mm: tuple[float, float]) -> Any:
    """Figure of a mounting, lengths in m: seen along the line at the left, from the side at the right.

    Parameters
    ----------
    mounting : Mounting
    largest_mm : float
    region_y_mm : tuple of float
        As for `draw_mounting`.
    """
    figure = figure_class()(figsize=(10, 5), layout="constrained")
    across, along = figure.subplots(1, 2)
    _draw_along_the_line(across, mounting, largest_mm)
    _draw_from_the_side(along, mounting, largest_mm, region_y_mm)
    for axes in (across, along):
        axes.axhline(0, color="grey", linewidth=1)
        axes.set_aspect("equal")
        axes.grid(alpha=0.3)
        axes.legend(loc="upper left", bbox_to_anchor=(0, -0.14), frameon=False)
        axes.margins(0.12)
    half_m = mounting.baseline_mm / 2000
    across.set_xlim(-half_m - LABEL_ROOM_M, half_m + LABEL_ROOM_M)
    return figure


def _draw_along_the_line(axes: Any, mounting: Mounting, largest_mm: float) -> None:
    radius_m, baseline_m = largest_mm / 2000, mounting.baseline_mm / 1000
    for place_mm, name in zip(mounting.cameras_mm, ("left camera", "right camera"), strict=True):
        x_m, _, z_m = (one / 1000 for one in place_mm)
        axes.plot([x_m, 0], [z_m, AIM_M], "--", color=CAMERA_COLOUR, linewidth=1)
        axes.plot(x_m, z_m, "s", color=CAMERA_COLOUR, markersize=9)
        axes.annotate(name, (x_m, z_m), textcoords="offset points", xytext=(0, 9), ha="center")
    turn = [2 * math.pi * step / 60 for step in range(61)]
    axes.fill(
        [radius_m * math.cos(one) for one in turn],
        [radius_m + radius_m * math.sin(one) for one in turn],
        color=BAR_COLOUR,
        label=f"largest bar, {largest_mm:g} mm",
    )
    middle_m = mounting.cameras_mm[0][2] / 2000
    axes.annotate("", (-baseline_m / 2, middle_m), (baseline_m / 2, middle_m), arrowprops={"arrowstyle": "<->"})
    axes.annotate(f"baseline {baseline_m:.2f} m", (0, middle_m), ha="center", va="bottom")
    axes.set(title="Seen along the line", xlabel="across the line, m", ylabel="height over the rollers, m")


def _draw_from_the_side(axes: Any, mounting: Mounting, largest_mm: float, region_y_mm: tuple[float, float]) -> None:
    largest_m, (_, y_m, z_m) = largest_mm / 1000, (one / 1000 for one in mounting.cameras_mm[0])
    axes.plot([y_m, 0], [z_m, AIM_M], "--", color=CAMERA_COLOUR, linewidth=1, label="view of both cameras")
    axes.plot(y_m, z_m, "s", color=CAMERA_COLOUR, markersize=9)
    words = f"{mounting.distance_mm / 1000:.2f} m, {mounting.elevation_deg:g}°"
    axes.annotate(words, (0.55 * y_m, 0.5 * z_m), ha="right", va="top")
    begin_m, end_m = (one / 1000 for one in region_y_mm)
    axes.fill_between([begin_m - 0.5, end_m + 0.5], 0, largest_m, color=BAR_COLOUR, alpha=0.6, label="bar")
    axes.fill_between([begin_m, end_m], 0, largest_m, facecolor="none", edgecolor="black", label="measuring region")
    axes.set(title="Seen from the side", xlabel="along the line, m", ylabel="height over the rollers, m")
