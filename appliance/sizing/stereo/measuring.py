"""The command `measure` with two calibrated cameras: by both routes, or by virtual boards alone."""

import argparse
from typing import ClassVar

from appliance.command_options import CommandError, one_of
from appliance.sizing.measuring import Measuring
from appliance.sizing.reading_rows import Judge


class StereoMeasuring(Measuring):
    """Measures by tangent planes checked by virtual boards, or by virtual boards alone."""

    names: ClassVar[tuple[str, ...]] = ("tangent", "virtual-board")
    text: ClassVar[str] = "tangent unless given; virtual-board is the dissertation's, alone"
    options: ClassVar[tuple[str, ...]] = ("rig", "edges", "fusion", "plot")

    def add_options(self, command: argparse.ArgumentParser) -> None:
        """Declare edge detector and fusion of virtual boards."""
        command.add_argument("--edges", metavar="NAME", help="edge detector of virtual-board, forest unless given")
        command.add_argument(
            "--fusion", metavar="NAME", help="views of virtual-board in one picture, none unless given"
        )

    def run(self, given: argparse.Namespace, judge: Judge) -> list[str]:
        """Measure with the rig file; see `Measuring.run`."""
        from appliance.sizing.stereo.measure_recording import measure_recording
        from vision.edges.operators import EDGE_METHODS
        from vision.sizing.virtual_board.gauge import FUSIONS

        if given.rig is None:
            raise CommandError("--rig: the rig file of these cameras is missing; make it with hotgauge calibrate")
        for option in ("edges", "fusion", "plot"):
            if given.method == "tangent" and getattr(given, option) is not None:
                raise CommandError(f"--{option}: only virtual boards have it; add --method virtual-board")
        edges = one_of(EDGE_METHODS, given.edges or "forest", "--edges")
        fusion = one_of(FUSIONS, given.fusion or "none", "--fusion")
        return measure_recording(
            given.recording,
            given.rig,
            given.output,
            judge=judge,
            method=given.method,
            edges=edges,
            fusion=fusion,
            plots=given.plot,
        )
