"""Commands verify and gauge-study: the gauge against a bar of known diameter, and against itself."""

import argparse
import math
import sys
from pathlib import Path

from appliance.cli.common import add_config, progress
from appliance.cli.outputs import refuse_lost_input, refuse_unwritable
from appliance.command_options import CommandError, number_within
from appliance.files.digest import file_sha256
from appliance.supervisor import settings as settings_file

EXIT_NOT_PASSED = 1


def add_verify(command: argparse.ArgumentParser) -> None:
    command.add_argument("recording", type=Path, metavar="RECORDING", help="folder with pictures of the master bar")
    command.add_argument("--rig", type=Path, required=True, help="calibration from `hotgauge calibrate`")
    command.add_argument(
        "--diameter", type=_length, required=True, metavar="D", help="of the master as it lay there, mm"
    )
    command.add_argument("--u", type=_length, default=0.0, metavar="U", help="its expanded uncertainty (k = 2), mm")
    command.add_argument("--limit", type=_length, metavar="MM", help="permissible error; without: the readings' mean U")
    command.add_argument("--who", default="", metavar="NAME", help="who verified, for the certificate")
    command.add_argument("--output", type=Path, metavar="FILE", help="certificate, .pdf or .html")
    add_config(command)


def run_verify(given: argparse.Namespace) -> int | None:
    from appliance.verification.certificate import verify_recording

    if given.output is not None and given.output.suffix.lower() not in {".pdf", ".html"}:
        raise CommandError(f"--output {given.output}: give a name that ends in .pdf or .html")
    if given.output is not None:
        refuse_lost_input(given.output, (given.recording, given.rig, given.config))
        refuse_unwritable(given.output)
    folder = None if given.config is None else settings_file.load(given.config).history.directory
    try:
        found_with = file_sha256(given.rig)
        with progress("frame") as show:
            found = verify_recording(given, folder, show)
    except OSError as error:
        place = error.filename or given.output
        raise CommandError(f"{place}: {error.strerror}; give a place in a writable folder") from error
    lines = [
        f"calibration     SHA-256 {found_with}",
        f"master          {found.master.diameter_mm:.3f} mm, U {found.master.expanded_mm:.3f} mm",
        f"readings        {found.readings}, and {found.missing} without a value",
        f"error           {found.error_mm:+.3f} mm, U {found.test_expanded_mm:.3f} mm",
        f"repeatability   {found.repeatability_mm:.3f} mm (standard deviation of a reading)",
        f"drift           {'no earlier verification' if math.isnan(found.drift_mm) else f'{found.drift_mm:+.3f} mm'}",
        f"verdict         {found.verdict}: permissible error {found.limit_mm:.3f} mm, ISO 14253-1",
    ]
    sys.stdout.write("\n".join(lines) + "\n")
    return None if found.verdict == "pass" else EXIT_NOT_PASSED


def _length(text: str) -> float:
    return number_within(text, 0, 10_000, "millimetres")


def add_gauge_study(command: argparse.ArgumentParser) -> None:
    columns = "CSV with the columns bar, condition (a place, a day) and diameter_mm"
    command.add_argument("measurements", type=Path, metavar="FILE", help=columns)
    command.add_argument("--tolerance", type=_length, metavar="MM", help="whole width of the tolerance")


def run_gauge_study(given: argparse.Namespace) -> None:
    from appliance.verification.gauge_study import gauge_study, read_cells

    found = gauge_study(read_cells(given.measurements))
    lines = [
        f"{found.bars} bars, {found.conditions} conditions, {found.trials} trials; standard deviations, AIAG MSA",
        f"repeatability    EV   {found.repeatability_mm:.4f} mm",
        f"reproducibility  AV   {found.reproducibility_mm:.4f} mm",
        f"gauge            GRR  {found.gauge_mm:.4f} mm, {found.percent_of_variation:.1f} % of the variation",
        f"bars             PV   {found.bars_mm:.4f} mm",
        f"distinct categories   {found.categories}",
    ]
    if given.tolerance:
        lines.append(f"of the tolerance      {found.percent_of_tolerance(given.tolerance):.1f} % (6 GRR)")
    sys.stdout.write("\n".join(lines) + "\n")
