"""The command simulate."""

import argparse
from collections.abc import Callable
from pathlib import Path

from appliance.cli.common import positive_number, progress, whole_number
from appliance.command_options import CommandError

INGOTS_SCENE = "ingots"  # also the prefix of scenes under a condition, as in ingots-glare


def add_simulate(command: argparse.ArgumentParser) -> None:
    command.add_argument("--output", type=Path, required=True, metavar="DIR", help="new folder for the recording")
    command.add_argument(
        "--scene",
        default="line",
        metavar="NAME",
        help="line (bars passing), a condition such as clean, thermal, ingots, or a condition of ingots such as "
        "ingots-glare",
    )
    command.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="NAME",
        help="added to a condition, such as ovality; repeatable",
    )
    command.add_argument("--seed", type=whole_number, default=1, help="seed of all that is drawn, 1 unless given")
    command.add_argument("--frames", type=positive_number, default=50, help="frames, 50 unless given")


def run_simulate(given: argparse.Namespace) -> None:

    with progress("picture") as on_progress:
        if given.scene == "thermal":
            _write_thermal(given)
        elif given.scene.partition("-")[0] == INGOTS_SCENE:
            _write_ingots(given, on_progress)
        else:
            _write_stereo(given, on_progress)
    print(f"{given.output}: {given.frames} frames of the scene {given.scene}, with truth")
    if given.scene.partition("-")[0] == INGOTS_SCENE:
        print(f"  next: hotgauge orient {given.output}/seq01 --references {given.output} --output ends.jsonl")
    elif given.scene != "thermal":
        print(f"  next: hotgauge calibrate {given.output} --output rig.json")


def _write_thermal(given: argparse.Namespace) -> None:
    from appliance.simulation.thermal_line import random_thermal_line
    from appliance.simulation.write_recording import write_thermal_recording

    if given.effect:
        raise CommandError("--effect: a thermal scene has none; leave it out")
    write_thermal_recording(given.output, random_thermal_line(given.seed), frames=given.frames)


def _write_ingots(given: argparse.Namespace, on_progress: Callable[[int, int], None]) -> None:
    from appliance.simulation.ingots.conditions import INGOT_CONDITIONS
    from appliance.simulation.write_recording import write_ingots

    if given.effect:
        raise CommandError(f"--effect: a scene of ingots has none; give a condition as --scene {INGOTS_SCENE}-glare")
    names = [row.name for row in INGOT_CONDITIONS]
    condition = given.scene.removeprefix(INGOTS_SCENE).removeprefix("-") or names[0]
    if condition not in names:
        known = ", ".join(f"{INGOTS_SCENE}-{name}" for name in names)
        raise CommandError(f"--scene: no scene is called {given.scene!r}; scenes of ingots are {INGOTS_SCENE}, {known}")
    write_ingots(given.output, condition, given.seed, given.frames, on_progress=on_progress)


def _write_stereo(given: argparse.Namespace, on_progress: Callable[[int, int], None]) -> None:
    from appliance.simulation.bars.study_scenes import CONDITIONS
    from appliance.simulation.write_recording import write_line, write_scene

    if given.scene == "line" and not given.effect:
        write_line(given.output, given.seed, given.frames, on_progress=on_progress)
        return
    try:
        write_scene(given.output, given.scene, given.seed, given.frames, effects=given.effect, on_progress=on_progress)
    except ValueError as error:
        known = {
            kind: ", ".join(row.name for row in CONDITIONS if row.kind == kind) for kind in ("condition", "effect")
        }
        option, colon, reason = str(error).partition(": ")
        options = {"condition": "--scene", "effects": "--effect"}
        raise CommandError(
            f"{options.get(option, option)}{colon}{reason}; scenes are line, thermal, ingots and the conditions "
            f"{known['condition']}; effects are {known['effect']}"
        ) from error
