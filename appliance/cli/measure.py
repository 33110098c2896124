"""Commands that read pictures: calibrate, measure, orient, fuse."""

import argparse
import math
from pathlib import Path

from appliance.cli.common import CommandError, one_of


def add_measure(command: argparse.ArgumentParser) -> None:
    command.add_argument("recording", type=Path, metavar="RECORDING", help="folder with its pictures")
    command.add_argument("--rig", type=Path, help="calibration from `hotgauge calibrate`; conveyor has none")
    command.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="readings; CSV if it ends in .csv, else JSON lines"
    )
    command.add_argument(
        "--method",
        choices=("tangent", "virtual-board", "conveyor"),
        default="tangent",
        help="tangent unless given; virtual-board is the dissertation's, alone; conveyor has one uncalibrated camera",
    )
    command.add_argument("--edges", metavar="NAME", help="edge detector of virtual-board, forest unless given")
    command.add_argument("--fusion", metavar="NAME", help="views of virtual-board in one picture, none unless given")
    command.add_argument("--plot", type=Path, metavar="DIR", help="folder for plots of virtual-board or conveyor")
    conveyor = command.add_argument_group("of conveyor, whose ruler are two barriers along the line")
    conveyor.add_argument("--barrier-mm", type=float, metavar="W", help="between their inner faces")
    conveyor.add_argument("--barrier-height-mm", type=float, metavar="H", help="of their upper edges; better with it")
    conveyor.add_argument("--camera-height-mm", type=float, metavar="Z", help="over the conveyor; better with it")
    conveyor.add_argument("--background", type=Path, metavar="FILE", help="the empty line; else the darkest frames are")
    conveyor.add_argument("--compensation-mm", type=float, metavar="MM", help="added to every diameter; 0 unless given")


_OF_CONVEYOR = ("barrier_mm", "barrier_height_mm", "camera_height_mm", "background", "compensation_mm")


def _run_conveyor(given: argparse.Namespace) -> None:
    from appliance.cameras.source import CameraError
    from appliance.sizing.conveyor.empty_line import EmptyLineError
    from appliance.sizing.conveyor.measure_recording import measure_conveyor
    from appliance.sizing.figures import PlotsMissingError
    from vision.sizing.conveyor.camera_view import ConveyorReference

    for option in ("rig", "edges", "fusion"):
        if getattr(given, option) is not None:
            raise CommandError(f"--{option}: the conveyor method has none; leave it out")
    if given.barrier_mm is None:
        raise CommandError("--barrier-mm: the distance of the barriers' inner faces is the ruler; give it in mm")
    if not math.isfinite(given.compensation_mm or 0.0):
        raise CommandError(f"--compensation-mm: {given.compensation_mm} is no number of millimetres")
    try:
        reference = ConveyorReference(given.barrier_mm, given.barrier_height_mm, given.camera_height_mm)
    except ValueError as error:
        raise CommandError(f"--barrier-mm, --barrier-height-mm, --camera-height-mm: {error}") from error
    try:
        measure_conveyor(
            given.recording,
            given.output,
            reference,
            background=given.background,
            compensation_mm=given.compensation_mm or 0.0,
            plots=given.plot,
        )
    except (CameraError, EmptyLineError, PlotsMissingError) as error:
        raise CommandError(str(error)) from error


def run_measure(given: argparse.Namespace) -> None:
    try:
        if given.method == "conveyor":
            _run_conveyor(given)
        else:
            _run_stereo(given)
    except OSError as error:
        path = error.filename or given.output
        raise CommandError(f"{path}: {error.strerror}; give a place in a writable folder") from error


def _run_stereo(given: argparse.Namespace) -> None:
    from appliance.cameras.source import CameraError
    from appliance.sizing.figures import PlotsMissingError
    from appliance.sizing.stereo.measure_recording import measure_recording
    from appliance.sizing.stereo.rig_file import RigError
    from vision.edges.operators import EDGE_METHODS
    from vision.sizing.virtual_board.gauge import FUSIONS

    for option in _OF_CONVEYOR:
        if getattr(given, option) is not None:
            raise CommandError(f"--{option.replace('_', '-')}: only conveyor has it; add --method conveyor")
    if given.rig is None:
        raise CommandError("--rig: the rig file of these cameras is missing; make it with hotgauge calibrate")
    for option in ("edges", "fusion", "plot"):
        if given.method == "tangent" and getattr(given, option) is not None:
            raise CommandError(f"--{option}: only virtual boards have it; add --method virtual-board")
    edges = one_of(EDGE_METHODS, given.edges or "forest", "--edges")
    fusion = one_of(FUSIONS, given.fusion or "none", "--fusion")
    try:
        measure_recording(
            given.recording,
            given.rig,
            given.output,
            method=given.method,
            edges=edges,
            fusion=fusion,
            plots=given.plot,
        )
    except (CameraError, RigError, PlotsMissingError) as error:
        raise CommandError(str(error)) from error
