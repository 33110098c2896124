"""Commands that read pictures: calibrate, measure, orient, fuse."""

import argparse
import math
from pathlib import Path

from appliance import settings as settings_file
from appliance.commands.common import CommandError, add_config, one_of, progress, whole_number


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
    from appliance.empty_line import EmptyLineError
    from appliance.measure_conveyor import measure_conveyor
    from appliance.plots import PlotsMissingError
    from vision.calibration.conveyor_view import ConveyorReference

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
    from appliance.measure import measure_recording
    from appliance.plots import PlotsMissingError
    from appliance.rigs import RigError
    from vision.edges.operators import EDGE_METHODS
    from vision.sizing.virtual_board import FUSIONS

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


def add_orient(command: argparse.ArgumentParser) -> None:
    command.add_argument("recording", type=Path, metavar="RECORDING", help="folder with the pictures of one camera")
    command.add_argument(
        "--references", type=Path, required=True, metavar="DIR", help="folder with top.png, bottom.png, roi.json"
    )
    command.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="frames and ingots; CSV if it ends in .csv"
    )
    command.add_argument("--classifier", choices=("wrinkles", "dual", "single"), help="how one picture is judged")
    command.add_argument("--plot", type=Path, metavar="DIR", help="folder for annotated frames and a strip of the ends")
    add_config(command)


def run_orient(given: argparse.Namespace) -> None:
    from appliance.cameras.source import CameraError
    from appliance.orient import orient_recording
    from appliance.references import ReferencesError

    settings = settings_file.load(given.config).ingot
    if given.classifier:
        settings = settings.model_copy(update={"classifier": given.classifier})
    try:
        orient_recording(given.recording, given.references, given.output, settings, given.plot)
    except (CameraError, ReferencesError) as error:
        raise CommandError(str(error)) from error
    except OSError as error:
        place = error.filename or given.output
        raise CommandError(f"{place}: {error.strerror}; give a file in a writable folder") from error


_BOARD_NUMBERS = ("square_mm", "square_u_mm", "low_mm", "high_mm", "height_u_mm")


def add_calibrate(command: argparse.ArgumentParser) -> None:
    command.add_argument("folder", type=Path, metavar="DIR", help="rig folder: pictures of the board, board.json")
    command.add_argument("--output", type=Path, required=True, metavar="FILE", help="rig file to write")
    region = command.add_argument("--region", type=float, nargs=2, default=(-250.0, 250.0), metavar=("FROM", "TO"))
    region.help = "measuring region along the rolling direction, mm; -250 250 unless given"
    board = command.add_argument_group("in place of what board.json says")
    board.add_argument("--squares", type=int, nargs=2, metavar=("LONG", "SHORT"))
    for name in _BOARD_NUMBERS:
        board.add_argument(f"--{name.replace('_', '-')}", type=float, metavar="MM")
    board.add_argument("--response", choices=("srgb", "linear", "gamma 2.2"))


def run_calibrate(given: argparse.Namespace) -> None:
    from appliance.calibrate import calibrate_folder, report_lines
    from appliance.rigs import RigError, save_rig
    from vision.calibration.verdict import CalibrationError

    board = {name: getattr(given, name) for name in ("squares", *_BOARD_NUMBERS, "response")}
    overrides = {name: value for name, value in board.items() if value is not None}
    try:
        with progress("picture pair") as show:
            calibration = calibrate_folder(given.folder, overrides, tuple(given.region), show)
        save_rig(calibration.rig, given.output)
    except (CalibrationError, RigError) as error:
        raise CommandError(str(error)) from error
    print("\n".join([*report_lines(calibration), f"written to    {given.output}"]))


def add_fuse(command: argparse.ArgumentParser) -> None:
    command.add_argument("left", type=Path, metavar="LEFT", help="picture of the left camera")
    command.add_argument("right", type=Path, metavar="RIGHT", help="picture of the right camera, of the same moment")
    command.add_argument("--rig", type=Path, required=True, help="calibration from `hotgauge calibrate`")
    command.add_argument("--output", type=Path, required=True, metavar="FILE", help="picture to write, PNG or JPEG")
    command.add_argument("--method", default="fft", metavar="NAME", help="how; fft unless given")
    command.add_argument(
        "--height", type=float, metavar="MM", help="plane of alignment; without: where the bar's outlines agree"
    )
    scales = command.add_argument_group("of wavelets and the pyramid")
    scales.add_argument("--levels", type=whole_number, metavar="N", help="4 unless given")
    scales.add_argument("--rule", choices=("larger", "weighted"), help="of two details; larger unless given")
    scales.add_argument("--approximation", choices=("average", "larger"), help="of what is left; average unless given")


def run_fuse(given: argparse.Namespace) -> None:
    from appliance.cameras.source import CameraError
    from appliance.fuse import FusionError, checked_scales, fuse_files, metric_lines, write_picture
    from appliance.rigs import RigError
    from vision.fusion.methods import METHODS

    method = one_of(METHODS, given.method, "--method")
    try:
        scales = checked_scales(method, given.levels, given.rule, given.approximation)
        pair = fuse_files(given.left, given.right, given.rig, method, scales=scales, height_mm=given.height)
        write_picture(given.output, pair.picture)
    except (CameraError, RigError, FusionError) as error:
        raise CommandError(str(error)) from error
    except OSError as error:
        raise CommandError(f"{given.output}: {error.strerror}; give a file in a writable folder") from error
    print(f"{method}, aligned on the plane {pair.height_mm:.2f} mm above the conveyor")
    print("\n".join([*metric_lines(pair), f"written to {given.output}"]))
