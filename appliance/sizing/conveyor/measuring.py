"""The command `measure` with one uncalibrated camera over a conveyor between barriers."""

import argparse
import math
from pathlib import Path
from typing import ClassVar

from appliance.command_options import CommandError
from appliance.sizing.measuring import Measuring
from appliance.sizing.reading_rows import Judge


class ConveyorMeasuring(Measuring):
    """Measures by the known distance between two barriers along the line."""

    names: ClassVar[tuple[str, ...]] = ("conveyor",)
    text: ClassVar[str] = "conveyor has one uncalibrated camera"
    options: ClassVar[tuple[str, ...]] = (
        "plot", "barrier_mm", "barrier_height_mm", "camera_height_mm", "background", "compensation_mm",
        "barrier_lower_mm", "barriers", "response_exponent",
    )  # fmt: skip

    def add_options(self, command: argparse.ArgumentParser) -> None:
        """Declare the lengths of the line, its background and the compensation."""
        group = command.add_argument_group("of conveyor, whose ruler are two barriers along the line")
        group.add_argument("--barrier-mm", type=float, metavar="W", help="between their inner faces")
        group.add_argument("--barrier-height-mm", type=float, metavar="H", help="of their upper edges; better with it")
        group.add_argument("--camera-height-mm", type=float, metavar="Z", help="over the conveyor; better with it")
        group.add_argument(
            "--barrier-lower-mm",
            type=float,
            metavar="H",
            help="of their lower edges; 0: walls; else as the picture says",
        )
        group.add_argument(
            "--barriers", metavar="X1,X2", help="columns of their inner edges in the middle row, where others show"
        )
        group.add_argument(
            "--response-exponent",
            type=float,
            metavar="G",
            help="code values follow light to this power; 1: a linear camera; wide U unless given",
        )
        group.add_argument(
            "--background", type=Path, metavar="FILE", help="the empty line; else the darkest frames are"
        )
        group.add_argument(
            "--compensation-mm", type=float, metavar="MM", help="added to every diameter; 0 unless given"
        )

    def run(self, given: argparse.Namespace, judge: Judge) -> list[str]:
        """Measure with the barriers' distance as scale; see `Measuring.run`."""
        from appliance.sizing.conveyor.measure_recording import measure_conveyor
        from vision.sizing.conveyor.camera_view import ConveyorReference

        if given.barrier_mm is None:
            raise CommandError("--barrier-mm: the distance of the barriers' inner faces is the ruler; give it in mm")
        if not math.isfinite(given.compensation_mm or 0.0):
            raise CommandError(f"--compensation-mm: {given.compensation_mm} is no number of millimetres")
        try:
            reference = ConveyorReference(
                given.barrier_mm, given.barrier_height_mm, given.camera_height_mm, given.barrier_lower_mm
            )
        except ValueError as error:
            raise CommandError(
                f"--barrier-mm, --barrier-height-mm, --camera-height-mm, --barrier-lower-mm: {error}"
            ) from error
        exponent = given.response_exponent
        if exponent is not None and not 0 < exponent < math.inf:
            raise CommandError(f"--response-exponent: {exponent} is no number above 0")
        return measure_conveyor(
            given.recording,
            given.output,
            reference,
            judge=judge,
            background=given.background,
            compensation_mm=given.compensation_mm or 0.0,
            near_columns=_near_columns(given.barriers),
            response_exponent=exponent,
            plots=given.plot,
        )


def _near_columns(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    try:
        left, right = (float(part) for part in text.split(","))
    except ValueError as error:
        raise CommandError(f"--barriers: {text!r} is no pair of columns; give two numbers such as 250,376") from error
    if not left < right:
        raise CommandError(f"--barriers: {text!r}; give the left barrier's column first")
    return left, right
