"""Cameras over a network that misbehave, for as long as it takes: two GigE cameras, streams that stall."""

import contextlib
import tempfile
import time
from pathlib import Path

import gige_cameras
from network_cameras import line_to, rtsp_camera
from running import free_port, running
from second_by_second import Polling
from shown_bars import write_bars, write_rig
from stream_gauge import SIZE, settings, starting

TEXT = (
    "Two fake GigE Vision cameras (Aravis) in a network of their own; an RTSP server (GStreamer) on loopback. Pairs: a "
    "mismatch is a pair that counts although its true stamps are further apart than allowed and 5 ms. Stall: two "
    "seconds of a network that stands, while the bar leaves. Limit: a camera of exactly the rate below which pairs are "
    "too slow, for ten minutes."
)
REPEATABLE = False  # times of a real network
CHUNK = 1
LIMIT_MIN = 10
DIAMETER_MM = 120.0
STALL_S = 2.0
LEAVES_AFTER_S = 0.4
SLACK_S = 0.2  # of the server's own coding on a busy computer
OVER_WITHIN_S = 8.0
GIGE = ("pairs", "fired_pairs", "packet_loss", "killed_and_back", "wrong_pixel_format", "wrong_packet_size")


def cases():
    return [{"what": name} for name in (*LONG, *GIGE)]


def run(case):
    if case["what"] in GIGE:
        mtu = 9000 if case["what"] == "wrong_packet_size" else 65536
        return {"found": gige_cameras.scenario(case["what"], mtu=mtu)}
    with tempfile.TemporaryDirectory() as folder:
        return {"found": LONG[case["what"]](Path(folder))}


def summary(rows):
    return {row["what"]: row["found"] for row in rows}


def limit(folder):
    """Faults of a camera that gives two pictures a second where one every 500 ms is wanted."""
    port = free_port()
    with rtsp_camera(size=SIZE, codec="mjpeg", rate=2) as camera:
        config = settings(folder, camera.address, port, interval_max_ms=500, lost_after_ms=2000)
        with starting(config, port) as gauge:
            time.sleep(60 * LIMIT_MIN)
            lines = gauge.take_lines()
            code = gauge.stop()
    faults = [line for line in lines if "pairs_slow" in line or "pairs_dropped" in line or "camera_" in line]
    begun = [line for line in faults if "is over" not in line]
    return {"minutes": LIMIT_MIN, "faults": len(begun), "lines": len(faults), "exit_code": code}


def stall(folder):
    """The network stalls for two seconds while the bar leaves: nothing served may be younger than the bar."""
    write_bars(folder / "bar", [DIAMETER_MM])
    write_bars(folder / "empty", [None])
    write_rig(folder / "rig.json")
    port = free_port()
    with contextlib.ExitStack() as stack:
        cameras, lines = [], []
        for side in ("left", "right"):
            show = (folder / "bar" / side, 1)
            cameras.append(stack.enter_context(rtsp_camera(size="800x600", rate=10, show=show)))
            lines.append(stack.enter_context(line_to(cameras[-1].port)))
        left, right = (f"rtsp://127.0.0.1:{line.port}/stream" for line in lines)
        config = folder / "gauge.toml"
        config.write_text(
            f'[plc]\nport = {port}\n[sizing]\nrig = "rig.json"\n[sizing.liveness]\napart_max_us = 50000\n'
            f'[sizing.camera]\nkind = "stream"\nleft = "{left}"\nright = "{right}"\ndelay_ms = 0\n'
        )
        gauge = stack.enter_context(running("run", "--config", config, port=port))
        plc = stack.enter_context(Polling(stack.enter_context(gauge.wire())))
        first = plc.first(time.monotonic(), lambda seen: seen.diameter_mm is not None, 60)
        assert abs(first.diameter_mm - DIAMETER_MM) < 1.0
        time.sleep(2)
        for line in lines:
            line.flows.clear()
        stalled_s = time.monotonic()
        time.sleep(LEAVES_AFTER_S)
        for camera, side in zip(cameras, ("left", "right"), strict=True):
            camera.tell(f"show {folder / 'empty' / side} 1")
        left_s = time.monotonic()
        time.sleep(STALL_S - LEAVES_AFTER_S)
        for line in lines:
            line.flows.set()
        time.sleep(OVER_WITHIN_S)
        served = [seen for seen in plc.since(stalled_s) if seen.diameter_mm is not None]
        late = [seen for seen in served if seen.at_s - seen.age_ms / 1000 > left_s + SLACK_S]
        last = plc.since(stalled_s)[-1]
    return {"values_after_the_stall": len(served), "younger_than_the_bar": len(late), "value_at_the_end": last.validity}


LONG = {one.__name__: one for one in (limit, stall)}
