"""The command capture: pictures from the configured cameras."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from appliance.cameras.section import PairCamera
from appliance.cli.common import add_config, positive_number
from appliance.cli.pictures.board import squares
from appliance.command_options import CommandError
from appliance.sizing.conveyor.settings import ConveyorSettings
from appliance.supervisor import settings as settings_file

if TYPE_CHECKING:
    from appliance.capture.console import Console
    from appliance.supervisor.settings import Settings

HEIGHTS = ("low", "high")
ENDS = ("top", "bottom")


def add_capture(command: argparse.ArgumentParser) -> None:
    kinds = command.add_subparsers(metavar="WHAT", required=True)
    for name, (capture, text, add_arguments) in KINDS.items():
        kind = kinds.add_parser(name, help=text, description=f"{text}.")
        kind.set_defaults(capture=capture)
        add_arguments(kind)
        add_config(kind)


def run_capture(given: argparse.Namespace) -> None:
    from appliance.capture.console import Console

    given.capture(given, settings_file.load(given.config), Console(sys.stdout, sys.stdin))


def _add_folder(kind: argparse.ArgumentParser, text: str) -> None:
    kind.add_argument("--output", type=Path, required=True, metavar="DIR", help=text)


def _add_board(kind: argparse.ArgumentParser) -> None:
    _add_folder(kind, "rig folder, for `hotgauge calibrate`; what it holds already stays")
    kind.add_argument("--squares", type=squares, metavar="8x5", help="squares of the board, unless board.json says so")
    kind.add_argument("--mm", type=float, metavar="MM", help="side of a square as you measured it on the print")
    kind.add_argument("--u-mm", type=float, metavar="MM", help="its standard uncertainty, if you know it")


def _add_boards(kind: argparse.ArgumentParser) -> None:
    _add_board(kind)
    kind.add_argument("--poses", type=positive_number, default=15, metavar="N", help="15 unless given")
    kind.add_argument("--within", type=float, default=900.0, metavar="S", help="longest time; 900 unless given")


def _add_registration(kind: argparse.ArgumentParser) -> None:
    _add_board(kind)
    kind.add_argument("--height", choices=HEIGHTS, help="take this one now; without: both, each when you press Enter")
    for name in HEIGHTS:
        kind.add_argument(f"--{name}-mm", type=float, metavar="MM", help=f"{name} board's face above the rollers")
    kind.add_argument("--height-u-mm", type=float, metavar="MM", help="standard uncertainty of both")


def _add_references(kind: argparse.ArgumentParser) -> None:
    _add_folder(kind, "folder for top.png, bottom.png and roi.json")
    kind.add_argument("--end", choices=ENDS, help="take this one now; without: both, each when you press Enter")


def _add_background(kind: argparse.ArgumentParser) -> None:
    kind.add_argument("--output", type=Path, required=True, metavar="FILE.png", help="for sizing.conveyor.background")


def _add_recording(kind: argparse.ArgumentParser) -> None:
    _add_folder(kind, "new folder for the recording")
    kind.add_argument("--seconds", type=float, default=10.0, metavar="N", help="10 unless given")
    kind.add_argument("--station", choices=("sizing", "ingot"), default="sizing", help="whose camera; sizing's")


def _boards(given: argparse.Namespace, settings: "Settings", console: "Console") -> None:
    from appliance.capture.boards.board_file import board_of
    from appliance.capture.boards.judged_pairs import JudgedPairs
    from appliance.capture.boards.poses import Poses
    from appliance.capture.boards.take import capture_boards

    camera = _pair_camera(settings)
    board = board_of(given.output, _told(given))
    poses = Poses(given.output, board, given.poses)
    console.say(f"{given.output}: {poses.number} of {given.poses} poses; Ctrl-C ends it sooner")
    console.say("hold the board still before both cameras, then elsewhere: tilted, near, far,")
    console.say("and in the corners of the pictures")
    pairs = JudgedPairs(camera.make_source(settings.sizing.liveness.apart_max_us), settings.sizing.liveness, board)
    try:
        capture_boards(pairs, poses, given.within, console)
    except KeyboardInterrupt:
        console.say("stopped")
    console.say(f"{given.output}: {poses.number} of {given.poses} poses, missing: {poses.lacking() or 'nothing'}")
    for line in poses.unseen():
        console.say(f"  {line}")
    console.say(f"  next: hotgauge capture registration --output {given.output}")


def _registration(given: argparse.Namespace, settings: "Settings", console: "Console") -> None:
    from appliance.capture.boards.board_file import board_of
    from appliance.capture.boards.judged_pairs import JudgedPairs
    from appliance.capture.boards.take import capture_registration

    camera = _pair_camera(settings)
    told = _told(given) | {f"{name}_mm": getattr(given, f"{name}_mm") for name in HEIGHTS}
    board = board_of(given.output, told | {"height_u_mm": given.height_u_mm})
    for height in (given.height,) if given.height else HEIGHTS:
        if not given.height:
            place = "on the rollers" if height == "low" else "at a known height above"
            console.wait_for_enter(f"lay the board flat {place}, in the middle of the measuring region")
        source = camera.make_source(settings.sizing.liveness.apart_max_us)
        capture_registration(JudgedPairs(source, settings.sizing.liveness, board), given.output, height, console)
    console.say(f"  next: hotgauge calibrate {given.output} --output rig.json")


def _background(given: argparse.Namespace, settings: "Settings", console: "Console") -> None:
    from appliance.capture.empty_line import capture_empty_line

    if not isinstance(settings.sizing, ConveyorSettings):
        raise CommandError("only the conveyor method needs the empty line; set sizing.method and sizing.conveyor")
    if given.output.suffix.lower() != ".png":
        raise CommandError(f"--output {given.output}: give a name that ends in .png")
    capture_empty_line(settings.sizing, given.output, console)


def _references(given: argparse.Namespace, settings: "Settings", console: "Console") -> None:
    from appliance.capture.references import capture_references

    if not settings.ingot.camera.is_on:
        raise CommandError("ingot.camera is off; set it to the camera that sees the ingots' ends")
    ends = (given.end,) if given.end else ENDS
    capture_references(settings.ingot, given.output, ends, console, asks=not given.end)
    console.say(f"  next: set ingot.references = {str(given.output)!r}")


def _recording(given: argparse.Namespace, settings: "Settings", console: "Console") -> None:
    from appliance.capture.recording import LOST_MOST_SHARE, record

    if not 0 < given.seconds <= 86400:
        raise CommandError(f"--seconds {given.seconds:g}: give a time above 0, at most 86400 (a day)")
    if given.station == "ingot":
        source, liveness = settings.ingot.camera.make_source(), settings.ingot.liveness
    else:
        source, liveness = settings.sizing.make_source(), settings.sizing.liveness
    done = record(source, liveness, given.output, given.seconds, console)
    console.say(f"{given.output}: {done.frames} frames of {done.size[0]} x {done.size[1]} pixels, {done.lost} lost")
    if done.lost > LOST_MOST_SHARE * (done.frames + done.lost):
        console.say("  the computer or its disk is too slow for this; lower the camera's rate_hz")


def _pair_camera(settings: "Settings") -> PairCamera:
    camera = settings.sizing.camera
    if not isinstance(camera, PairCamera):
        raise CommandError(
            f"sizing.camera is {camera.in_words}; boards are for two cameras, with sizing.method tangent"
        )
    return camera


def _told(given: argparse.Namespace) -> dict[str, object]:
    long_and_short = None if given.squares is None else list(given.squares)
    return {"squares": long_and_short, "square_mm": given.mm, "square_u_mm": given.u_mm}


KINDS = {
    "boards": (_boards, "Poses of the checkerboard, for calibrating two cameras", _add_boards),
    "registration": (_registration, "The board flat at two heights: it fixes the world frame", _add_registration),
    "background": (_background, "The line without a bar, for one camera between barriers", _add_background),
    "references": (_references, "Both ends of an ingot, as the ingot camera sees them", _add_references),
    "recording": (_recording, "What the cameras send, without loss, for so many seconds", _add_recording),
}
