"""The measuring process of the sizing station: settings in, then source -> gauge -> link until the link closes.

The supervisor runs it as `python -m appliance.sizing.station DESCRIPTOR`; see `appliance.processes.station_process`.
"""

import contextlib
import math
import threading
import time
from collections.abc import Generator, Sequence
from functools import partial
from typing import NamedTuple

from pydantic import TypeAdapter

from appliance.black_box.black_box import BlackBox
from appliance.cameras.exposure_control import ExposureGuard
from appliance.cameras.liveness import Exposure, Liveness
from appliance.cameras.source import (
    Adjustable,
    CameraError,
    EndOfRecording,
    Frame,
    FramePair,
    PairSource,
    PictureSource,
)
from appliance.files.digest import file_sha256
from appliance.processes.link import StationLink
from appliance.processes.message import KeepPictures, StateMessage
from appliance.processes.preview import Picture, PreviewWriter
from appliance.processes.station_process import fault, report_rejected, serve
from appliance.sizing.exact_rows import exact_rows
from appliance.sizing.message import ReadingMessage
from appliance.sizing.method import ScaleError, SizingMethod, TimedReader
from appliance.sizing.recorded_settings import recorded_settings
from appliance.sizing.settings import Sizing
from vision.readings import SizeReading, of_all_bars
from vision.reasons import Reason
from vision.sizing.side_by_side import SideBySide

PAIR_TIMEOUT_S = 0.2  # chosen
RETRY_PAUSE_S = 1.0  # chosen: pause after equipment trouble
WARM_UP_TIME_S = 120.0  # longest compilation, on a slow computer without a cache (docs/decisions/0013)
WARMING_PERIOD_S = 2.0  # chosen; docs/decisions/0013


def main() -> None:
    """Measure until the supervisor closes the link or dies."""
    serve(TypeAdapter[SizingMethod](Sizing), run)


def run(settings: SizingMethod, link: StationLink, closed: threading.Event) -> None:
    """Measure until `closed`; equipment trouble is reported, and measuring starts again after RETRY_PAUSE_S.

    Parameters
    ----------
    settings : SizingMethod
    link : StationLink
    closed : threading.Event
        Set when the link is closed.
    """
    black_box = BlackBox(settings.black_box, "sizing")
    link.on_line = lambda line: black_box.keep(KeepPictures.model_validate_json(line).why)
    try:
        _measure_until(settings, link, closed, black_box)
    finally:
        black_box.close()


def _measure_until(settings: SizingMethod, link: StationLink, closed: threading.Event, black_box: BlackBox) -> None:
    ready: _Ready | None = None
    while not closed.is_set():
        try:
            source = settings.make_source()
            ready = ready or _ready_gauge(settings, link)
            black_box.files = recorded_settings(settings, ready.gauge)
            _measure(settings, source, ready, link, closed, black_box=black_box)
        except EndOfRecording as error:
            _stay_at_end(link, closed, str(error))
        except CameraError as error:
            link.send(fault(error.fault, str(error)))
        except ScaleError as error:
            ready = None
            link.send(fault(error.fault, str(error)))
        closed.wait(RETRY_PAUSE_S)


class _Ready(NamedTuple):
    """Gauge that has compiled, and the SHA-256 of the file that it was made from."""

    gauge: TimedReader
    scale_sha256: str


def _ready_gauge(settings: SizingMethod, link: StationLink) -> _Ready:
    """Gauge that has compiled; its rig is read once, so that one that is just being made waits for a reload."""
    with _warming(link):
        made = _made_gauge(settings, link)
        while file_sha256(settings.scale_file) != made.scale_sha256:  # replaced while it was read: which one is it?
            made = _made_gauge(settings, link)
        settings.check_adjustment(made.scale_sha256)
        made.gauge.warm_up()
    return made


def _made_gauge(settings: SizingMethod, link: StationLink) -> _Ready:
    scale_sha256 = file_sha256(settings.scale_file)
    return _Ready(settings.make_gauge(lambda: link.send(StateMessage(state="starting"))), scale_sha256)


