"""A verification from the recording to its certificate and its row in the history."""

import argparse
import importlib.metadata
import importlib.resources
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from appliance.command_options import CommandError
from appliance.files.digest import file_sha256
from appliance.reports.pages import library, render, write_pages
from appliance.verification.check import READINGS_ENOUGH, Master, Verification, verify
from appliance.verification.keep import earlier_errors, keep
from appliance.verification.measure import read_master


def verify_recording(given: argparse.Namespace, history: Path | None, show: Callable[[int, int], None]) -> Verification:
    """Measure the master, judge, keep the outcome and write the certificate.

    Parameters
    ----------
    given : Namespace
        Options of `hotgauge verify`.
    history : Path or None
        Folder of the history; without one nothing is kept and no drift is known.
    show : callable
        Gets how many frames are done, of how many.

    Raises
    ------
    CommandError
        Too few readings have a value, or there is no permissible error.
    CameraError
        The recording cannot be read.
    RigError
        The rig cannot be used.
    HistoryError
        The history cannot be read or written.
    ReportMissingError
        The libraries of certificates are not installed.
    OSError
        The certificate cannot be written.
    """
    if not given.diameter:
        raise CommandError("--diameter: give the diameter of the master in mm")
    if given.output is not None:  # before minutes of measuring
        for name in ("jinja2", *(["weasyprint"] if given.output.suffix.lower() == ".pdf" else [])):
            library(name, given.output)
    rig_sha256 = file_sha256(given.rig)  # before it is read: one that is replaced meanwhile is not verified
    diameters, missing, mean_expanded_mm = read_master(given.recording, given.rig, show)
    if len(diameters) < READINGS_ENOUGH:
        words = f"{len(diameters)} readings with a value, {READINGS_ENOUGH} are needed"
        raise CommandError(f"{given.recording}: {words}; record the master for longer")
    master = Master(given.diameter, given.u)
    earlier = [] if history is None else earlier_errors(history)
    found = verify(diameters, missing, master, given.limit or mean_expanded_mm, earlier)
    when = datetime.now().astimezone()
    words = {
        "recording": str(given.recording),
        "rig": str(given.rig),
        "rig_sha256": rig_sha256,
        "who": given.who,
    }
    if given.output is not None:
        template = importlib.resources.files("appliance.verification").joinpath("certificate.html")
        version = importlib.metadata.version("hotgauge")
        text = template.read_text(encoding="utf-8")
        values: dict[str, object] = {"found": found, "when": when, "version": version, **words}
        write_pages(render(text, given.output, values=values), given.output)
    if history is not None:
        keep(found, when, words, history)
    return found
