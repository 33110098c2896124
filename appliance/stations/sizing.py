"""The measuring process of the sizing station: settings in, then source -> gauge -> link until the link closes.

The supervisor runs it as `python -m appliance.stations.sizing DESCRIPTOR`; the descriptor is a connected socket
whose first line holds the settings.
"""

import contextlib
import math
import os
import socket
import sys
import threading
import time
from functools import partial

from appliance.cameras.liveness import Exposure, Liveness, Verdict
from appliance.cameras.mill import MillSource
from appliance.cameras.recording import RecordingSource
from appliance.cameras.source import CameraError, EndOfRecording, FramePair, PairSource
from appliance.gauging import TimedGauge, mill_rig
from appliance.rigs import RigError, load_rig
from appliance.settings import RecordingCamera, SizingSettings
from appliance.stations.limits import EXIT_OUT_OF_MEMORY, limit_process
from appliance.stations.link import ReadingMessage, StateMessage, StationLink
from vision.readings import SizeReading
from vision.sizing.gauge import Gauge

PAIR_TIMEOUT_S = 0.2
PAUSE_S = 1.0
REOPEN_AFTER_S = 5.0  # cameras whose pictures have not counted for so long are opened again
LEAVE_TIME_S = 2.0


def main() -> None:
    """Measure until the supervisor closes the link, or is gone."""
    connection = socket.socket(fileno=int(sys.argv[1]))
    with connection, connection.makefile("rb") as lines:
        settings = SizingSettings.model_validate_json(lines.readline())
        limit_process(settings.memory_max_mb)
        closed = threading.Event()
        threading.Thread(target=_wait_for_close, args=(connection, closed), daemon=True).start()
        try:
            run(settings, StationLink(connection), closed)
        except MemoryError:
            os._exit(EXIT_OUT_OF_MEMORY)  # tidying up needs memory too


def _wait_for_close(connection: socket.socket, closed: threading.Event) -> None:
    with contextlib.suppress(ConnectionError):  # reset: the supervisor died with messages that it had not read
        while connection.recv(1):
            pass
    closed.set()
    time.sleep(LEAVE_TIME_S)
    os._exit(1)  # still here: the loop hangs in a camera or in native code, and nobody listens any more


def run(settings: SizingSettings, link: StationLink, closed: threading.Event) -> None:
    """Measure until `closed`; equipment trouble is reported and tried again after a pause.

    Parameters
    ----------
    settings : SizingSettings
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
            link.send(_fault(error.fault, str(error)))
        except RigError as error:
            link.send(_fault("rig_unusable", str(error)))
        closed.wait(PAUSE_S)


def _measure(settings: SizingSettings, link: StationLink, closed: threading.Event) -> None:
    source = source_of(settings)
    gauge = _gauge(settings, source, link)
    gauge.warm_up()
    with source:
        liveness = Liveness(settings.liveness, time.monotonic(), numbered=source.simulated)
        while not closed.is_set():
            pair = source.next(PAIR_TIMEOUT_S)
            verdict = liveness.look(pair and Exposure.of(pair), time.monotonic())
            if pair is None or not verdict.counts:
                _tell_lost(verdict, link, opens_again=not source.simulated)
                continue
            reading, elapsed_ms = gauge.measure(pair.left, pair.right)
            message = to_message(
                reading, pair, elapsed_ms, dropped=pair.dropped + link.dropped, simulated=source.simulated
            )
            link.send(message.model_copy(update={"faults": verdict.faults}))


def _tell_lost(verdict: Verdict, link: StationLink, *, opens_again: bool) -> None:
    """Tell what is wrong with pictures that do not count; cameras are opened again for it after a while."""
    for fault, detail in verdict.faults.items():
        if opens_again and verdict.lost_s > REOPEN_AFTER_S:  # a recording would begin anew and never end
            raise CameraError(detail, fault)
        link.send(_fault(fault, detail))


def source_of(settings: SizingSettings) -> PairSource:
    """The source of image pairs that the settings name, not opened yet."""
    camera = settings.camera
    if isinstance(camera, RecordingCamera):
        return RecordingSource(camera.path, rate_hz=camera.rate_hz, loop=camera.loop)
    return MillSource(camera.seed, camera.rate_hz, camera.prepared_frames)


def _gauge(settings: SizingSettings, source: PairSource, link: StationLink) -> TimedGauge[SizeReading]:
    gauge = partial(Gauge, ovality_mm=settings.ovality_mm)
    if settings.rig is not None:
        return TimedGauge(load_rig(settings.rig), str(settings.rig), gauge)
    if isinstance(source, MillSource):
        link.send(StateMessage(state="starting"))
        return TimedGauge(mill_rig(source), "rig of the simulated mill", gauge)
    raise RigError("sizing.rig is not set; make a rig file with `hotgauge calibrate` and set it")


def _stay_at_end(link: StationLink, closed: threading.Event, detail: str) -> None:
    while not closed.wait(PAUSE_S):
        link.send(_fault("recording_over", detail))


def _fault(name: str, detail: str) -> StateMessage:
    return StateMessage(state="faulty", fault=name, detail=detail)


def to_message(
    reading: SizeReading, pair: FramePair, elapsed_ms: float, *, dropped: int, simulated: bool
) -> ReadingMessage:
    """What is said to the supervisor of one reading.

    Parameters
    ----------
    reading : SizeReading
    pair : FramePair
        The pair that was measured.
    elapsed_ms : float
        Time that measuring took.
    dropped : int
        Pairs and messages discarded so far.
    simulated : bool
    """
    return ReadingMessage(
        sequence=pair.sequence,
        exposed_monotonic_s=pair.exposed_monotonic_s,
        exposed_utc_ms=pair.exposed_utc_ms,
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
