"""A gauge with two streams: its settings, a start, a reload, and what its processes hold."""

import contextlib
import os
import re
import signal
import socket
import time
from pathlib import Path

from plc_view import look
from said import Running

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.sizing.stereo.rig_file import save_rig

SIZE = "800x600"  # of the mill's rig
READINGS = 5
MEASURES_WITHIN_S = 90.0


def settings(folder, address, port, credentials=None, **liveness):
    """Settings file of a gauge whose two cameras are one and the same stream."""
    rig = folder / "rig.json"
    if not rig.exists():
        save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), rig)
    path = folder / f"{port}.toml"
    more = "".join(f"{name} = {value}\n" for name, value in liveness.items())
    user = f'credentials = "{credentials}"\n' if credentials else ""
    path.write_text(
        f'[plc]\nport = {port}\n[sizing]\nrig = "rig.json"\n[sizing.liveness]\napart_max_us = 50000\n{more}'
        f'[sizing.camera]\nkind = "stream"\nleft = "{address}"\nright = "{address}"\n{user}'
    )
    return path


@contextlib.contextmanager
def starting(config, port, **environment):
    """A gauge whose port answers."""
    with Running(config, port, **environment) as gauge:
        assert gauge.said_within("Hotgauge measures", MEASURES_WITHIN_S), gauge.lines
        yield gauge


@contextlib.contextmanager
def managed(config, port):
    """A gauge under a service manager, where SIGHUP is a reload."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        place = config.with_name("notify")
        manager.bind(str(place))
        with starting(config, port, NOTIFY_SOCKET=str(place)) as gauge:
            yield gauge


def measures(gauge):
    """Wait until the station gives readings."""
    until_s = time.monotonic() + MEASURES_WITHIN_S
    with gauge.appliance.wire() as wire:
        first = look(wire)["sequence"]
        while look(wire)["sequence"] < first + READINGS:
            assert time.monotonic() < until_s, gauge.lines
            time.sleep(0.05)


def reload_changed(gauge, config, delay_ms):
    """Reload with another setting of the cameras, and wait until a new station gives readings."""
    before = gauge.appliance.station()
    text = re.sub(r"delay_ms = \d+\n", "", config.read_text())
    config.write_text(text.replace('kind = "stream"\n', f'kind = "stream"\ndelay_ms = {delay_ms}\n'))
    os.kill(gauge.process.pid, signal.SIGHUP)
    until_s = time.monotonic() + MEASURES_WITHIN_S
    while gauge.appliance.station() == before:
        assert time.monotonic() < until_s, gauge.lines
        time.sleep(0.05)
    measures(gauge)


def status(pid):
    """Threads and resident memory of a process, kB."""
    text = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    return [int(re.search(rf"{name}:\s+(\d+)", text)[1]) for name in ("Threads", "VmRSS")]
