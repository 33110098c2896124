"""How long it takes from exposure to the register, with cameras whose every picture tells when it was exposed."""

import json
import sys
from pathlib import Path

import gige_cameras

TEXT = (
    "Two cameras at 10 Hz show bars of eight diameters, each for one period by this computer's clock: the diameter "
    "that a PLC reads (every 2 ms) tells its exposure; of GigE cameras their own log does. Cameras, gauge (both "
    "routes) and PLC share two processors. stated: the same by the register `timestamp`, with delay_ms = 0. load: of "
    "the computer then."
)
REPEATABLE = False  # times of a computer and a day
CHUNK = 1
KINDS = ("rtsp_h264_tcp", "rtsp_h264_udp", "rtsp_mjpeg", "http_mjpeg", "gige")
READINGS = 150
SCRIPT = Path(__file__).parents[1] / "kit" / "cameras" / "latency_of_registers.py"


def cases():
    return [{"kind": kind, "wanted": READINGS} for kind in KINDS]


def run(case):
    said = gige_cameras.in_own_network(sys.executable, SCRIPT, case["kind"], case["wanted"], timeout=600)
    return json.loads(said.splitlines()[-1])


def summary(rows):
    return {row["kind"]: {name: row[name] for name in ("p50_ms", "p99_ms", "p50_stated_ms", "load")} for row in rows}
