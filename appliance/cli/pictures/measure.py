"""The command measure, and the table of the classes that run its methods."""

import argparse
from pathlib import Path

from appliance.cli.outputs import refuse_lost_input, refuse_other_formats, refuse_unwritable
from appliance.command_options import CommandError
from appliance.conformity.row_judge import row_judge
from appliance.conformity.set_points import SetPoints
from appliance.sizing.conveyor.measuring import ConveyorMeasuring
from appliance.sizing.measuring import Measuring
from appliance.sizing.stereo.measuring import StereoMeasuring
from appliance.supervisor import settings as settings_file

ROOMS: tuple[Measuring, ...] = (StereoMeasuring(), ConveyorMeasuring())
ROOM_BY_METHOD = {name: room for room in ROOMS for name in room.names}


def add_measure(command: argparse.ArgumentParser) -> None:
    command.add_argument("recording", type=Path, metavar="RECORDING", help="folder with its pictures")
    command.add_argument("--rig", type=Path, help="calibration from `hotgauge calibrate`; conveyor has none")
    command.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="readings; CSV if it ends in .csv, else JSON lines"
    )
    command.add_argument(
        "--method", choices=tuple(ROOM_BY_METHOD), default="tangent", help="; ".join(room.text for room in ROOMS)
    )
    for room in ROOMS:
        room.add_options(command)
    command.add_argument("--plot", type=Path, metavar="DIR", help="folder for plots")
    command.add_argument(
        "--config", type=Path, metavar="FILE", help="settings whose target and tolerances the readings are judged by"
    )


def run_measure(given: argparse.Namespace) -> None:
    room = ROOM_BY_METHOD[given.method]
    _refuse_others(given, room)
    refuse_other_formats(given.output)
    inputs = given.recording, given.rig, given.background, given.config, given.edge_model
    refuse_lost_input(given.output, inputs)
    refuse_unwritable(given.output)
    settings = settings_file.load(given.config)
    if given.config is not None and given.ovality is None and "ovality" in room.options and given.method == "tangent":
        given.ovality = settings.sizing.ovality_mm
    judge = row_judge(SetPoints.from_settings(settings.sizing.set_points), settings.judging)
    try:
        print("\n".join([*room.run(given, judge), f"written to {given.output}"]))
    except OSError as error:
        path = error.filename or given.output
        raise CommandError(f"{path}: {error.strerror}; give a place in a writable folder") from error


def _refuse_others(given: argparse.Namespace, room: Measuring) -> None:
    """Raise `CommandError` for an option that does not apply to the method."""
    for other in ROOMS:
        for option in other.options:
            if option in room.options or getattr(given, option) is None:
                continue
            words = f"--{option.replace('_', '-')}"
            if len(other.names) == 1:
                raise CommandError(f"{words}: only {other.names[0]} has it; add --method {other.names[0]}")
            raise CommandError(f"{words}: the {given.method} method has none; leave it out")
