"""The measuring process of the sizing station: settings in, then source -> gauge -> link until the link closes.

The supervisor runs it as `python -m appliance.stations.sizing DESCRIPTOR`; see `appliance.stations.process`.
"""

import contextlib
import math
import threading
import time
from collections.abc import Callable, Generator
from functools import partial
from typing import Protocol, TypeAlias

from pydantic import TypeAdapter

from appliance.cameras.exposure_control import ExposureGuard
from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.oak.settings import OakCamera
from appliance.cameras.recording.pairs import RecordingSource
from appliance.cameras.recording.settings import RecordingCamera
from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.settings import MillCamera
from appliance.cameras.source import (
    Adjustable,
    CameraError,
    EndOfRecording,
    Frame,
    FramePair,
    PairSource,
    PictureSource,
)
from appliance.cameras.stream.settings import StreamCamera
from appliance.cameras.stream.source import StreamSource
from appliance.processes.link import StationLink
from appliance.processes.message import StateMessage
from appliance.processes.station_process import fault, oak, serve, tell_lost
from appliance.sizing.conveyor.empty_line import EmptyLineError
from appliance.sizing.conveyor.gauge import conveyor_gauge, conveyor_source
from appliance.sizing.conveyor.settings import ConveyorSettings
from appliance.sizing.message import ReadingMessage
from appliance.sizing.settings import Sizing
from appliance.sizing.stereo.gauge import TimedGauge
from appliance.sizing.stereo.rig_file import RigError, load_rig
from appliance.sizing.stereo.settings import SizingSettings
from appliance.sizing.stereo.simulated_rig import mill_rig
from vision.readings import SizeReading
from vision.sizing.gauge import Gauge

PAIR_TIMEOUT_S = 0.2
PAUSE_S = 1.0
WARM_UP_TIME_S = 120.0  # longest time that compiling may take, on a slow computer with nothing on its disk yet
WARMING_PERIOD_S = 2.0

AnySettings: TypeAlias = SizingSettings | ConveyorSettings
AnySource: TypeAlias = PairSource | PictureSource


class _TimedGauge(Protocol):
    """A gauge with its clock; `measure` takes the pictures of one exposure, left first."""

    @property
    def measure(self) -> Callable[..., tuple[SizeReading, float]]: ...

    def warm_up(self) -> None: ...


def main() -> None:
    """Measure until the supervisor closes the link, or is gone."""
    serve(TypeAdapter[AnySettings](Sizing), run)


def run(settings: AnySettings, link: StationLink, closed: threading.Event) -> None:
    """Measure until `closed`; equipment trouble is reported and tried again after a pause.

    Parameters
    ----------
    settings : SizingSettings or ConveyorSettings
    link : StationLink
    closed : threading.Event
        Set when nobody listens any more.
    """
    while not closed.is_set():
        try:
            _measure(settings, link, closed)
        except EndOfRecording as error:
            _stay_at_end(link, closed, str(error))
        except CameraError as error:
            link.send(fault(error.fault, str(error)))
        except RigError as error:
            link.send(fault("rig_unusable", str(error)))
        except EmptyLineError as error:
            link.send(fault("empty_line_unusable", str(error)))
        closed.wait(PAUSE_S)


def _measure(settings: AnySettings, link: StationLink, closed: threading.Event) -> None:
    source = source_of(settings)
    with _warming(link):
        gauge = _gauge(settings, source, link)
        gauge.warm_up()
    with source:
        liveness = Liveness(settings.liveness, time.monotonic(), numbered=source.simulated)
        guard = ExposureGuard(settings.exposure, adjustable=isinstance(source, Adjustable))
        while not closed.is_set():
            exposed = source.next(PAIR_TIMEOUT_S)
            exposure = exposed and Exposure.of(exposed)
            verdict = liveness.look(exposure, time.monotonic())
            if exposed is None or exposure is None or not verdict.counts:
                tell_lost(verdict, link, opens_again=not source.simulated)
                continue
            reading, elapsed_ms = gauge.measure(*exposed.pictures)
            message = to_message(
                reading, exposed, elapsed_ms, dropped=exposed.dropped + link.dropped, simulated=source.simulated
            )
            faults = verdict.faults | _exposure_faults(guard, reading, exposed, source) | _heat(settings, exposed)
            link.send(message.model_copy(update={"faults": faults}))


