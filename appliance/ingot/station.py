"""The process of the ingot station: settings in, then source -> reader -> follower -> link until the link closes.

The supervisor runs it as `python -m appliance.ingot.station DESCRIPTOR`; see `appliance.processes.station_process`.
"""

import logging
import threading
import time
from functools import partial

import cv2
import numpy as np
from pydantic import TypeAdapter

from appliance.black_box.black_box import BlackBox
from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.source import CameraError, EndOfRecording, Frame
from appliance.files.row_writer import Row
from appliance.ingot.frame_rows import frame_row
from appliance.ingot.learned_references import LearnedReferencesError
from appliance.ingot.learning import Learning
from appliance.ingot.reader_setup import ReferencesError, load_view, make_reader
from appliance.ingot.reporter import IngotReporter
from appliance.ingot.settings import IngotSettings
from appliance.processes.link import StationLink
from appliance.processes.message import KeepPictures, StateMessage
from appliance.processes.preview import Line, Lines, PreviewWriter
from appliance.processes.station_process import fault, report_rejected, serve
from vision.ingot.orientation_reader import IngotView, OrientationReader
from vision.readings import OrientationReading

PICTURE_TIMEOUT_S = 0.2  # chosen
RETRY_PAUSE_S = 1.0  # chosen: pause after equipment trouble

logger = logging.getLogger("hotgauge.ingot")


def main() -> None:
    """Read pictures until the supervisor closes the link or dies."""
    serve(TypeAdapter(IngotSettings), run)


def run(settings: IngotSettings, link: StationLink, closed: threading.Event) -> None:
    """Read pictures until `closed`; equipment trouble is reported, and reading starts again after RETRY_PAUSE_S.

    Parameters
    ----------
    settings : IngotSettings
    link : StationLink
    closed : threading.Event
        Set when the link is closed.
    """
    black_box = BlackBox(settings.black_box, "ingot")
    link.on_line = lambda line: black_box.keep(KeepPictures.model_validate_json(line).why)
    try:
        _read_until(settings, link, closed, black_box)
    finally:
        black_box.close()


def _read_until(settings: IngotSettings, link: StationLink, closed: threading.Event, black_box: BlackBox) -> None:
    ingots = IngotReporter(settings)
    while not closed.is_set():
        try:
            _read(settings, ingots, link, closed, black_box)
        except EndOfRecording as error:
            while not closed.wait(RETRY_PAUSE_S):
                link.send(fault("recording_over", str(error)))
        except CameraError as error:
            link.send(fault(error.fault, str(error)))
        except ReferencesError as error:
            link.send(fault("references_unusable", str(error)))
        closed.wait(RETRY_PAUSE_S)


def _read(
    settings: IngotSettings, ingots: IngotReporter, link: StationLink, closed: threading.Event, black_box: BlackBox
) -> None:
    source = settings.camera.make_source()
    view = _view(settings)
    black_box.files = _recorded_settings(settings, view)
    learning = _learning(settings)
    preview = PreviewWriter("ingot")
    reader: OrientationReader | None = None
    with source:
        link.send(StateMessage(state="starting"))
        liveness = Liveness(settings.liveness, time.monotonic(), numbered=source.simulated)
        while not closed.is_set():
            frame = source.next(PICTURE_TIMEOUT_S)
            verdict = liveness.judge(frame and Exposure.from_source(frame), time.monotonic())
            if frame is None or not verdict.counts:
                report_rejected(verdict, link, opens_again=not source.simulated)
                continue
            reader = reader or make_reader(settings, view, frame.picture)
            started_s = time.perf_counter()
            reading = reader.read(frame.picture)
            elapsed_ms = 1000 * (time.perf_counter() - started_s)
            black_box.add(frame, partial(_rows, frame.sequence, reading))
            preview.offer([frame.picture], partial(_lines, reading), _figures(reading, frame))
            message = ingots.report(frame, reading, elapsed_ms, dropped=link.dropped, simulated=source.simulated)
            link.send(message.model_copy(update={"faults": verdict.faults, "not_kept": black_box.trouble}))
            try:
                if learning is not None and learning.add(frame.sequence, frame.picture, reading, ingots.current):
                    view, reader = _view(settings), None
                    black_box.files = _recorded_settings(settings, view)
            except OSError as error:  # a full disk costs what could be learned, not the readings
                learning = None
                logger.warning("references are not learned until the station starts again: %s", error)


def _learning(settings: IngotSettings) -> Learning | None:
    """What learns references; None where nothing is to be learned, the references have no folder, or it is damaged."""
    if not settings.learn or settings.references is None:
        return None
    try:
        return Learning(settings.references, settings, "agreement")
    except LearnedReferencesError as error:  # costs what could be learned, not the readings
        logger.warning("references are not learned until the station starts again: %s", error)
        return None


def _rows(number: int, reading: OrientationReading) -> list[Row]:
    return [frame_row(number, reading)]


def _recorded_settings(settings: IngotSettings, view: IngotView) -> dict[str, bytes]:
    """Settings and references in use, by path in a recording of the black box; read again by `hotgauge orient`."""
    files = {"settings.json": settings.model_dump_json(indent=1).encode()}
    if settings.references is not None:
        for name, picture in (("top", view.references.top), ("bottom", view.references.bottom)):
            files[f"references/{name}.png"] = cv2.imencode(".png", picture)[1].tobytes()
        regions = settings.references / "roi.json"
        if regions.is_file():
            files["references/roi.json"] = regions.read_bytes()
    return files


def _lines(reading: OrientationReading) -> Lines:
    turn = np.linspace(0, 2 * np.pi, 60)
    circle = np.column_stack([np.cos(turn), np.sin(turn)]) * reading.radius + (reading.center_x, reading.center_y)
    return [[Line("end", circle)]]


def _figures(reading: OrientationReading, frame: Frame) -> dict[str, float | None]:
    """What the page shows beside the picture."""
    return {
        "sequence": frame.sequence,
        "exposed_utc_ms": frame.exposed_utc_ms,
        "exposure_us": frame.exposure_us,
        "ssim_top": reading.ssim_top,
        "ssim_bottom": reading.ssim_bottom,
    }


def _view(settings: IngotSettings) -> IngotView:
    """References and regions from the folder of the settings, else the simulated camera's own."""
    if settings.references is not None:
        return load_view(settings.references)
    draw = settings.camera.own_ingot_view()
    if draw is None:
        raise ReferencesError("ingot.references is not set; give the folder with top.png and bottom.png")
    return draw()


if __name__ == "__main__":
    main()
