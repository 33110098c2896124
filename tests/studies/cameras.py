"""Cameras over a network that misbehave, for as long as it takes: two GigE cameras, streams that die or stay silent."""

import contextlib
import os
import re
import signal
import socket
import tempfile
import time
from pathlib import Path

import gige_cameras
from network_cameras import line_to, rtsp_camera, silent_camera
from running import free_port, running
from said import Running, said_by
from second_by_second import Polling
from shown_bars import write_bars, write_rig

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.sizing.stereo.rig_file import save_rig

TEXT = (
    "Two fake GigE Vision cameras (Aravis) in a network of their own; an RTSP server (GStreamer) on loopback. Pairs: a "
    "mismatch is a pair that counts although its true stamps are further apart than allowed and 5 ms. Stall: two "
    "seconds of a network that stands, while the bar leaves. Silent: a camera that accepts and never answers, for ten "
    "minutes. Limit: a camera of exactly the rate below which "
    "pairs are too slow. Doctor, stop and reload: fifty times with two streams open."
)
REPEATABLE = False  # times of a real network
CHUNK = 1
TIMES = 50
SILENT_MIN = LIMIT_MIN = 10
SIZE = "800x600"
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


def settings(folder, address, port, **liveness):
    save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), folder / "rig.json")
    path = folder / "hotgauge.toml"
    more = "".join(f"{name} = {value}\n" for name, value in liveness.items())
    path.write_text(
        f'[plc]\nport = {port}\n[sizing]\nrig = "rig.json"\n[sizing.liveness]\napart_max_us = 50000\n{more}'
        f'[sizing.camera]\nkind = "stream"\nleft = "{address}"\nright = "{address}"\n'
    )
    return path


def status(pid):
    """Threads and resident memory of a process, kB."""
    text = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    return [int(re.search(rf"{name}:\s+(\d+)", text)[1]) for name in ("Threads", "VmRSS")]


def silent(folder):
    """Threads and memory of the station, each minute, once the camera accepts and never answers."""
    rtsp_port, port = free_port(), free_port()
    config = settings(folder, f"rtsp://127.0.0.1:{rtsp_port}/stream", port)
    with contextlib.ExitStack() as stack:
        with rtsp_camera(size=SIZE, port=rtsp_port):
            gauge = stack.enter_context(Running(config, port))
            assert gauge.said_within("Hotgauge measures", 90), gauge.lines
            time.sleep(5)
        stack.enter_context(silent_camera(rtsp_port))
        assert gauge.said_within("camera_lost", 30), gauge.lines
        gauge.take_lines()
        counts = []
        for _ in range(SILENT_MIN + 1):
            counts.append(status(gauge.appliance.station()))
            time.sleep(60 if len(counts) <= SILENT_MIN else 0)
        lines = gauge.take_lines()
        code = gauge.stop()
    threads, memory_kb = zip(*counts, strict=True)
    return {
        "minutes": SILENT_MIN, "threads": [min(threads), max(threads)], "memory_kb": [memory_kb[0], memory_kb[-1]],
        "lines": len(lines), "exit_code": code,
    }  # fmt: skip


def limit(folder):
    """Faults of a camera that gives two pictures a second where one every 500 ms is wanted."""
    port = free_port()
    with rtsp_camera(size=SIZE, codec="mjpeg", rate=2) as camera:
        config = settings(folder, camera.address, port, interval_max_ms=500, lost_after_ms=2000)
        with Running(config, port) as gauge:
            assert gauge.said_within("Hotgauge measures", 90), gauge.lines
            time.sleep(60 * LIMIT_MIN)
            lines = gauge.take_lines()
            code = gauge.stop()
    faults = [line for line in lines if "pairs_slow" in line or "pairs_dropped" in line or "camera_" in line]
    begun = [line for line in faults if "is over" not in line]
    return {"minutes": LIMIT_MIN, "faults": len(begun), "lines": len(faults), "exit_code": code}


def doctor(folder):
    with rtsp_camera(size=SIZE) as camera:
        config = settings(folder, camera.address, free_port())
        codes, aborts = [], 0
        for _ in range(TIMES):
            code, said = said_by("doctor", "--config", config)
            codes.append(code)
            aborts += "Fatal" in said or "a pair of 800 x 600 pixels" not in said
    return {"times": TIMES, "exit_codes": sorted(set(codes)), "aborts": aborts}


def stop(folder):
    codes, fatal = [], 0
    with rtsp_camera(size=SIZE) as camera:
        port = free_port()
        config = settings(folder, camera.address, port)
        for _ in range(TIMES):
            with Running(config, port) as gauge:
                assert gauge.said_within("Hotgauge measures", 90), gauge.lines
                time.sleep(1)
                codes.append(gauge.stop())
                fatal += any("Fatal" in line for line in gauge.lines)
    return {"times": TIMES, "exit_codes": sorted(set(codes)), "aborts": fatal}


def reload(folder):
    """Each reload changes a setting, so that the station ends and another one opens both streams."""
    port = free_port()
    with rtsp_camera(size=SIZE) as camera, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(folder / "notify"))  # only under a service manager is SIGHUP a reload
        config = settings(folder, camera.address, port)
        text = config.read_text()
        with Running(config, port, NOTIFY_SOCKET=str(folder / "notify")) as gauge:
            assert gauge.said_within("Hotgauge measures", 90), gauge.lines
            supervisor, stations, fatal = [status(gauge.process.pid)], set(), 0
            for number in range(TIMES):
                stations.add(before := gauge.appliance.station())
                config.write_text(text.replace("[sizing]\n", f"[sizing]\nstale_after_ms = {800 + number}\n"))
                os.kill(gauge.process.pid, signal.SIGHUP)
                until_s = time.monotonic() + 60
                while gauge.appliance.station() == before and time.monotonic() < until_s:
                    time.sleep(0.1)
                time.sleep(4)  # both streams are open again
                fatal += any("Fatal" in line for line in gauge.take_lines())
            supervisor.append(status(gauge.process.pid))
            code = gauge.stop()
    threads, memory_kb = zip(*supervisor, strict=True)
    return {
        "times": TIMES, "stations": len(stations), "aborts": fatal, "exit_code": code,
        "supervisor_threads": list(threads), "supervisor_memory_kb": list(memory_kb),
    }  # fmt: skip


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


LONG = {one.__name__: one for one in (silent, limit, doctor, stop, reload, stall)}