@contextlib.contextmanager
def _warming(link: StationLink) -> Generator[None]:
    """Tell the supervisor that code is compiled, but not for ever, since compiling might hang too."""
    warm = threading.Event()

    def tell() -> None:
        for _ in range(round(WARM_UP_TIME_S / WARMING_PERIOD_S)):
            link.send(StateMessage(state="warming"))
            if warm.wait(WARMING_PERIOD_S):
                return

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        warm.set()
        teller.join()


def _exposure_faults(
    guard: ExposureGuard, reading: SizeReading, exposed: FramePair | Frame, source: AnySource
) -> dict[str, str]:
    """Adjust the exposure where that is possible, and tell what is wrong with it where it is not."""
    advice = guard.look(reading.clipped_share, reading.limb_light, exposed.exposure_us, time.monotonic())
    if isinstance(source, Adjustable) and math.isfinite(advice.exposure_us):
        source.set_exposure(advice.exposure_us)
    return advice.faults


def _heat(settings: AnySettings, exposed: FramePair | Frame) -> dict[str, str]:
    if exposed.temperature_c > settings.camera_temperature_max_c:  # not so when it is not known
        return {"camera_hot": f"{exposed.temperature_c:.0f} °C, {settings.camera_temperature_max_c:g} °C at most"}
    return {}


def source_of(settings: AnySettings) -> AnySource:
    """The source of pictures that the settings name, not opened yet."""
    return conveyor_source(settings.camera) if isinstance(settings, ConveyorSettings) else _pair_source(settings)


def _pair_source(settings: SizingSettings) -> PairSource:
    camera = settings.camera
    match camera:
        case RecordingCamera():
            return RecordingSource(camera.path, rate_hz=camera.rate_hz, loop=camera.loop)
        case StreamCamera():
            return StreamSource(camera, settings.liveness.apart_max_us)
        case OakCamera():
            return oak().OakSource(camera, settings.liveness.apart_max_us)
        case MillCamera():
            return MillSource(camera.seed, camera.rate_hz, camera.prepared_frames)


def _gauge(settings: AnySettings, source: AnySource, link: StationLink) -> _TimedGauge:
    if isinstance(settings, ConveyorSettings):
        return conveyor_gauge(settings, source)
    gauge = partial(Gauge, ovality_mm=settings.ovality_mm)
    if settings.rig is not None:
        return TimedGauge[SizeReading](load_rig(settings.rig), str(settings.rig), gauge)
    if isinstance(source, MillSource):
        link.send(StateMessage(state="starting"))
        return TimedGauge[SizeReading](mill_rig(source), "rig of the simulated mill", gauge)
    raise RigError("sizing.rig is not set; make a rig file with `hotgauge calibrate` and set it")


def _stay_at_end(link: StationLink, closed: threading.Event, detail: str) -> None:
    while not closed.wait(PAUSE_S):
        link.send(fault("recording_over", detail))


def to_message(
    reading: SizeReading, exposed: FramePair | Frame, elapsed_ms: float, *, dropped: int, simulated: bool
) -> ReadingMessage:
    """What is said to the supervisor of one reading.

    Parameters
    ----------
    reading : SizeReading
    exposed : FramePair or Frame
        What was measured.
    elapsed_ms : float
        Time that measuring took.
    dropped : int
        Exposures and messages discarded so far.
    simulated : bool
    """
    return ReadingMessage(
        sequence=exposed.sequence,
        exposed_monotonic_s=exposed.exposed_monotonic_s,
        exposed_utc_ms=exposed.exposed_utc_ms,
        elapsed_ms=elapsed_ms,
        dropped=dropped,
        simulated=simulated,
        valid=reading.valid,
        reasons=int(reading.reasons),
        diameter_mm=_number(reading.diameter_mm),
        expanded_uncertainty_mm=_number(reading.expanded_uncertainty_mm),
        diameter_virtual_board_mm=_number(reading.diameter_virtual_board_mm),
        weighted_deviation_mm=_number(reading.weighted_deviation_mm),
        trust_limit=reading.trust_limit,
        windows_kept=reading.windows_kept,
        windows_total=reading.windows_total,
        alignment_quality=_number(reading.alignment_quality),
        plane_height_mm=_number(reading.plane_height_mm),
    )


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


if __name__ == "__main__":
    main()
