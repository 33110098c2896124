"""Bursts of connections, and a server that has no descriptors left."""

import asyncio
import contextlib
import resource
import socket
import struct
import subprocess
import sys
import time

import pytest
from modbus_wire import Wire, eventually, read

from plc.listener import BindError, descriptors_left, listen
from plc.server import ModbusServer


def test_two_hundred_connections_that_are_reset_at_once_make_nobody_wait(server):
    for _ in range(5):
        for _ in range(200):
            with socket.create_connection(("127.0.0.1", server.port), 5) as hasty:
                hasty.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        begun_s = time.monotonic()
        with Wire(server.port) as wire:
            wire.ask(read(4, 0, 1))
        assert time.monotonic() - begun_s < 0.5
    assert eventually(lambda: server.connections == 0)


def test_a_server_that_is_busy_lets_a_thousand_wait_without_losing_one():
    """Connections that come while the event loop works are accepted after, none after a second try of a second."""
    (bound,) = listen("127.0.0.1", 0)
    begun_s = time.monotonic()
    with bound, contextlib.ExitStack() as stack:
        for _ in range(400):
            stack.enter_context(socket.create_connection(bound.getsockname(), 5))
        assert time.monotonic() - begun_s < 0.9


STARVED = """
import asyncio, os, resource, sys
from plc.server import ModbusServer

async def main():
    server = ModbusServer("127.0.0.1", 0, connections_max=1000)
    await server.start()
    if sys.argv[1] == "all":
        held = [os.open("/dev/null", os.O_RDONLY) for _ in range(20)]
    resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
    if sys.argv[1] == "all":
        try:
            while True:
                held.append(os.open("/dev/null", os.O_RDONLY))
        except OSError:
            pass
    print(server.port, flush=True)
    await asyncio.to_thread(sys.stdin.readline)
    print(server.connections, server.refused, flush=True)

import logging
logging.basicConfig()
asyncio.run(main())
"""


@pytest.mark.parametrize(("taken", "served_least"), [("none", 10), ("all", 0)])
def test_without_descriptors_every_client_is_closed_at_once_and_logged_once(taken, served_least):
    process = subprocess.Popen(
        [sys.executable, "-c", STARVED, taken],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        port = int(process.stdout.readline())
        with contextlib.ExitStack() as stack:
            wires = [stack.enter_context(Wire(port, timeout_s=5)) for _ in range(80)]
            answered = sum(answers(wire) for wire in wires)
            output, log = process.communicate("\n", timeout=10)
    finally:
        process.kill()
        process.wait()
    connections, refused = map(int, output.split())
    assert connections == answered >= served_least
    assert refused == 80 - answered
    assert log.count("\n") == 1
    assert "too many open files" in log


def answers(wire: Wire) -> bool:
    try:
        return wire.ask(read(4, 0, 1))[0] == 4
    except ConnectionError:
        return False


def test_descriptors_left_counts_those_that_can_still_be_opened():
    before = descriptors_left()
    with socket.socket(), socket.socket():
        assert descriptors_left() == before - 2
    assert before < resource.getrlimit(resource.RLIMIT_NOFILE)[0]


@pytest.mark.parametrize(
    ("host", "named"),
    [
        ("192.0.2.1", "plc.host"),  # kept for documents (RFC 5737): no computer has it
        ("no-such-host.invalid", "plc.host"),
    ],
)
def test_a_host_that_cannot_be_bound_is_named_by_its_setting(host, named):
    with pytest.raises(BindError) as refused:
        asyncio.run(ModbusServer(host, 0).start())
    assert named in refused.value.sentence
