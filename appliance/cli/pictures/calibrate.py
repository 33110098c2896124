"""The command calibrate."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from appliance.cli.common import progress, refuse_no_region
from appliance.cli.outputs import refuse_lost_input, refuse_unwritable
from appliance.command_options import CommandError

if TYPE_CHECKING:
    from vision.calibration.stereo import Calibration

_BOARD_NUMBERS = ("square_mm", "square_u_mm", "low_mm", "high_mm", "height_u_mm")


def add_calibrate(command: argparse.ArgumentParser) -> None:
    command.add_argument("folder", type=Path, metavar="DIR", help="rig folder: pictures of the board, board.json")
    command.add_argument("--output", type=Path, required=True, metavar="FILE", help="rig file to write")
    command.add_argument("--report", type=Path, metavar="FILE", help="a report with pictures, .html or .pdf")
    region = command.add_argument("--region", type=float, nargs=2, default=(-250.0, 250.0), metavar=("FROM", "TO"))
    region.help = "measuring region along the rolling direction, mm; -250 250 unless given"
    board = command.add_argument_group("in place of what board.json says")
    board.add_argument("--squares", type=int, nargs=2, metavar=("LONG", "SHORT"))
    for name in _BOARD_NUMBERS:
        board.add_argument(f"--{name.replace('_', '-')}", type=float, metavar="MM")
    board.add_argument("--response", choices=("srgb", "linear", "gamma 2.2"))


def run_calibrate(given: argparse.Namespace) -> None:
    from appliance.sizing.stereo.calibrate_folder import calibrate_folder, report_lines
    from appliance.sizing.stereo.rig_file import save_rig
    from vision.calibration.acceptance import CalibrationError

    refuse_lost_input(given.output, (given.folder,))
    refuse_unwritable(given.output)
    if given.report is not None:
        _refuse_report(given.report, given.folder, given.output)
    refuse_no_region(given.region)
    board = {name: getattr(given, name) for name in ("squares", *_BOARD_NUMBERS, "response")}
    overrides = {name: value for name, value in board.items() if value is not None}
    try:
        with progress("picture pair") as show:
            calibration = calibrate_folder(given.folder, overrides, tuple(given.region), show)
        save_rig(calibration.rig, given.output)
    except CalibrationError as error:
        raise CommandError(str(error)) from error
    print("\n".join([*report_lines(calibration), f"written to    {given.output}"]))
    if given.report is not None:
        _write_report(given, overrides, calibration)
        print(f"report        {given.report}")


def _refuse_report(report: Path, folder: Path, rig: Path) -> None:
    from appliance.reports.calibration import check_libraries

    if report.suffix.lower() not in {".html", ".pdf"}:
        raise CommandError(f"--report {report}: give a name that ends in .html or .pdf")
    refuse_lost_input(report, (folder,), option="--report")
    refuse_unwritable(report, option="--report")
    if report.resolve() == rig.resolve():
        raise CommandError(f"--report: {report} is the rig file too; give another file")
    check_libraries(report)


def _write_report(given: argparse.Namespace, overrides: dict[str, object], calibration: "Calibration") -> None:
    from appliance.files.digest import file_sha256
    from appliance.reports.calibration import write_calibration_report
    from appliance.sizing.stereo.rig_folder import read_board
    from vision.calibration.stability import leave_one_out

    board = read_board(given.folder / "board.json", overrides)
    with progress("pose left out") as show:
        stability = leave_one_out(calibration, board, show)
    write_calibration_report(calibration, stability, given.folder, file_sha256(given.output), given.report)
