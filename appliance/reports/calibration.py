"""Writes the report of a calibration: what the pictures cover, how well they fit, and how much hangs on each."""

import importlib.resources
from datetime import datetime
from pathlib import Path

from appliance.reports import calibration_charts as charts
from appliance.reports.pages import data_address, library, render, write_pages
from appliance.sizing.stereo.calibrate_folder import response_in_words, verdict, world_in_words
from vision.calibration.rig import SIDES
from vision.calibration.stability import Stability
from vision.calibration.stereo import Calibration


def check_libraries(output: Path) -> None:
    """Raise `ReportMissingError`, before any work is done, where a library is missing."""
    for name in ("jinja2", "matplotlib", *(["weasyprint"] if output.suffix.lower() == ".pdf" else [])):
        library(name, output)


def write_calibration_report(
    calibration: Calibration, stability: Stability, folder: Path, rig_sha256: str, output: Path
) -> None:
    """Write the report; raises `OSError` and `ReportMissingError`.

    Parameters
    ----------
    calibration : Calibration
    stability : Stability
    folder : Path
        Rig folder that the pictures are from.
    rig_sha256 : str
        Of the rig file.
    output : Path
        PDF if its suffix is `.pdf`, else HTML.
    """
    measured = calibration.measured_response
    values = {
        "calibration": calibration,
        "rig": calibration.rig,
        "stability": stability,
        "measured": measured,
        "folder": folder,
        "rig_sha256": rig_sha256,
        "when": datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %Z"),
        "verdict": verdict(calibration),
        "world": world_in_words(calibration.rig),
        "response": response_in_words(calibration.rig),
        "poses": _poses(calibration),
        "coverage_chart": data_address(charts.coverage(calibration)),
        "residual_chart": data_address(charts.residuals(calibration)),
        "stability_chart": data_address(charts.stability(stability)),
        "response_chart": "" if measured is None else data_address(charts.response(calibration.rig, measured)),
    }
    text = importlib.resources.files("appliance.reports").joinpath("calibration.html").read_text(encoding="utf-8")
    write_pages(render(text, output, values), output)


def _poses(calibration: Calibration) -> dict[str, list[str]]:
    """Residual of the left and the right picture of each pose, or why it is not used, in words."""
    found = {picture.name: f"{picture.residual_px:.3f} px" for picture in calibration.pictures}
    found |= {drop.name: f"left out: {drop.reason}" for drop in calibration.dropped}
    boards = sorted({one.board for one in (*calibration.pictures, *calibration.dropped)})
    return {board: [found.get(f"{side}_{board}", "no picture") for side in SIDES] for board in boards}
