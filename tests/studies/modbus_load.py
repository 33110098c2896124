"""Modbus under load: our server beside the library's on the same words, the whole appliance, and endurance.

Loopback only. `secure` is our server with TLS 1.3 and certificates on both sides. The clients are one process with one
socket each, the server another, so that on two cores each has its own. `python -m studies.modbus_load
ours|secure|library` is the server process.
"""

import asyncio
import contextlib
import os
import select
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from modbus_wire import LIVE, Wire, frame, read
from running import free_port, running
from tls_wire import TlsWire
from torn_reads import agrees_with_itself

from plc.process_image import encode
from plc.security.certificates import Authority
from plc.security.identity import TlsFiles
from plc.security.roles import Role
from plc.security.secure_port import SecurePort
from plc.server import ModbusServer

TEXT = (
    "Reads of the whole block (120 input registers) over loopback. `server`: requests as fast as they are answered, "
    "4 s each; `appliance`: 16 clients every 10 ms for 60 s while the simulated mill is measured as fast as it can "
    "be, times from the moment that a request was due; `endurance`: 500,000 requests and 5,000 connections."
)
REPEATABLE = False  # times are those of the computer
SECONDS = 4.0
APPLIANCE_S = 60.0
REQUEST = frame(read(4, 0, 120))
ANSWER_BYTES = 7 + 2 + 240
PUBLISH_S = 0.05


def cases():
    servers = [
        {"part": "server", "clients": clients, "server": server}
        for clients in (1, 16, 64)
        for server in ("ours", "secure", "library")
    ]
    return [*servers, {"part": "appliance", "clients": 16}, {"part": "endurance", "clients": 16}]


def run(case):
    return {"server": run_server, "appliance": run_appliance, "endurance": run_endurance}[case["part"]](case)


def run_server(case, seconds=SECONDS):
    with server_process(case["server"]) as (_, port, folder):
        load = Load(port, case["clients"], folder if case["server"] == "secure" else None)
        begun_s = time.monotonic()
        waits_s = load.ask_until(lambda: time.monotonic() - begun_s > seconds)
        elapsed_s = time.monotonic() - begun_s
        load.close()
    return {"requests_per_s": round(len(waits_s) / elapsed_s), **percentiles(waits_s)}


def run_appliance(case, seconds=APPLIANCE_S):
    port = free_port()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "hotgauge.toml"
        file.write_text(f'[plc]\nport = {port}\n[sizing.camera]\nkind = "mill"\nrate_hz = 60\n')
        with running("run", "--config", file, port=port) as appliance:
            time.sleep(5)  # calibration of the mill's cameras
            load = Load(port, case["clients"])
            load.ask_every(0.01, 1.0)
            before = footprint(appliance.process.pid)
            load.blocks.clear()
            waits_s = load.ask_every(0.01, seconds)
            after = footprint(appliance.process.pid)
            load.close()
    torn = sum(not agrees_with_itself(words) for words in load.blocks)
    sequences = {words[:2] for words in load.blocks}
    return {
        "requests": len(waits_s),
        **percentiles(waits_s),
        "torn": torn,
        "readings_per_s": round(len(sequences) / seconds, 1),
        **grown(before, after),
    }


