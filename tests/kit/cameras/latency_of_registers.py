"""Latency from exposure to register of one kind of camera; runs in a network of its own.

    python latency_of_registers.py KIND READINGS     prints one line of JSON

Two cameras show bars of eight diameters, each for one period by this computer's clock, so that the diameter that a
PLC reads is a clock of its exposure. GigE cameras are fired by the gauge: they show a bar for four periods, and their
log tells when each picture was exposed; the one nearest to the register's time stamp is the one that was measured.
"""

import bisect
import contextlib
import json
import os
import sys
import tempfile
import time
from pathlib import Path

from gige_boards import gige_camera
from network_cameras import http_camera, rtsp_camera
from plc_view import look
from running import free_port, running
from shown_bars import write_bars, write_rig
from shown_pictures import ShownPictures

PERIOD_S = 0.1
DIAMETERS_MM = [100.0 + 4 * number for number in range(8)]
NEAR_MM = 1.0  # of a diameter that was shown
POLL_S = 0.002
WARM_S = 5.0
SIZE, COLUMNS, ROWS = "800x600", 800, 600


@contextlib.contextmanager
def cameras(kind, folder):
    """Settings of the cameras of a kind, while they show the folder."""
    with contextlib.ExitStack() as stack:
        if kind.startswith("rtsp"):
            _, codec, *transport = kind.split("_")
            shown = [
                stack.enter_context(rtsp_camera(codec=codec, size=SIZE, rate=10, show=(folder / side, PERIOD_S)))
                for side in ("left", "right")
            ]
            left, right = (camera.address for camera in shown)
            more = f'transport = "{transport[0]}"\n' if transport else ""
            yield f'kind = "stream"\nleft = "{left}"\nright = "{right}"\n{more}delay_ms = 0\n'
        elif kind == "http_mjpeg":
            ports = [
                stack.enter_context(http_camera(picture=ShownPictures(folder / side, PERIOD_S).at, rate=10))
                for side in ("left", "right")
            ]
            left, right = (f"http://127.0.0.1:{port}/{side}" for port, side in zip(ports, "lr", strict=True))
            yield f'kind = "stream"\nleft = "{left}"\nright = "{right}"\ndelay_ms = 0\n'
        else:
            for serial in ("GV01", "GV02"):
                stack.enter_context(gige_camera(serial, folder, 4 * PERIOD_S, folder / f"{serial}.log"))
            yield (
                'kind = "genicam"\nleft = "GV01"\nright = "GV02"\ntrigger = "Software"\n'
                f"region = [0, 0, {COLUMNS}, {ROWS}]\nrate_hz = {1 / PERIOD_S}\nexposure_us = 1000.0\ndelay_ms = 0\n"
            )


def readings(wire, number, within_s=240.0):
    """Moment of the first poll that reads each new diameter, the diameter, and the register's own moment, seconds."""
    seen, before = [], None
    until_s = time.monotonic() + within_s
    ahead_s = time.time() - time.monotonic()
    while len(seen) < number and time.monotonic() < until_s:
        block = look(wire)
        now_s = time.monotonic()
        if block["sequence"] != before and block["validity"]:
            seen.append((now_s, block["diameter"], block["timestamp"] / 1000 - ahead_s))
        before = block["sequence"]
        time.sleep(POLL_S)
    return seen


def by_the_diameter(seen):
    """Latency of each reading whose diameter is one that was shown, and how many had another."""
    latencies, others = [], 0
    for now_s, diameter_mm, _ in seen:
        slot = min(range(len(DIAMETERS_MM)), key=lambda number: abs(DIAMETERS_MM[number] - diameter_mm))
        if abs(DIAMETERS_MM[slot] - diameter_mm) > NEAR_MM:
            others += 1
            continue
        newest = int(now_s / PERIOD_S)
        exposed_s = PERIOD_S * (newest - (newest - slot) % len(DIAMETERS_MM))
        latencies.append(now_s - exposed_s)
    return latencies, others


def by_the_log(seen, log):
    """Latency of each reading, from the exposure in the camera's log that is nearest to the register's moment."""
    exposed_s = [float(line.split()[1]) / 1000 for line in log.read_text().splitlines()]
    latencies = []
    for now_s, _, stamped_s in seen:
        place = bisect.bisect(exposed_s, stamped_s)
        nearest = min(exposed_s[max(0, place - 1) : place + 1], key=lambda moment_s: abs(moment_s - stamped_s))
        latencies.append(now_s - nearest)
    return latencies, 0


def percentile_ms(values, percent):
    ordered = sorted(values)
    return round(1000 * ordered[min(len(ordered) - 1, len(ordered) * percent // 100)])


def main():
    kind, number = sys.argv[1], int(sys.argv[2])
    port = free_port()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_bars(folder, DIAMETERS_MM)
        write_rig(folder / "rig.json")
        with cameras(kind, folder) as settings:
            config = folder / "gauge.toml"
            config.write_text(
                f'[plc]\nport = {port}\n[sizing]\nrig = "rig.json"\n[sizing.liveness]\napart_max_us = 40000\n'
                f"[sizing.camera]\n{settings}"
            )
            with running("run", "--config", config, port=port) as gauge, gauge.wire() as wire:
                until_s = time.monotonic() + 120
                while not look(wire)["validity"] and time.monotonic() < until_s:
                    time.sleep(0.1)
                time.sleep(WARM_S)
                seen = readings(wire, number)
        stated = [now_s - stamped_s for now_s, _, stamped_s in seen]
        latencies, others = by_the_log(seen, folder / "GV01.log") if kind == "gige" else by_the_diameter(seen)
    found = {"readings": len(latencies), "of_no_shown_diameter": others, "load": round(os.getloadavg()[0], 1)}
    for text, values in (("ms", latencies), ("stated_ms", stated)):
        found |= {f"p50_{text}": percentile_ms(values, 50), f"p99_{text}": percentile_ms(values, 99)}
    print(json.dumps(found))


if __name__ == "__main__":
    main()
