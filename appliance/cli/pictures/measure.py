"""The command measure, and the table of the classes that run its methods."""

import argparse
from pathlib import Path

from appliance.cli.outputs import (
    refuse_lost_input,
    refuse_other_formats,
    refuse_plots_among_inputs,
    refuse_unwritable,
)
from appliance.cli.pictures.archive import add_archive, run_archive
from appliance.command_options import CommandError
from appliance.conformity.row_judge import row_judge
from appliance.conformity.set_points import SetPoints
from appliance.sizing.conveyor.measuring import ConveyorMeasuring
from appliance.sizing.measuring import Measuring
from appliance.sizing.stereo.measuring import StereoMeasuring
from appliance.supervisor import settings as settings_file

ROOMS: tuple[Measuring, ...] = (StereoMeasuring(), ConveyorMeasuring())
ARCHIVE_SUFFIX = ".parquet"
ROOM_BY_METHOD = {name: room for room in ROOMS for name in room.names}


def add_measure(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "recording", type=Path, metavar="RECORDING", help="folder with its pictures, or with recordings in it"
    )
    command.add_argument("--rig", type=Path, help="from `hotgauge calibrate`; conveyor has none, a black box its own")
    command.add_argument(
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="CSV if it ends in .csv, .parquet for a folder of recordings, else JSON lines",
    )
    command.add_argument(
        "--method", choices=tuple(ROOM_BY_METHOD), default="tangent", help="; ".join(room.text for room in ROOMS)
    )
    for room in ROOMS:
        room.add_options(command)
    add_archive(command)
    command.add_argument("--plot", type=Path, metavar="DIR", help="folder for plots")
    command.add_argument(
        "--config", type=Path, metavar="FILE", help="settings whose target and tolerances the readings are judged by"
    )


def run_measure(given: argparse.Namespace) -> int | None:
    is_archive = given.output.suffix.lower() == ARCHIVE_SUFFIX
    _refuse_others(given, ROOM_BY_METHOD[given.method])
    if not is_archive:
        refuse_other_formats(given.output)
        if given.processes or given.dask:
            raise CommandError("--processes, --dask: these measure a folder of recordings; give --output FILE.parquet")
    inputs = given.recording, given.rig, given.background, given.config, given.edge_model
    refuse_lost_input(given.output, inputs)
    refuse_unwritable(given.output)
    refuse_plots_among_inputs(given.plot, (given.recording,))
    try:
        if is_archive:
            return run_archive(given, measure_recording)
        print("\n".join([*measure_recording(given), f"written to {given.output}"]))
    except OSError as error:
        path = error.filename or given.output
        raise CommandError(f"{path}: {error.strerror}; give a place in a writable folder") from error
    return None


def measure_recording(given: argparse.Namespace) -> list[str]:
    """Measure a single recording, with the scale that is given or with the one that it brings; lines of a summary."""
    from appliance.sizing.measure_black_box import measure_black_box
    from appliance.sizing.recorded_settings import brings_settings

    if given.rig is None and brings_settings(given.recording):
        _refuse_beside_own_settings(given)
        return measure_black_box(given.recording, given.output)
    room = ROOM_BY_METHOD[given.method]
    settings = settings_file.load(given.config)
    if given.config is not None and given.ovality is None and "ovality" in room.options and given.method == "tangent":
        given.ovality = settings.sizing.ovality_mm
    judge = row_judge(SetPoints.from_settings(settings.sizing.set_points), settings.judging)
    return room.run(given, judge)


def _refuse_beside_own_settings(given: argparse.Namespace) -> None:
    """Raise `CommandError` for an option that a recording of the black box, measured as it was served, ignores."""
    for option in (*(option for room in ROOMS for option in room.options), "config", "plot"):
        if getattr(given, option) is not None:
            words = f"--{option.replace('_', '-')}"
            raise CommandError(
                f"{words}: {given.recording} is measured with its own settings; leave it out, or give --rig"
            )


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