def run_endurance(case, requests=500_000, connections=5_000):
    with server_process("ours") as (pid, port, _):
        load = Load(port, case["clients"])
        load.ask_until(lambda: load.answered >= requests // 10)
        come_and_go(port, connections // 10)
        before = footprint(pid)
        load.answered = 0
        load.ask_until(lambda: load.answered >= requests)
        come_and_go(port, connections)
        after = footprint(pid)
        load.close()
    return {"requests": requests, "connections": connections, **grown(before, after)}


def summary(rows):
    def key(one):
        return " ".join(str(one[name]) for name in ("part", "server", "clients") if name in one)

    return {key(one): {name: value for name, value in one.items() if name not in cases()[0]} for one in rows}


class Load:
    """Clients of one process, each with at most one request under way."""

    def __init__(self, port, clients, folder=None):
        self._wires = [Wire(port) if folder is None else TlsWire(port, folder, "plc") for _ in range(clients)]
        self._poll = select.epoll()
        self._by_number = {wire.socket.fileno(): wire.socket for wire in self._wires}
        for number in self._by_number:
            self._poll.register(number, select.EPOLLIN)
        self.answered = 0
        self.blocks = set()

    def close(self):
        self._poll.close()
        for wire in self._wires:
            wire.socket.close()

    def ask_until(self, over):
        """Each client asks again as soon as it is answered; seconds from request to answer."""
        waits_s, asked_s = [], {}
        for number, connection in self._by_number.items():
            asked_s[number] = time.perf_counter()
            connection.send(REQUEST)
        while asked_s:
            for number in self._answered(1.0):
                now_s = time.perf_counter()
                waits_s.append(now_s - asked_s.pop(number))
                if not over():
                    asked_s[number] = now_s
                    self._by_number[number].send(REQUEST)
        return waits_s

    def ask_every(self, period_s, seconds):
        """Each client asks once in each period, the clients evenly spread; seconds from due to answer."""
        begun_s = time.perf_counter()
        due_s = {number: begun_s + place * period_s / 16 for place, number in enumerate(self._by_number)}
        under_way, waits_s = {}, []
        while due_s or under_way:
            now_s = time.perf_counter()
            for number in [number for number, moment_s in due_s.items() if moment_s <= now_s]:
                under_way[number] = due_s.pop(number)
                self._by_number[number].send(REQUEST)
            pause_s = max(0.0, min(due_s.values(), default=now_s + 1) - now_s)
            for number in self._answered(pause_s):
                asked_s = under_way.pop(number)
                waits_s.append(time.perf_counter() - asked_s)
                if asked_s + period_s - begun_s < seconds:
                    due_s[number] = asked_s + period_s
        return waits_s

    def _answered(self, within_s):
        """Clients that have their whole answer."""
        for number, _ in self._poll.poll(within_s):
            answer = self._by_number[number].recv(4096)
            assert len(answer) == ANSWER_BYTES, answer
            self.blocks.add(answer[9:])
            self.answered += 1
            yield number


def come_and_go(port, connections):
    for _ in range(connections):
        with Wire(port) as wire:
            wire.ask(read(4, 0, 120))


def percentiles(waits_s):
    ordered = sorted(waits_s)
    return {f"p{share}_ms": round(1000 * ordered[len(ordered) * share // 100], 3) for share in (50, 99)}


def footprint(pid):
    time.sleep(0.5)  # connections that have just come or gone
    status = Path(f"/proc/{pid}/status").read_text()
    rss_kb = next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmRSS"))
    return rss_kb, len(list(Path(f"/proc/{pid}/fd").iterdir()))


def grown(before, after):
    return {"rss_kb": [before[0], after[0]], "descriptors": [before[1], after[1]]}


@contextlib.contextmanager
def server_process(name):
    """Process id and port of a server that serves the block and nothing else."""
    # a server whose lines are counted for coverage is no fair match for the library's, whose lines are not
    environment = {key: value for key, value in os.environ.items() if not key.startswith("COVERAGE_")}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
    process = subprocess.Popen(
        [sys.executable, "-m", "studies.modbus_load", name],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        port, folder = process.stdout.readline().split(maxsplit=1)
        yield process.pid, int(port), Path(folder.strip())
    finally:
        process.terminate()
        process.wait(10)
        process.stdout.close()


async def serve_ours(folder, *, secure):
    if secure:
        authority = Authority.make()
        authority.save(folder)
        authority.server(folder, ["127.0.0.1"])
        authority.client(folder, "plc", Role.ENGINEER)
        files = TlsFiles(folder / "server.pem", folder / "server.key", folder / "authority.pem")
        server = ModbusServer("127.0.0.1", None, secure=SecurePort(0, files))
    else:
        server = ModbusServer("127.0.0.1", 0)
    server.publish(encode(LIVE))
    await server.start()
    print(server.secure.port if secure else server.port, folder, flush=True)
    sequence = 0
    while True:
        await asyncio.sleep(PUBLISH_S)
        sequence += 1
        server.publish(encode(LIVE | {"sequence": sequence}))


async def serve_library():
    """The library's server on words that do not change, which spares it the publishing."""
    from pymodbus.server import ModbusTcpServer  # noqa: PLC0415
    from pymodbus.simulator import DataType, SimData, SimDevice  # noqa: PLC0415

    words = list(struct.unpack(">120H", encode(LIVE).words))
    bits = [SimData(0, values=[False] * 16, datatype=DataType.BITS)]
    registers = [SimData(0, values=words, datatype=DataType.REGISTERS)]
    device = SimDevice(id=1, simdata=(bits, bits, registers, registers))
    port = free_port()
    server = ModbusTcpServer(device, address=("127.0.0.1", port))
    await server.serve_forever(background=True)
    print(port, "-", flush=True)
    await asyncio.Event().wait()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as certificates:
        secure = sys.argv[1] == "secure"
        ours = secure or sys.argv[1] == "ours"
        asyncio.run(serve_ours(Path(certificates), secure=secure) if ours else serve_library())
