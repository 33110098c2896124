"""A camera that accepts connections and never answers, for ten minutes: threads and memory of the gauge."""

import contextlib
import tempfile
import time
from pathlib import Path

from network_cameras import rtsp_camera, silent_camera
from running import free_port
from stream_gauge import SIZE, measures, settings, starting, status

TEXT = (
    "Both cameras are one RTSP server (GStreamer, H.264, 800 x 600) on loopback; the gauge reads them, then the server "
    "is gone and a port that accepts and never answers is in its place. Threads and resident memory of the measuring "
    "process and of the supervisor, from the fault camera_lost on and each minute after it; lines that were logged "
    "meanwhile."
)
REPEATABLE = False  # ten minutes of processes and a network
MINUTES = 10


def cases():
    return [{"minutes": MINUTES}]


def run(case):
    rtsp_port, port = free_port(), free_port()
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        config = settings(Path(folder), f"rtsp://127.0.0.1:{rtsp_port}/stream", port)
        with rtsp_camera(size=SIZE, port=rtsp_port):
            gauge = stack.enter_context(starting(config, port))
            measures(gauge)
        stack.enter_context(silent_camera(rtsp_port))
        assert gauge.said_within("camera_lost", 30), gauge.lines
        gauge.take_lines()
        counts = [_counts(gauge)]
        for _ in range(case["minutes"]):
            time.sleep(60)
            counts.append(_counts(gauge))
        lines = gauge.take_lines()
        code = gauge.stop()
    station, supervisor = zip(*counts, strict=True)
    return _held("station", station) | _held("supervisor", supervisor) | {"lines": len(lines), "exit_code": code}


def _counts(gauge):
    return status(gauge.appliance.station()), status(gauge.process.pid)


def _held(name, counts):
    threads, memory_kb = zip(*counts, strict=True)
    return {f"{name}_threads": list(threads), f"{name}_memory_kb": list(memory_kb)}


def summary(rows):
    return rows[0]
