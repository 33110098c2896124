"""The process of the ingot station: settings in, then source -> reader -> follower -> link until the link closes.

The supervisor runs it as `python -m appliance.stations.ingot DESCRIPTOR`; see `appliance.stations.process`.
"""

import collections
import math
import threading
import time

from pydantic import TypeAdapter

from appliance.camera_settings import (
    MillPictures,
    NoCamera,
    OakPictures,
    PictureCamera,
    RecordedPictures,
    StreamPictures,
)
from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.mill import IngotMillSource
from appliance.cameras.pacing import utc_ms
from appliance.cameras.picture_recording import PictureRecordingSource
from appliance.cameras.source import CameraError, EndOfRecording, Frame, PictureSource
from appliance.cameras.stream import StreamPictureSource
from appliance.ingot_settings import IngotSettings
from appliance.references import IngotView, ReferencesError, decision_rule, load_view, make_reader
from appliance.stations.link import IngotMessage, IngotVerdict, StateMessage, StationLink
from appliance.stations.process import fault, oak, serve, tell_lost
from vision.ingot.decision import IngotDecision, IngotFollower
from vision.ingot.end_face import Box
from vision.ingot.reader import OrientationReader, References
from vision.readings import OrientationReading

PICTURE_TIMEOUT_S = 0.2
PAUSE_S = 1.0
TOLD_AGAIN = 4  # ingots: more are not decided in the time of a few lost messages


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


class IngotReporter:
    """Follows the ingots of one camera and says what the supervisor must know.

    Parameters
    ----------
    settings : IngotSettings
    """

    def __init__(self, settings: IngotSettings) -> None:
        self._follower = IngotFollower(decision_rule(settings.decision))
        self._told: collections.deque[IngotVerdict] = collections.deque(maxlen=TOLD_AGAIN)

    def report(
        self, frame: Frame, reading: OrientationReading, elapsed_ms: float, *, dropped: int, simulated: bool
    ) -> IngotMessage:
        """What is said of one picture.

        Parameters
        ----------
        frame : Frame
        reading : OrientationReading
            Of that picture.
        elapsed_ms : float
            Time that reading took.
        dropped : int
            Messages discarded so far.
        simulated : bool
        """
        now_ms = utc_ms(time.monotonic())
        for decision in self._follower.take(frame.sequence, reading):
            self._told.append(_verdict(decision, now_ms))
        current = self._follower.current
        return IngotMessage(
            sequence=frame.sequence,
            exposed_monotonic_s=frame.exposed_monotonic_s,
            elapsed_ms=elapsed_ms,
            dropped=frame.dropped + dropped,
            simulated=simulated,
            present=reading.present,
            reasons=int(reading.reasons),
            ssim_top=_number(reading.ssim_top),
            ssim_bottom=_number(reading.ssim_bottom),
            current=None if current is None else _verdict(current, now_ms),
            told=tuple(self._told),
        )


def _verdict(decision: IngotDecision, now_ms: int) -> IngotVerdict:
    return IngotVerdict(
        ingot=decision.ingot,
        orientation=decision.orientation,
        confidence=decision.confidence,
        ssim_top=_number(decision.ssim_top),
        ssim_bottom=_number(decision.ssim_bottom),
        told_utc_ms=now_ms,
    )


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


if __name__ == "__main__":
    main()
