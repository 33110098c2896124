"""A history whose disk is full, whose folder is read-only, whose file is rubbish: what the PLC notices of it.

Run by `run` in a file system of its own, without rights (unshare(1), mount_namespaces(7)):

    python -m studies.history_troubles WHAT FOLDER     prints one line of JSON
"""

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from modbus_wire import write_coils
from plc_view import look
from running import free_port, running
from second_by_second import Polling

from appliance.history.database import FILE_NAME
from plc.registers import REGISTERS

TEXT = (
    "The gauge measures the simulated mill and keeps its history on a tmpfs of 2 MB; a PLC polls every 20 ms. Full: a "
    "file fills it. Read-only: it is mounted so while the gauge starts. Rubbish: its file is overwritten. Before "
    "(read-only: after) and during the trouble: waits for an answer, ms, and readings a second; then seconds until the "
    "fault is there, and until it is over once the cause is (rubbish: once it is acknowledged). Load at the end."
)
REPEATABLE = False  # times of a computer and a day
CHUNK = 1
TIME_S = 10.0
FAULT_WITHIN_S = 30.0
OVER_WITHIN_S = 90.0  # damage stays a fault for a minute
ACKNOWLEDGE = next(row.address for row in REGISTERS if row.name == "acknowledge")
FAULTS = {"full": "history_not_written", "read_only": "history_not_written", "rubbish": "history_damaged"}
DISK = 'mount -t tmpfs -o size=2m none "$0" && exec "$@"'


def cases():
    return [{"what": what} for what in FAULTS]


def run(case):
    with tempfile.TemporaryDirectory() as folder:
        disk = Path(folder) / "disk"
        disk.mkdir()
        words = ["unshare", "--map-root-user", "--mount", "sh", "-c", DISK, disk, sys.executable, "-m", __name__]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        done = subprocess.run([*words, case["what"], folder], stdout=subprocess.PIPE, check=True, env=environment)
    return json.loads(done.stdout.splitlines()[-1])


def summary(rows):
    return {row["what"]: {name: row[name] for name in row if name != "what"} for row in rows}


def main():
    what, folder = sys.argv[1], Path(sys.argv[2])
    port = free_port()
    config = folder / "hotgauge.toml"
    config.write_text(f'[plc]\nport = {port}\nwrites = "all"\n[history]\ndirectory = "disk/history"\n')
    if what == "read_only":
        _mount(folder / "disk", "ro")
    with running("run", "--config", config, port=port) as gauge, gauge.wire() as wire, gauge.wire() as other:
        while not look(wire)["validity"]:
            time.sleep(0.1)
        with Polling(other) as plc:
            found = _undisturbed(wire, plc) if what != "read_only" else None
            begun_s = _begin(what, folder / "disk")
            fault_s = plc.first(begun_s, lambda seen: FAULTS[what] in seen.faults, FAULT_WITHIN_S).at_s - begun_s
            during = _undisturbed(wire, plc)
            ended_s = _end(what, folder / "disk", wire)
            over_s = plc.first(ended_s, lambda seen: FAULTS[what] not in seen.faults, OVER_WITHIN_S).at_s - ended_s
            found = found or _undisturbed(wire, plc)
    times = {"fault_after_s": round(fault_s, 1), "over_after_s": round(over_s, 1)}
    print(json.dumps({"without": found, "during": during} | times | {"load": round(os.getloadavg()[0], 1)}))


def _undisturbed(wire, plc):
    """What the PLC sees for a while: its waits for an answer, and new readings a second."""
    first, begun_s = look(wire)["sequence"], time.monotonic()
    time.sleep(TIME_S)
    waited_ms = sorted(1000 * seen.waited_s for seen in plc.since(begun_s))
    percentiles = {f"p{part}_ms": round(waited_ms[len(waited_ms) * part // 100], 1) for part in (50, 99)}
    readings = look(wire)["sequence"] - first
    return percentiles | {"most_ms": round(waited_ms[-1], 1), "readings_per_s": round(readings / TIME_S, 1)}


def _begin(what, disk):
    if what == "full":
        with contextlib.suppress(OSError), (disk / "filler").open("wb", buffering=0) as filler:
            while True:
                filler.write(bytes(4096))
    elif what == "rubbish":
        (disk / "history" / FILE_NAME).write_bytes(b"rubbish " * 4000)
    return time.monotonic()


def _end(what, disk, wire):
    if what == "full":
        (disk / "filler").unlink()
    elif what == "read_only":
        _mount(disk, "rw")
    else:
        wire.ask(write_coils(ACKNOWLEDGE, True))
    return time.monotonic()


def _mount(disk, how):
    subprocess.run(["mount", "-o", f"remount,{how}", disk], check=True)


if __name__ == "__main__":
    main()
