"""The command fuse."""

import argparse
from pathlib import Path

from appliance.cli.common import whole_number
from appliance.cli.outputs import refuse_lost_input, refuse_plots_among_inputs, refuse_unwritable
from appliance.command_options import CommandError, one_of


def add_fuse(command: argparse.ArgumentParser) -> None:
    command.add_argument("left", type=Path, metavar="LEFT", help="picture of the left camera")
    command.add_argument("right", type=Path, metavar="RIGHT", help="picture of the right camera, of the same moment")
    command.add_argument("--rig", type=Path, required=True, help="calibration from `hotgauge calibrate`")
    command.add_argument("--output", type=Path, required=True, metavar="FILE", help="picture to write, PNG or JPEG")
    command.add_argument("--method", default="fft", metavar="NAME", help="how; fft unless given")
    command.add_argument(
        "--height", type=float, metavar="MM", help="plane of alignment; without: where the bar's outlines agree"
    )
    command.add_argument(
        "--as-printed",
        action="store_true",
        help="fft as algorithm 14 prints it, and FMI, SCD and ESSIM as eq. 5.6 to 5.9 do, too",
    )
    command.add_argument(
        "--plot", type=Path, metavar="DIR", help="folder for both aligned views, the pair in two colours, and edges"
    )
    command.add_argument(
        "--slope",
        type=float,
        nargs=2,
        default=(0.0, 0.0),
        metavar=("ACROSS", "ALONG"),
        help="rise of that plane in x and y, mm per m, where the line is not parallel to the boards; 0 0 unless given",
    )
    scales = command.add_argument_group("of wavelets and the pyramid")
    scales.add_argument("--levels", type=whole_number, metavar="N", help="4 unless given")
    scales.add_argument("--rule", choices=("larger", "weighted"), help="of two details; larger unless given")
    scales.add_argument("--approximation", choices=("average", "larger"), help="of what is left; average unless given")


def run_fuse(given: argparse.Namespace) -> None:
    from appliance.sizing.stereo.fuse_files import (
        Plane,
        checked_scales,
        fuse_files,
        metric_lines,
        write_picture,
        write_plots,
    )
    from vision.fusion.methods import METHODS

    refuse_lost_input(given.output, (given.left, given.right, given.rig))
    refuse_unwritable(given.output)
    refuse_plots_among_inputs(given.plot, (given.left, given.right))
    method = one_of(METHODS, given.method, "--method")
    try:
        scales = checked_scales(method, given.levels, given.rule, given.approximation)
        across, along = (rise / 1000 for rise in given.slope)
        plane = Plane(given.height, (across, along))
        pair = fuse_files(
            given.left, given.right, given.rig, method, scales=scales, plane=plane, periodic=given.as_printed
        )
        write_picture(given.output, pair.picture)
        if given.plot is not None:
            write_plots(given.plot, pair)
    except OSError as error:
        place = error.filename or given.output
        raise CommandError(f"{place}: {error.strerror}; give a file in a writable folder") from error
    print(f"{method}, aligned on the plane {pair.height_mm:.2f} mm above the conveyor")
    rows, columns = pair.common
    print(
        f"both cameras see {100 * pair.seen_share:.0f} % of the left view; metrics of columns {columns.start} to "
        f"{columns.stop - 1}, rows {rows.start} to {rows.stop - 1}"
    )
    print("\n".join([*metric_lines(pair, as_printed=given.as_printed), f"written to {given.output}"]))