def _measure(
    settings: SizingMethod,
    source: PairSource | PictureSource,
    ready: _Ready,
    link: StationLink,
    closed: threading.Event,
    *,
    black_box: BlackBox,
) -> None:
    gauge = ready.gauge
    preview = PreviewWriter("sizing")
    with source, settings.make_range_sensor() as laser:
        liveness = Liveness(settings.liveness, time.monotonic(), numbered=source.simulated)
        bars, stretch = SideBySide(), 0
        guard = ExposureGuard(settings.exposure, adjustable=isinstance(source, Adjustable))
        while not closed.is_set():
            newest = source.next(PAIR_TIMEOUT_S)
            exposed = newest and laser.beside(newest)
            exposure = exposed and Exposure.from_source(exposed)
            verdict = liveness.judge(exposure, time.monotonic())
            if exposed is None or exposure is None or not verdict.counts:
                report_rejected(verdict, link, opens_again=not source.simulated)
                continue
            carried = gauge.carried
            measured, elapsed_ms = gauge.measure_exposed(exposed)
            adjusted = tuple(settings.adjustment.adjusted(one) for one in measured)
            black_box.add(exposed, partial(exact_rows, exposed.sequence, adjusted, elapsed_ms), carried)
            if exposed.stretch != stretch:
                bars, stretch = SideBySide(), exposed.stretch
            readings = bars.add(adjusted, exposed.exposed_monotonic_s)
            message = to_message(
                readings,
                exposed,
                elapsed_ms,
                slots=bars.slots,
                dropped=exposed.dropped + link.dropped,
                simulated=source.simulated,
            )
            reading = message.reading
            preview.offer(_shown(exposed), partial(gauge.lines, reading), _figures(reading, exposed))
            faults = verdict.faults | _exposure_faults(guard, reading, exposed, source) | _heat(settings, exposed)
            faults |= laser.faults
            more = {"faults": faults, "not_kept": black_box.trouble, "adjustment_mm": _added_mm(settings, adjusted)}
            link.send(message.model_copy(update=more | {"scale_sha256": ready.scale_sha256}))


def _shown(exposed: FramePair | Frame) -> tuple[Picture, ...]:
    return (exposed.left, exposed.right) if isinstance(exposed, FramePair) else (exposed.picture,)


def _figures(reading: SizeReading, exposed: FramePair | Frame) -> dict[str, float | None]:
    """What the page shows beside the pictures."""
    return {
        "sequence": exposed.sequence,
        "exposed_utc_ms": exposed.exposed_utc_ms,
        "exposure_us": exposed.exposure_us,
        "limb_light": reading.limb_light,
        "clipped_share": reading.clipped_share,
        "diameter_mm": reading.diameter_mm,
        "windows_kept": reading.windows_kept,
        "windows_total": reading.windows_total,
        "alignment_quality": reading.alignment_quality,
        "plane_height_mm": reading.plane_height_mm,
    }


@contextlib.contextmanager
def _warming(link: StationLink) -> Generator[None]:
    """Send `warming` every WARMING_PERIOD_S for at most WARM_UP_TIME_S: a compilation that hangs is then ended."""
    warm = threading.Event()

    def send_warming() -> None:
        for _ in range(round(WARM_UP_TIME_S / WARMING_PERIOD_S)):
            link.send(StateMessage(state="warming"))
            if warm.wait(WARMING_PERIOD_S):
                return

    sender = threading.Thread(target=send_warming, daemon=True)
    sender.start()
    try:
        yield
    finally:
        warm.set()
        sender.join()


def _exposure_faults(
    guard: ExposureGuard, reading: SizeReading, exposed: FramePair | Frame, source: PairSource | PictureSource
) -> dict[str, str]:
    """Set the exposure where cameras allow it; else return the faults of the exposure."""
    advice = guard.advise(reading.clipped_share, reading.limb_light, exposed.exposure_us, time.monotonic())
    if isinstance(source, Adjustable) and math.isfinite(advice.exposure_us):
        source.set_exposure(advice.exposure_us)
    return advice.faults


def _added_mm(settings: SizingMethod, readings: Sequence[SizeReading]) -> float:
    return settings.adjustment.added_mm if any(Reason.ADJUSTED in one.reasons for one in readings) else 0.0


def _heat(settings: SizingMethod, exposed: FramePair | Frame) -> dict[str, str]:
    if exposed.temperature_c > settings.camera_temperature_max_c:  # false for NaN: unknown
        return {"camera_hot": f"{exposed.temperature_c:.0f} °C, {settings.camera_temperature_max_c:g} °C at most"}
    return {}


def _stay_at_end(link: StationLink, closed: threading.Event, detail: str) -> None:
    while not closed.wait(RETRY_PAUSE_S):
        link.send(fault("recording_over", detail))


def to_message(
    readings: Sequence[SizeReading],
    exposed: FramePair | Frame,
    elapsed_ms: float,
    *,
    slots: tuple[SizeReading, ...],
    dropped: int,
    simulated: bool,
) -> ReadingMessage:
    """Make the message of one exposure.

    Parameters
    ----------
    readings : sequence of SizeReading
        One for each bar, from smaller x.
    exposed : FramePair or Frame
        Exposure that was measured.
    elapsed_ms : float
        Computing time.
    slots : tuple of SizeReading
        Of bars side by side, each in the slot that it keeps.
    dropped : int
        Exposures and messages discarded since the process started.
    simulated : bool
        Whether the pictures come from a simulation or a recording.
    """
    return ReadingMessage(
        sequence=exposed.sequence,
        exposed_monotonic_s=exposed.exposed_monotonic_s,
        exposed_utc_ms=exposed.exposed_utc_ms,
        elapsed_ms=elapsed_ms,
        dropped=dropped,
        simulated=simulated,
        stretch=exposed.stretch,
        reading=of_all_bars(readings),
        bars=slots if len(readings) > 1 else (),
    )


if __name__ == "__main__":
    main()
