"""Fifty times each with two streams open: `doctor`, a start and a stop, a reload with changed settings."""

import tempfile
import time
from pathlib import Path

from network_cameras import rtsp_camera
from running import free_port
from said import Running, said_by
from stream_gauge import MEASURES_WITHIN_S, SIZE, managed, measures, reload_changed, settings, status

TEXT = (
    "An RTSP server (GStreamer, H.264, 800 x 600) on loopback is both cameras. Doctor: exit codes, and how often it "
    "found a pair. Stop: the gauge is started, reads both streams and is ended by SIGTERM. Reload: SIGHUP with a "
    "changed setting, so that the station ends and another one opens and reads both streams. Aborts are exit codes "
    "other than 0 and 1, and lines with 'Fatal'. Seconds are the longest: of a stop from SIGTERM to the exit, of a "
    "reload from SIGHUP to readings."
)
REPEATABLE = False  # processes and a network
CHUNK = 1
TIMES = 50


def cases():
    return [{"what": what, "times": TIMES} for what in WHAT]


def run(case):
    with tempfile.TemporaryDirectory() as folder, rtsp_camera(size=SIZE) as camera:
        port = free_port()
        return {"found": WHAT[case["what"]](settings(Path(folder), camera.address, port), port, case["times"])}


def summary(rows):
    return {row["what"]: row["found"] for row in rows}


def doctor(config, _port, times):
    ends, pairs = [], 0
    for _ in range(times):
        begun_s = time.monotonic()
        code, said = said_by("doctor", "--config", config)
        ends.append((code, said, time.monotonic() - begun_s))
        pairs += "a pair of 800 x 600 pixels" in said
    return _ends(ends) | {"with_a_pair": pairs}


def stop(config, port, times):
    """Stops of a gauge that measures; a start that is refused because the camera sends nothing is counted apart."""
    ends, refused = [], []
    while len(ends) < times:
        with Running(config, port) as gauge:
            assert gauge.said_within("Hotgauge measures|^hotgauge: ", MEASURES_WITHIN_S), gauge.lines
            if gauge.lines[0].startswith("hotgauge: "):
                refused.append((gauge.process.wait(20), gauge.lines[0]))
                assert len(refused) < times, refused
                continue
            measures(gauge)
            begun_s = time.monotonic()
            code = gauge.stop()
            seconds = time.monotonic() - begun_s
            gauge.listener.join(5)
            ends.append((code, "".join(gauge.lines), seconds))
    return _ends(ends) | {"refused": len(refused), "refused_codes": sorted({code for code, _ in refused})}


def reload(config, port, times):
    """The stations' exit codes are the supervisor's to tell; an abort is a line of its own."""
    stations, ends = set(), []
    with managed(config, port) as gauge:
        measures(gauge)
        held = [status(gauge.process.pid)]
        for number in range(times):
            stations.add(gauge.appliance.station())
            begun_s = time.monotonic()
            reload_changed(gauge, config, delay_ms=200 + number)
            ends.append((0, "".join(gauge.take_lines()), time.monotonic() - begun_s))
        stations.add(gauge.appliance.station())
        held.append(status(gauge.process.pid))
        code = gauge.stop()
        gauge.listener.join(5)
        ends[-1] = (code, ends[-1][1] + "".join(gauge.lines), ends[-1][2])
    threads, memory_kb = zip(*held, strict=True)
    more = {"supervisor_threads": list(threads), "supervisor_memory_kb": list(memory_kb)}
    return _ends(ends) | {"stations": len(stations)} | more


def _ends(ends):
    codes, said, seconds = zip(*ends, strict=True)
    aborts = sum(code not in {0, 1} or "Fatal" in text for code, text in zip(codes, said, strict=True))
    return {"exit_codes": sorted(set(codes)), "aborts": aborts, "seconds": round(max(seconds), 1)}


WHAT = {one.__name__: one for one in (doctor, stop, reload)}
