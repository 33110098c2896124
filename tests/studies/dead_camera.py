"""A camera that dies for more than an hour and comes back: what the gauge writes to its journal."""

import contextlib
import os
import tempfile
import time
from pathlib import Path

from network_cameras import rtsp_camera
from running import free_port
from stream_gauge import SIZE, measures, settings, starting

TEXT = (
    "Both cameras are one RTSP server (GStreamer, H.264, 800 x 600) on loopback; the gauge measures, the server is "
    "gone and comes back. goes: lines of the journal in the first minute. after: lines of the minutes after it. "
    "comes_back: lines from the server's start until 10 s after the fault is over. load: average of the computer then."
)
REPEATABLE = False  # an hour of processes and a network
GOES_S = 60
AFTER_MIN = (64, 1)


def cases():
    return [{"after_min": minutes} for minutes in AFTER_MIN]


def run(case):
    rtsp_port, port = free_port(), free_port()
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        config = settings(Path(folder), f"rtsp://127.0.0.1:{rtsp_port}/stream", port)
        with rtsp_camera(size=SIZE, port=rtsp_port):
            gauge = stack.enter_context(starting(config, port))
            measures(gauge)
            gauge.take_lines()
        assert gauge.said_within("camera_lost", 30), gauge.lines
        time.sleep(GOES_S)
        goes = gauge.take_lines()
        time.sleep(60 * case["after_min"])
        after = gauge.take_lines()
        with rtsp_camera(size=SIZE, port=rtsp_port):
            assert gauge.said_within("camera_lost is over", 60), gauge.lines
            time.sleep(10)
            comes_back = gauge.take_lines()
            load = round(os.getloadavg()[0], 1)
            code = gauge.stop()
    counts = {"goes": len(goes), "after": len(after), "comes_back": len(comes_back)}
    return counts | {"exit_code": code, "load": load}


def summary(rows):
    return {f"{row['after_min']} min": row for row in rows}
