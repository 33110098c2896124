"""The command `measure` with calibrated cameras: by both routes, by virtual boards alone, or with one camera."""

import argparse
import contextlib
import math
from typing import ClassVar

from appliance.command_options import CommandError, number_within
from appliance.sizing.measuring import Measuring
from appliance.sizing.reading_rows import Judge
from appliance.sizing.stereo.route_options import PRINTED_OPTIONS, add_route_options

MOST_TILT_DEG = 10.0  # as the setting sizing.board_tilt_deg allows
MOST_OVALITY_MM = 20.0  # as the setting sizing.ovality_mm allows
OWN_OPTIONS = {
    "tangent": frozenset({"ovality", "plot", "board_tilt"}),
    "virtual-board": frozenset({*PRINTED_OPTIONS, "fusion", "plot", "board_tilt"}),
    "one-camera": frozenset({*PRINTED_OPTIONS, "side", "plane_mm", "plot"}),
}


class StereoMeasuring(Measuring):
    """Measures by tangent planes checked by virtual boards, by virtual boards alone, or with one of the cameras."""

    names: ClassVar[tuple[str, ...]] = tuple(OWN_OPTIONS)
    text: ClassVar[str] = (
        "tangent unless given; virtual-board and one-camera (on the plane of its board) are the dissertation's, alone"
    )
    options: ClassVar[tuple[str, ...]] = (
        "rig",
        "plot",
        *PRINTED_OPTIONS,
        "fusion",
        "side",
        "plane_mm",
        "ovality",
        "board_tilt",
    )

    def add_options(self, command: argparse.ArgumentParser) -> None:
        """Declare edge detector, fusion, and the dissertation's ways and numbers."""
        add_route_options(command)
        command.add_argument(
            "--ovality", type=_length, metavar="MM", help="greatest minus least width of a section; 0.6 %% unless given"
        )
        command.add_argument(
            "--fusion", metavar="NAME", help="views of virtual-board in one picture, none unless given"
        )
        command.add_argument(
            "--board-tilt",
            type=_tilt,
            metavar="DEG",
            help="rise of the line along y against the registration boards, or fitted: from the bars themselves",
        )
        command.add_argument("--side", metavar="SIDE", help="camera of one-camera: left unless given, or right")
        command.add_argument(
            "--plane-mm", type=float, metavar="MM", help="height of one-camera's plane; else that of the low board"
        )

    def run(self, given: argparse.Namespace, judge: Judge) -> list[str]:
        """Measure with the rig file; see `Measuring.run`."""
        from appliance.sizing.stereo.measure_recording import measure_recording
        from appliance.sizing.stereo.route_choice import gauge_of

        if given.rig is None:
            raise CommandError("--rig: the rig file of these cameras is missing; make it with hotgauge calibrate")
        if given.method != "tangent" and given.ovality is not None:
            raise CommandError(f"--ovality: {given.method} has no part for it; leave it out")
        if given.board_tilt is not None and given.method == "one-camera":
            raise CommandError("--board-tilt: one-camera has its own plane; leave it out")
        for option in OWN_OPTIONS["virtual-board"] | OWN_OPTIONS["one-camera"]:
            if option not in OWN_OPTIONS[given.method] and getattr(given, option) is not None:
                others = [name for name, own in OWN_OPTIONS.items() if option in own]
                who = "only virtual boards have it" if "virtual-board" in others else "only one camera has it"
                raise CommandError(f"--{option.replace('_', '-')}: {who}; add --method {others[0]}")
        make = gauge_of(given)
        tilt_deg = given.board_tilt if given.board_tilt is not None else 0.0
        return measure_recording(
            given.recording, given.rig, given.output, make, judge=judge, plots=given.plot, tilt_deg=tilt_deg
        )


def _tilt(text: str) -> float:
    if text == "fitted":
        return math.nan
    with contextlib.suppress(ValueError):
        if abs(number := float(text)) <= MOST_TILT_DEG:
            return number
    wanted = f"degrees from -{MOST_TILT_DEG:g} to {MOST_TILT_DEG:g}"
    raise argparse.ArgumentTypeError(f"{text!r} is neither {wanted} nor fitted")


def _length(text: str) -> float:
    return number_within(text, 0, MOST_OVALITY_MM, "millimetres")
