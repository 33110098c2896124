"""The real program as a process of its own, as a service manager would run it."""

import contextlib
import os
import random
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from modbus_wire import Wire

HOTGAUGE = Path(sys.executable).with_name("hotgauge")
PORTS = (10_000, 32_768)  # below those that Linux gives to outgoing connections


class Appliance:
    """A running `hotgauge` that serves on a port."""

    def __init__(self, process: subprocess.Popen[str], port: int) -> None:
        self.process = process
        self.port = port

    def wire(self) -> Wire:
        return Wire(self.port)

    def station(self, name: str = "sizing") -> int:
        """Process id of a station's process."""
        until = time.monotonic() + 10
        while time.monotonic() < until:
            tasks = Path(f"/proc/{self.process.pid}/task").glob("*/children")
            children = [int(child) for task in tasks for child in task.read_text().split()]
            stations = [child for child in children if _runs(child, f"appliance.{name}.station")]
            if stations:
                (station,) = stations
                return station
            time.sleep(0.02)
        raise AssertionError("no measuring process")


def _runs(pid: int, module: str) -> bool:
    try:
        return module.encode() in Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except (FileNotFoundError, ProcessLookupError):
        return False


def free_port() -> int:
    """A TCP port of this machine on which nobody listens, and which no outgoing connection gets by itself."""
    while True:
        port = random.SystemRandom().randrange(*PORTS)
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port


def is_running(pid: int) -> bool:
    """Whether a process is there and not just waiting to be buried."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def gone_within(pid: int, seconds: float) -> bool:
    until = time.monotonic() + seconds
    while is_running(pid) and time.monotonic() < until:
        time.sleep(0.02)
    return not is_running(pid)


@contextlib.contextmanager
def running_with_log(*words: str | Path, port: int, log: Path) -> Iterator[Appliance]:
    """As `running`, with what it logs in a file."""
    with log.open("wb") as stderr, running(*words, port=port, stderr=stderr) as appliance:
        yield appliance


@contextlib.contextmanager
def running(
    *words: str | Path, port: int, stderr: int | IO[bytes] = subprocess.DEVNULL, **environment: str
) -> Iterator[Appliance]:
    """Start a serving command, wait until it says that it serves, and end it at last."""
    process = subprocess.Popen(
        [HOTGAUGE, *words], stdout=subprocess.PIPE, stderr=stderr, text=True, env=os.environ | environment
    )
    killer = threading.Timer(60, process.kill)
    killer.start()
    try:
        assert f":{port}" in process.stdout.readline()
        killer.cancel()
        yield Appliance(process, port)
    finally:
        killer.cancel()
        process.terminate()
        process.wait(10)
        process.stdout.close()
