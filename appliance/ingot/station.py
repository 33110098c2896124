"""The process of the ingot station: settings in, then source -> reader -> follower -> link until the link closes.

The supervisor runs it as `python -m appliance.stations.ingot DESCRIPTOR`; see `appliance.stations.process`.
"""

import threading
import time

from pydantic import TypeAdapter

from appliance.cameras.kinds import NoCamera, PictureCamera
from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.oak.settings import OakPictures
from appliance.cameras.recording.pictures import PictureRecordingSource
from appliance.cameras.recording.settings import RecordedPictures
from appliance.cameras.simulated.ingots import IngotMillSource
from appliance.cameras.simulated.settings import MillPictures
from appliance.cameras.source import CameraError, EndOfRecording, PictureSource
from appliance.cameras.stream.settings import StreamPictures
from appliance.cameras.stream.source import StreamPictureSource
from appliance.ingot.reader_setup import IngotView, ReferencesError, load_view, make_reader
from appliance.ingot.reporter import IngotReporter
from appliance.ingot.settings import IngotSettings
from appliance.processes.link import StationLink
from appliance.processes.message import StateMessage
from appliance.processes.station_process import fault, oak, serve, tell_lost
from vision.ingot.end_finder import Box
from vision.ingot.orientation_reader import OrientationReader, References

PICTURE_TIMEOUT_S = 0.2
PAUSE_S = 1.0


def main() -> None:
    """Read pictures until the supervisor closes the link, or is gone."""
    serve(TypeAdapter(IngotSettings), run)


def run(settings: IngotSettings, link: StationLink, closed: threading.Event) -> None:
    """Read pictures until `closed`; equipment trouble is reported and tried again after a pause.

    Parameters
    ----------
    settings : IngotSettings
    link : StationLink
    closed : threading.Event
        Set when nobody listens any more.
    """
    ingots = IngotReporter(settings)
    while not closed.is_set():
        try:
            _read(settings, ingots, link, closed)
        except EndOfRecording as error:
            while not closed.wait(PAUSE_S):
                link.send(fault("recording_over", str(error)))
        except CameraError as error:
            link.send(fault(error.fault, str(error)))
        except ReferencesError as error:
            link.send(fault("references_unusable", str(error)))
        closed.wait(PAUSE_S)


def _read(settings: IngotSettings, ingots: "IngotReporter", link: StationLink, closed: threading.Event) -> None:
    view = None if settings.references is None else load_view(settings.references)
    source = _source(settings.camera)
    if view is None and not isinstance(source, IngotMillSource):
        raise ReferencesError("ingot.references is not set; give the folder with top.png and bottom.png")
    reader: OrientationReader | None = None
    with source:
        link.send(StateMessage(state="starting"))
        liveness = Liveness(settings.liveness, time.monotonic(), numbered=source.simulated)
        while not closed.is_set():
            frame = source.next(PICTURE_TIMEOUT_S)
            verdict = liveness.look(frame and Exposure.of(frame), time.monotonic())
            if frame is None or not verdict.counts:
                tell_lost(verdict, link, opens_again=not source.simulated)
                continue
            reader = reader or make_reader(settings, view or _mill_view(source), frame.picture)
            started_s = time.perf_counter()
            reading = reader.read(frame.picture)
            elapsed_ms = 1000 * (time.perf_counter() - started_s)
            message = ingots.report(frame, reading, elapsed_ms, dropped=link.dropped, simulated=source.simulated)
            link.send(message.model_copy(update={"faults": verdict.faults}))


def _source(camera: PictureCamera) -> PictureSource:
    match camera:
        case RecordedPictures():
            return PictureRecordingSource(camera.path, rate_hz=camera.rate_hz, loop=camera.loop)
        case MillPictures():
            return IngotMillSource(camera.seed, camera.rate_hz)
        case StreamPictures():
            return StreamPictureSource(camera)
        case OakPictures():
            return oak().OakPictureSource(camera)
        case NoCamera():
            raise CameraError("ingot.camera.kind is off; give a camera")


def _mill_view(source: PictureSource) -> IngotView:
    assert isinstance(source, IngotMillSource)  # noqa: S101  without a folder of references there is no other
    pictures, line = source.references(), source.line
    return IngotView(References(pictures["top"], pictures["bottom"]), Box(*line.roi_crop()), Box(*line.roi_centroid()))


if __name__ == "__main__":
    main()
