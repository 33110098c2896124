"""From exposure to register at full rate, beside PLC clients and the page: what is dropped, how late, at what cost.

For a computer that does nothing else: `python -m studies --processes 1 end_to_end`, ten minutes at either size and an
hour of the larger one.
"""

import contextlib
import os
import tempfile
import threading
import time
from pathlib import Path

import cv2
from calibrated_rigs import calibrated_rig
from latency_of_registers import percentile_ms
from plc_view import has_value, look, wait_for
from running import free_port, running

from appliance.page.access.users import Users
from appliance.simulation.bars.study_scenes import set_up
from appliance.sizing.stereo.rig_file import save_rig
from plc.security.roles import Role
from studies.modbus_load import Load, percentiles
from studies.page_load import PASSWORD, browsers, page

TEXT = (
    "The whole appliance: pairs come at a fixed rate (800 x 600: the simulated mill, a loop of 46 drawn frames; "
    "2704 x 1520: a loop of 8 JPEG pairs that are decoded), four PLC clients ask for the whole block every 10 ms, and "
    "the page is open once. Latency is from the exposure to the first poll, one every 5 ms, that reads it. Processor "
    "is that of supervisor and measuring process together, of one core; memory is sampled ten times. The hour is "
    "for its memory: it was measured beside other work that took more than the rest of the computer."
)
REPEATABLE = False  # times are those of the computer
CHUNK = 2  # one process, one case after the other
MINUTES, LONG_MINUTES = 10.0, 60.0
CLIENTS = 4
PERIOD_S, POLL_S = 0.01, 0.005
SAMPLES = 10
SEED = 5
FRAMES, RECORDED_FRAMES = 46, 8  # of the mill: two bars and the gap between them
FULL = (2704, 1520)
SIDES = ("left", "right")
FIRST_VALUE_S = 180.0
WARM_S = 5.0
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
SETTINGS = "[plc]\nport = {port}\n[page]\nport = {page_port}\nusers = 'users.json'\n{sizing}"
MILL = "[sizing.camera]\nkind = 'mill'\nseed = {seed}\nrate_hz = {rate_hz}\nprepared_frames = {frames}\n"
RECORDING = "[sizing]\nrig = 'rig.json'\n[sizing.camera]\nkind = 'recording'\npath = 'recording'\nrate_hz = {rate_hz}\n"


def cases():
    full = {"columns": FULL[0], "rate_hz": 5.0}
    return [
        {"columns": 800, "rate_hz": 25.0, "minutes": MINUTES},
        full | {"minutes": MINUTES},
        full | {"minutes": LONG_MINUTES},
    ]


def run(case):
    port, page_port = free_port(), free_port()
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        if case["columns"] == FULL[0]:
            write_recording(folder, FULL)
            sizing = RECORDING.format(rate_hz=case["rate_hz"])
        else:
            sizing = MILL.format(seed=SEED, rate_hz=case["rate_hz"], frames=FRAMES)
        file = folder / "hotgauge.toml"
        file.write_text(SETTINGS.format(port=port, page_port=page_port, sizing=sizing))
        Users(folder / "users.json").put("anna", Role.VIEWER, PASSWORD)
        words = ["--config", file]
        gauge = stack.enter_context(running("run", *words, port=port, RUNTIME_DIRECTORY=name))
        wire = stack.enter_context(gauge.wire())
        wait_for(wire, has_value, FIRST_VALUE_S)
        stack.enter_context(page(words, name))
        stack.enter_context(browsers(f"http://127.0.0.1:{page_port}", 1))
        time.sleep(WARM_S)
        return measured(gauge, wire, 60 * case["minutes"], case["rate_hz"])


def write_recording(folder, size):
    """Pairs of a size and the rig that they were taken with."""
    save_rig(calibrated_rig(SEED, size), folder / "rig.json")
    setup = set_up("clean", SEED, size)
    for frame in range(RECORDED_FRAMES):
        for side, picture in zip(SIDES, setup.pair(frame), strict=True):
            (folder / "recording" / side).mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(folder / "recording" / side / f"{frame:06d}.jpg"), picture)


def measured(gauge, wire, seconds, rate_hz):
    """What a time at full rate was like."""
    pids = {"supervisor": gauge.process.pid, "station": gauge.station()}
    load, waits_s = Load(gauge.port, CLIENTS), []
    asking = threading.Thread(target=lambda: waits_s.extend(load.ask_every(PERIOD_S, seconds)))
    first, before_s, begun_s = look(wire), processor_s(pids), time.monotonic()
    asking.start()
    latencies_s, memory_mb, exposures = [], [], {None, first["timestamp"]}
    while (passed_s := time.monotonic() - begun_s) < seconds:
        seen, now_s = look(wire), time.time()
        if seen["timestamp"] not in exposures:
            exposures.add(seen["timestamp"])
            latencies_s.append(now_s - seen["timestamp"] / 1000)
        if passed_s >= len(memory_mb) * seconds / SAMPLES:
            memory_mb.append({name: status_mb(pid, "VmRSS") for name, pid in pids.items()})
        time.sleep(POLL_S)
    used_s, last = processor_s(pids) - before_s, look(wire)
    asking.join()
    load.close()
    return {
        "pairs": round(seconds * rate_hz),
        "readings": len(latencies_s),
        "dropped": last["frames_dropped"] - first["frames_dropped"],
        "latency_p50_ms": percentile_ms(latencies_s, 50),
        "latency_p99_ms": percentile_ms(latencies_s, 99),
        "processor_percent": round(100 * used_s / seconds),
        "station_peak_mb": status_mb(pids["station"], "VmHWM"),
        "memory_mb": memory_mb,
        "answers": percentiles(waits_s),
    }


def processor_s(pids):
    """Time of the processor that some processes have had."""
    fields = [Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split() for pid in pids.values()]
    return sum(int(one[11]) + int(one[12]) for one in fields) / TICKS_PER_S


def status_mb(pid, name):
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return round(next(int(line.split()[1]) for line in lines if line.startswith(name)) / 1024)


def summary(rows):
    return {
        f"{row['columns']} columns, {row['minutes']:g} minutes": {
            name: value for name, value in row.items() if name not in {"columns", "minutes"}
        }
        for row in rows
    }
