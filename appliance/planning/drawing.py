"""The picture of a planned mounting: seen along the line, and from the side."""

import math
from pathlib import Path

from appliance.files.atomic_file import whole_place
from appliance.planning.mounting import Mounting
from appliance.sizing.figures import DOTS_PER_INCH, figure_class

LABEL_ROOM_M = 0.7  # chosen: beside the cameras, for their names


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
    figure = figure_class()(figsize=(10, 5), layout="constrained")
    across, along = figure.subplots(1, 2)
    reach_m = math.sqrt(mounting.distance_mm**2 - mounting.baseline_mm**2 / 4) / 1000
    elevation = math.radians(mounting.elevation_deg)
    y_m, z_m = -reach_m * math.cos(elevation), reach_m * math.sin(elevation)
    half_m, radius_m = mounting.baseline_mm / 2000, largest_mm / 2000
    for side, name in ((-half_m, "left camera"), (half_m, "right camera")):
        across.plot([side, 0], [z_m, radius_m], "--", color="#0072b2", linewidth=1)
        across.plot(side, z_m, "s", color="#0072b2", markersize=9)
        across.annotate(name, (side, z_m), textcoords="offset points", xytext=(0, 9), ha="center")
    turn = [2 * math.pi * step / 60 for step in range(61)]
    across.fill(
        [radius_m * math.cos(one) for one in turn],
        [radius_m + radius_m * math.sin(one) for one in turn],
        color="#e69f00",
        label=f"largest bar, {largest_mm:g} mm",
    )
    across.annotate("", (-half_m, z_m / 2), (half_m, z_m / 2), arrowprops={"arrowstyle": "<->"})
    across.annotate(f"baseline {2 * half_m:.2f} m", (0, z_m / 2), ha="center", va="bottom")
    across.set(title="Seen along the line", xlabel="across the line, m", ylabel="height over the rollers, m")
    along.plot([y_m, 0], [z_m, radius_m], "--", color="#0072b2", linewidth=1, label="view of both cameras")
    along.plot(y_m, z_m, "s", color="#0072b2", markersize=9)
    along.annotate(
        f"{mounting.distance_mm / 1000:.2f} m, {mounting.elevation_deg:g}°",
        (0.55 * y_m, 0.5 * z_m),
        ha="right",
        va="top",
    )
    begin_m, end_m = (one / 1000 for one in region_y_mm)
    along.fill_between([begin_m - 0.5, end_m + 0.5], 0, 2 * radius_m, color="#e69f00", alpha=0.6, label="bar")
    along.fill_between([begin_m, end_m], 0, 2 * radius_m, facecolor="none", edgecolor="black", label="measuring region")
    along.set(title="Seen from the side", xlabel="along the line, m", ylabel="height over the rollers, m")
    for axes in (across, along):
        axes.axhline(0, color="grey", linewidth=1)
        axes.set_aspect("equal")
        axes.grid(alpha=0.3)
        axes.legend(loc="upper left", bbox_to_anchor=(0, -0.14), frameon=False)
        axes.margins(0.12)
    across.set_xlim(-half_m - LABEL_ROOM_M, half_m + LABEL_ROOM_M)
    with whole_place(output) as place:
        figure.savefig(place, dpi=DOTS_PER_INCH, format=output.suffix[1:].lower())
