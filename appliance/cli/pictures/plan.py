"""The command plan: what a mounting of the two cameras would give, before anything is bought."""

import argparse
import contextlib
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

from appliance.cli.common import progress, refuse_no_region
from appliance.cli.outputs import refuse_unwritable
from appliance.command_options import CommandError

if TYPE_CHECKING:
    from appliance.planning.expected import Expected
    from appliance.planning.mounting import Mounting

SUFFIXES = {".png", ".pdf", ".svg"}
BASELINE_SHARE = 0.5  # chosen: of the distance, as the simulated mill's own rig


def add_plan(command: argparse.ArgumentParser) -> None:
    command.add_argument("--sensor", type=_sensor, required=True, metavar="COLUMNSxROWS", help="as 2448x2048")
    command.add_argument("--pixel-um", type=_positive, required=True, metavar="UM", help="side of a pixel")
    command.add_argument("--focal-mm", type=_positive, required=True, metavar="MM", help="focal length of the lenses")
    command.add_argument("--distance-m", type=_positive, required=True, metavar="M", help="from camera to bar")
    command.add_argument("--baseline-m", type=_positive, metavar="M", help="between the cameras; without: half of it")
    command.add_argument(
        "--elevation", type=_positive, default=55.0, metavar="DEG", help="of the view; 55 if not given"
    )
    command.add_argument("--f-number", type=_positive, default=8.0, metavar="N", help="8 if not given")
    command.add_argument("--exposure-us", type=_positive, default=500.0, metavar="US", help="500 if not given")
    command.add_argument("--speed", type=float, default=2.0, metavar="M/S", help="of the bar; 2 if not given")
    command.add_argument("--bars", type=_positive, nargs=2, default=(80.0, 250.0), metavar=("FROM", "TO"))
    command.add_argument("--ovality", type=float, metavar="MM", help="of the product; 0.6 %% of the bar unless given")
    command.add_argument("--region", type=float, nargs=2, default=(-250.0, 250.0), metavar=("FROM", "TO"))
    command.add_argument("--output", type=Path, metavar="FILE", help="picture of the mounting, .png, .pdf or .svg")


def run_plan(given: argparse.Namespace) -> None:
    from appliance.planning.expected import expected
    from appliance.sizing.figures import figure_class

    mounting = _mounting(given)
    if given.output is not None and given.output.suffix.lower() not in SUFFIXES:
        raise CommandError(f"--output {given.output}: give a name that ends in {', '.join(sorted(SUFFIXES))}")
    if given.output is not None:
        refuse_unwritable(given.output)
        figure_class()  # says at once that the plotting library is missing
    refuse_no_region(given.region)
    smallest, largest = given.bars
    if not smallest < largest:
        raise CommandError(f"--bars {smallest:g} {largest:g}: give the smallest diameter first")
    diameters = (smallest, (smallest + largest) / 2, largest)
    with progress("bar") as show:
        found = expected(mounting, diameters, tuple(given.region), given.ovality, show)
    print("\n".join([*_optics(mounting), "", *_table(found)]))
    if given.output is not None:
        from appliance.planning.drawing import draw_mounting

        try:
            draw_mounting(mounting, largest, tuple(given.region), given.output)
        except OSError as error:
            raise CommandError(f"{given.output}: {error.strerror}; give a place in a writable folder") from error
        print(f"\nwritten to      {given.output}")


def _mounting(given: argparse.Namespace) -> "Mounting":
    from appliance.planning.mounting import Mounting

    columns, rows = given.sensor
    distance_mm = 1000 * given.distance_m
    baseline_mm = BASELINE_SHARE * distance_mm if given.baseline_m is None else 1000 * given.baseline_m
    if not distance_mm > 2 * given.focal_mm:
        raise CommandError(f"--distance-m {given.distance_m:g}: not far enough for a lens of {given.focal_mm:g} mm")
    if not baseline_mm < 1.2 * distance_mm:
        raise CommandError(f"--baseline-m {baseline_mm / 1000:g}: give less than 1.2 times the distance")
    if not given.elevation < 90 or not given.speed >= 0 or not (given.ovality or 0.0) >= 0:
        raise CommandError("--elevation, --speed, --ovality: give an angle below 90 degrees, and nothing below 0")
    return Mounting(
        columns,
        rows,
        given.pixel_um,
        given.focal_mm,
        given.f_number,
        distance_mm,
        baseline_mm,
        given.elevation,
        given.exposure_us,
        given.speed,
    )


def _optics(mounting: "Mounting") -> list[str]:
    near_mm, far_mm = mounting.depth_of_field_mm
    width_mm, height_mm = mounting.view_mm
    longest = mounting.exposure_max_us
    return [
        f"pixel           {mounting.pixel_mm:.3f} mm at the bar",
        f"picture         {width_mm:.0f} x {height_mm:.0f} mm at the bar",
        f"baseline        {mounting.baseline_mm / 1000:.2f} m; the views are {mounting.angle_deg:.0f} degrees apart",
        f"sharp           from {near_mm / 1000:.2f} m to {_metres(far_mm)} at f/{mounting.f_number:g}, blur below 1 px",
        f"motion blur     {mounting.motion_blur_px:.2f} px along the line in {mounting.exposure_us:g} us",
        f"exposure        {_microseconds(longest)} for 1 px along the line at {mounting.speed_m_s:g} m/s",
    ]


def _metres(length_mm: float) -> str:
    return "infinity" if math.isinf(length_mm) else f"{length_mm / 1000:.2f} m"


def _microseconds(time_us: float) -> str:
    return "any" if math.isinf(time_us) else f"{time_us:.0f} us"


def _table(found: "list[Expected]") -> list[str]:
    from appliance.planning.expected import PARTS

    lines = ["expected on the simulated mill, mm (U: k = 2, parts: k = 1, error: here)"]
    lines.append(f"{'bar':>7} {'U':>7} {'error':>7}  " + " ".join(f"{part:>11}" for part in PARTS))
    for one in found:
        parts = " ".join(f"{one.parts_mm[part]:11.3f}" for part in PARTS)
        why = f"  {', '.join(one.reasons)}" if one.reasons else ""
        lines.append(f"{one.diameter_mm:7.1f} {one.expanded_mm:7.3f} {one.error_mm:+7.3f}  {parts}{why}")
    return lines


def _sensor(text: str) -> tuple[int, int]:
    numbers = re.fullmatch(r"(\d{1,5})\s*[xX×]\s*(\d{1,5})", text.strip())
    columns, rows = map(int, numbers.groups()) if numbers else (0, 0)
    if not (64 <= columns <= 20000 and 64 <= rows <= 20000):
        raise argparse.ArgumentTypeError(f"{text!r} is no sensor; give it as 2448x2048, 64 to 20000 pixels each")
    return columns, rows


def _positive(text: str) -> float:
    with contextlib.suppress(ValueError):
        number = float(text)
        if 0 < number < 1e6:
            return number
    raise argparse.ArgumentTypeError(f"{text!r} is no number above 0 and below 1000000")
