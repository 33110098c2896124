"""The whole appliance on the simulated mill for half an hour, while something breaks every few seconds."""

import contextlib
import itertools
import os
import random
import signal
import socket
import tempfile
import time
from pathlib import Path

from running import free_port, running
from second_by_second import Polling

from appliance.simulation.bars.bars import bar_at
from studies.modbus_load import footprint

TEXT = (
    "The appliance as a process on the simulated mill (a loop of frames, 10 pairs/s). A PLC polls every 20 ms on one "
    "connection. Every few seconds one fault at random; the next when the gauge measures again. Wrong: served as valid "
    "although no bar of the loop is within max(2 U, 1 mm)."
)
REPEATABLE = False  # a fault meets another moment each time
MINUTES = 30
SEED = 5
FRAMES = 46  # two bars and the gap between them
LATE_S = 0.2
BACK_WITHIN_S = 60.0  # a process that hangs is ended after seconds, and starts on a busy computer
BARS_MM = sorted({bar.diameter_mm for frame in range(FRAMES) if (bar := bar_at(SEED, frame)) is not None})
SETTINGS = '[plc]\nport = {port}\n[sizing.camera]\nkind = "mill"\nseed = {seed}\nprepared_frames = {frames}\n'


def cases():
    return [{"minutes": MINUTES, "seed": 1}]


def run(case):
    chance = random.Random(case["seed"])
    port = free_port()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "hotgauge.toml"
        file.write_text(SETTINGS.format(port=port, seed=SEED, frames=FRAMES))
        manager = Path(folder) / "notify"  # only under a service manager is SIGHUP a reload
        with (
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notify,
            contextlib.ExitStack() as stack,
        ):
            notify.bind(str(manager))
            appliance = stack.enter_context(running("run", "--config", file, port=port, NOTIFY_SOCKET=str(manager)))
            plc = stack.enter_context(Polling(stack.enter_context(appliance.wire())))
            line = Line(appliance, file, plc)
            line.wait_for_value()
            for inject in FAULTS:  # each once before the first look at memory
                line.suffer(inject)
            before = footprint(appliance.process.pid)
            until_s = time.monotonic() + 60 * case["minutes"]
            while time.monotonic() < until_s:
                time.sleep(chance.uniform(2, 12))
                line.suffer(chance.choice(FAULTS))
            line.wait_for_value()
            after = footprint(appliance.process.pid)
    return line.told() | {"rss_kb": [before[0], after[0]], "descriptors": [before[1], after[1]]}


def summary(rows):
    return {name: value for name, value in rows[0].items() if name not in cases()[0]}


class Line:
    """The appliance, what is done to it, and what the PLC saw."""

    def __init__(self, appliance, config, plc):
        self.appliance = appliance
        self.config = config
        self.settings = config.read_text()
        self.plc = plc
        self.back_s = {}

    def suffer(self, inject):
        begun_s = time.monotonic()
        inject(self)
        time.sleep(1)
        self.wait_for_value()
        self.back_s.setdefault(inject.__name__, []).append(time.monotonic() - begun_s)

    def wait_for_value(self):
        self.plc.first(time.monotonic(), lambda seen: seen.validity != 0, BACK_WITHIN_S)

    def station(self):
        return self.appliance.station()

    def told(self):
        seen = self.plc.seen
        waits_s = sorted(one.waited_s for one in seen)
        gaps_s = [b.at_s - a.at_s for a, b in itertools.pairwise(seen)]
        return {
            "polls": len(seen),
            "connection_lost": self.plc.lost is not None,
            "answers_over_200_ms": sum(wait_s > LATE_S for wait_s in waits_s),
            "answer_p99_ms": round(1000 * waits_s[len(waits_s) * 99 // 100], 1),
            "answer_worst_ms": round(1000 * waits_s[-1], 1),
            "pause_between_polls_worst_ms": round(1000 * max(gaps_s), 1),
            "values": sum(one.diameter_mm is not None for one in seen),
            "wrong_values": sum(map(is_wrong, seen)),
            "valid_and_older_than_900_ms": sum(bool(one.validity) and one.age_ms > 900 for one in seen),
            "faults": {name: len(times) for name, times in self.back_s.items()},
            "back_worst_s": {name: round(max(times), 1) for name, times in self.back_s.items()},
        }


def is_wrong(seen):
    if seen.diameter_mm is None:
        return False
    return min(abs(seen.diameter_mm - bar_mm) for bar_mm in BARS_MM) > max(2 * seen.expanded_mm, 1.0)


def kill_station(line):
    os.kill(line.station(), signal.SIGKILL)


def crash_station(line):
    os.kill(line.station(), signal.SIGSEGV)


def stop_station(line):
    os.kill(line.station(), signal.SIGSTOP)


def stop_station_for_a_moment(line):
    station = line.station()
    os.kill(station, signal.SIGSTOP)
    time.sleep(1.5)
    with contextlib.suppress(ProcessLookupError):
        os.kill(station, signal.SIGCONT)


def kill_camera(line):
    for renderer in children(line.station()):
        os.kill(renderer, signal.SIGKILL)


def break_settings(line):
    line.config.write_text(line.settings + "[sizzling]\n")
    line.appliance.process.send_signal(signal.SIGHUP)
    time.sleep(0.5)
    line.config.write_text(line.settings)
    line.appliance.process.send_signal(signal.SIGHUP)


def change_settings(line):
    line.settings = SETTINGS.format(port=line.appliance.port, seed=SEED, frames=FRAMES)
    line.settings += f"[sizing]\nstale_after_ms = {800 + random.randrange(99)}\n"
    line.config.write_text(line.settings)
    line.appliance.process.send_signal(signal.SIGHUP)


def babble_at_the_port(line):
    with contextlib.suppress(OSError):
        for _ in range(20):
            with socket.create_connection(("127.0.0.1", line.appliance.port), 1) as client:
                client.sendall(os.urandom(300))


def children(pid):
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(child) for task in tasks for child in task.read_text().split()]


FAULTS = (
    kill_station,
    crash_station,
    stop_station,
    stop_station_for_a_moment,
    kill_camera,
    break_settings,
    change_settings,
    babble_at_the_port,
)
