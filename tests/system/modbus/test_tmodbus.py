"""tModbus, a client that nobody here wrote and that speaks Modbus by TLS; it needs Python 3.12 or later."""

import asyncio
import ssl
import struct

import pytest
from modbus_wire import LIVE
from tls_wire import context

from plc.process_image import encode

tmodbus = pytest.importorskip("tmodbus", reason="tModbus is installed from Python 3.12 on")


def asked(port: int, questions, certificate: ssl.SSLContext | None = None):
    """What `questions(client)` gives with a connected client."""

    async def ask():
        client = tmodbus.create_async_tcp_client(
            "127.0.0.1", port, unit_id=255, timeout=3.0, auto_reconnect=False, ssl=certificate
        )
        async with client:
            return await questions(client)

    return asyncio.run(ask())


async def reads(client) -> tuple[list[int], list[bool]]:
    return await client.read_input_registers(0, 120), await client.read_coils(0, 8)


async def sets_a_target(client) -> None:
    await client.write_multiple_registers(200, [26550, 40])


def test_it_reads_the_same_plain_and_by_tls(server, secure_server, folder):
    plain = asked(server.port, reads)
    assert plain == asked(secure_server._secure.port, reads, context(folder, "viewer"))
    words, alarms = plain
    assert struct.pack(">120H", *words) == encode(LIVE).words
    assert alarms == [bool(LIVE["alarm_word"] >> bit & 1) for bit in range(8)]


def test_it_writes_the_same_set_points_plain_and_by_tls(server, secure_server, folder, written):
    asked(server.port, sets_a_target)
    asked(secure_server._secure.port, sets_a_target, context(folder, "engineer"))
    assert written == [{"target_diameter": 26550, "tolerance_plus": 40}] * 2


def test_a_viewer_that_writes_gets_exception_1_and_changes_nothing(secure_server, folder, written):
    with pytest.raises(tmodbus.exceptions.IllegalFunctionError):
        asked(secure_server._secure.port, sets_a_target, context(folder, "viewer"))
    assert written == []


def test_without_a_certificate_it_gets_nothing(secure_server, folder, written):
    with pytest.raises((OSError, tmodbus.exceptions.TModbusError)):
        asked(secure_server._secure.port, reads, context(folder, None))
    assert written == []
