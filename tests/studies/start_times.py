"""How soon a gauge has its first value: with and without compiled code, and after its measuring process was killed."""

import os
import signal
import tempfile
import time
from pathlib import Path

from plc_view import has_none, has_value, wait_for
from running import free_port, running

from studies.end_to_end import RECORDING, write_recording

TEXT = (
    "The appliance as a process on a recording of 8 pairs of 800 x 600 pixels, 10 pairs/s; from the start of the "
    "program, or the end of its measuring process, to the first poll, one every 20 ms, that finds a value. `cold`: "
    "nothing is compiled yet, as without `hotgauge install` and `make run`; `warm`: it is, by `make kernels`; "
    "`killed`: the measuring process alone."
)
REPEATABLE = False  # times are those of the computer
CHUNK = 64  # one process, one start after the other
SIZE = (800, 600)
STARTS = ("cold", "warm", "killed")
TIMES = 5
WITHIN_S = 120.0
SETTINGS = "[plc]\nport = {port}\n"


def cases():
    return [{"start": start, "number": number} for number in range(TIMES) for start in STARTS]


def run(case):
    with tempfile.TemporaryDirectory() as name:
        folder, port = Path(name), free_port()
        write_recording(folder, SIZE)
        file = folder / "hotgauge.toml"
        file.write_text(SETTINGS.format(port=port) + RECORDING.format(rate_hz=10.0))
        if case["start"] == "cold":
            return {"seconds": seconds_to_value(file, port, RUNTIME_DIRECTORY=name, NUMBA_CACHE_DIR=name)}
        measured = seconds_back if case["start"] == "killed" else seconds_to_value
        return {"seconds": measured(file, port, RUNTIME_DIRECTORY=name)}


def seconds_to_value(file, port, **environment):
    begun_s = time.monotonic()
    with running("run", "--config", file, port=port, **environment) as gauge, gauge.wire() as wire:
        wait_for(wire, has_value, WITHIN_S)
        return round(time.monotonic() - begun_s, 2)


def seconds_back(file, port, **environment):
    with running("run", "--config", file, port=port, **environment) as gauge, gauge.wire() as wire:
        wait_for(wire, has_value, WITHIN_S)
        os.kill(gauge.station(), signal.SIGKILL)
        killed_s = time.monotonic()
        wait_for(wire, has_none, WITHIN_S)
        wait_for(wire, has_value, WITHIN_S)
        return round(time.monotonic() - killed_s, 2)


def summary(rows):
    seconds = {start: sorted(row["seconds"] for row in rows if row["start"] == start) for start in STARTS}
    return {start: {"median_s": of[len(of) // 2], "worst_s": of[-1]} for start, of in seconds.items()}
