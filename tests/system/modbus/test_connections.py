"""Framing, patience and limits of connections, and the life of the server."""

import asyncio
import concurrent.futures
import random
import socket
import struct
import time

import pytest
from modbus_wire import (
    LIVE,
    Wire,
    eventually,
    exception,
    frame,
    read,
    served,
    write_coils,
    write_registers,
)

from plc import server as server_module
from plc.process_image import decode, encode
from plc.server import ModbusServer


@pytest.mark.parametrize("count", [2, 16, 500])
def test_all_requests_of_one_segment_are_answered_in_order(wire, count):
    wire.send(b"".join(frame(read(4, n % 120, 1), transaction=n) for n in range(count)))
    words = encode(LIVE).words
    for n in range(count):
        expected = struct.pack(">HHHBBB", n, 0, 5, 1, 4, 2) + words[2 * (n % 120) :][:2]
        assert wire.receive_frame() == expected


def test_a_request_and_a_half_are_answered_as_the_other_half_comes(wire):
    request = frame(read(4, 0, 1))
    wire.send(request + request[:5])
    assert wire.receive_frame()[7:] == bytes.fromhex("0402004d")
    wire.send(request[5:])
    assert wire.receive_frame()[7:] == bytes.fromhex("0402004d")


def test_a_sender_of_single_bytes_is_answered(wire):
    wire.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    for byte in frame(read(4, 0, 1)):
        wire.send(bytes((byte,)))
        time.sleep(0.002)
    assert wire.receive_frame()[7:] == bytes.fromhex("0402004d")


@pytest.mark.parametrize(
    "noise",
    [
        bytes.fromhex("0001 0001 0006 01 04 0000 0001"),
        bytes.fromhex("0001 0000 0000"),
        bytes.fromhex("0001 0000 0001 01"),
        bytes.fromhex("0001 0000 00ff 01 04"),
        bytes.fromhex("0001 0000 ffff 01 04"),
        b"GET / HTTP/1.1\r\n\r\n",
    ],
)
def test_a_malformed_header_closes_the_connection_at_once(server, noise):
    with Wire(server.port, timeout_s=3) as wire:
        wire.send(noise)
        assert wire.closed_by_server()


def test_requests_before_a_malformed_header_are_still_answered(wire):
    wire.send(frame(read(4, 0, 1)) + b"\0\1\0\1\0\6")
    assert wire.receive_frame()[7:] == bytes.fromhex("0402004d")
    assert wire.closed_by_server()


def test_the_longest_request_is_answered(wire):
    request = write_registers(200, *[0] * 123)
    assert len(frame(request)) == 6 + 1 + 252
    assert wire.ask(request) == exception(16, 2)
    assert wire.ask(bytes(253))[1] == 1


def test_one_connection_too_many_is_closed_and_the_others_live_on(server):
    wires = [Wire(server.port) for _ in range(8)]
    assert all(wire.ask(read(4, 0, 1))[0] == 4 for wire in wires)
    with Wire(server.port, timeout_s=3) as refused:
        assert refused.closed_by_server()
    assert server.connections == 8
    assert all(wire.ask(read(4, 0, 1))[0] == 4 for wire in wires)
    wires.pop().socket.close()
    assert eventually(lambda: server.connections == 7)
    with Wire(server.port) as welcome:
        assert welcome.ask(read(4, 0, 1))[0] == 4
    for wire in wires:
        wire.socket.close()
    assert eventually(lambda: server.connections == 0)


def test_the_gauges_own_connection_takes_nobodys_place_and_may_only_read(written):
    server = ModbusServer("127.0.0.1", 0, writes="all", connections_max=1, on_write=written)
    server.publish(encode(LIVE))

    async def connected() -> socket.socket:
        return server.connect()

    with served(server) as loop, Wire(server.port) as only:
        assert only.ask(read(4, 0, 1))[0] == 4
        with asyncio.run_coroutine_threadsafe(connected(), loop).result(5) as own:
            own.settimeout(5)
            own.sendall(frame(read(4, 0, 1)))
            assert own.recv(64)[7] == 4
            own.sendall(frame(write_coils(32, True)))
            assert own.recv(64)[7:] == exception(15, 1)
        assert only.ask(read(4, 0, 1))[0] == 4
    assert written == []


def test_a_half_sent_request_is_given_up(server, monkeypatch):
    monkeypatch.setattr(server_module, "HALF_REQUEST_S", 0.3)
    with Wire(server.port, timeout_s=2) as wire:
        begun = time.monotonic()
        wire.send(frame(read(4, 0, 1))[:7])
        assert wire.closed_by_server()
        assert 0.25 < time.monotonic() - begun < 2.0


def test_trickling_bytes_do_not_extend_the_limit_on_half_sent_requests(server, monkeypatch):
    monkeypatch.setattr(server_module, "HALF_REQUEST_S", 0.3)
    with Wire(server.port) as wire:
        wire.ask(read(4, 0, 1))
        with pytest.raises(ConnectionError):
            trickle(wire, frame(read(4, 0, 1)))


def trickle(wire: Wire, request: bytes) -> None:
    """Send a byte every 0.1 s; an open connection takes them all."""
    for byte in request:
        wire.send(bytes((byte,)))
        time.sleep(0.1)


def test_a_silent_client_outlives_the_limit_on_half_sent_requests(server, monkeypatch):
    monkeypatch.setattr(server_module, "HALF_REQUEST_S", 0.4)
    with Wire(server.port) as never_spoke, Wire(server.port) as spoke, Wire(server.port) as in_two_parts:
        spoke.ask(read(4, 0, 1))
        request = frame(read(4, 0, 1))
        in_two_parts.send(request[:4])
        time.sleep(0.03)
        in_two_parts.send(request[4:])
        in_two_parts.receive_frame()
        time.sleep(0.8)
        assert all(wire.ask(read(4, 0, 1))[0] == 4 for wire in (never_spoke, spoke, in_two_parts))


def test_vanished_peers_are_freed_by_the_kernel_within_30_s(server, wire):
    wire.ask(read(4, 0, 1))
    (connection,) = server._connections
    sock = connection._transport.get_extra_info("socket")
    assert sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE) == 1
    idle, interval, count = (
        sock.getsockopt(socket.IPPROTO_TCP, option)
        for option in (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT)
    )
    assert idle + interval * count <= 30
    assert 0 < sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) <= 30_000


def test_a_client_that_resets_its_connection_is_forgotten(server):
    with Wire(server.port) as wire:
        wire.ask(read(4, 0, 1))
        wire.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    assert eventually(lambda: server.connections == 0)


def test_a_client_that_never_reads_is_held_back_and_then_closed(server, monkeypatch):
    monkeypatch.setattr(server_module, "STALLED_S", 1.5)
    with Wire(server.port, timeout_s=0.2) as deaf, Wire(server.port) as other:
        with pytest.raises(TimeoutError):  # its own send waits: the server has stopped taking requests in
            send_without_reading(deaf, 200_000_000)
        kept = [len(c._received) + c._transport.get_write_buffer_size() for c in server._connections]
        assert len(kept) == 2
        assert max(kept) < 600_000  # one receive of 256 KiB, and one turn of answers
        assert other.ask(read(4, 0, 1))[0] == 4
        assert eventually(lambda: server.connections == 1)
        assert other.ask(read(4, 0, 1))[0] == 4


def test_a_client_that_never_reads_is_held_back_also_when_it_asks_little_at_a_time(server):
    with Wire(server.port) as deaf:
        deaf.ask(read(4, 0, 1))
        (connection,) = server._connections
        for _ in range(20_000):
            deaf.send(frame(read(4, 0, 120)) * 20)
            time.sleep(0.0002)
            if connection._write_full:
                break
        assert connection._write_full
        assert not connection._transport.is_reading()


def send_without_reading(wire: Wire, size: int) -> None:
    requests = frame(read(4, 0, 120)) * 1000
    while size > 0:
        size -= wire.socket.send(requests)


def test_a_slow_reader_gets_every_answer(server):
    requests = b"".join(frame(read(4, 0, 120), transaction=n) for n in range(40_000))
    with Wire(server.port, timeout_s=5) as wire, concurrent.futures.ThreadPoolExecutor(1) as pool:
        wire.ask(read(4, 0, 1))
        (connection,) = server._connections
        sending = pool.submit(wire.send, requests)
        assert eventually(lambda: connection._write_full)
        transactions = [struct.unpack(">H", wire.receive_frame()[:2])[0] for _ in range(40_000)]
        sending.result(5)
    assert transactions == list(range(40_000))


def test_a_flood_of_requests_does_not_make_others_wait(server):
    flood = frame(read(4, 0, 120)) * 20_000
    with Wire(server.port) as busy, Wire(server.port) as other, concurrent.futures.ThreadPoolExecutor(2) as pool:
        sending = pool.submit(busy.send, flood)
        draining = pool.submit(lambda: [busy.receive_frame() for _ in range(20_000)])
        waits = []
        while not draining.done():
            begun = time.monotonic()
            other.ask(read(4, 0, 1))
            waits.append(time.monotonic() - begun)
        sending.result(5)
        draining.result(5)
    assert sorted(waits)[len(waits) // 2] < 0.1


def test_a_half_closed_client_gets_its_answers_first(server):
    with Wire(server.port) as wire:
        wire.send(frame(read(4, 0, 1)) * 200)
        wire.socket.shutdown(socket.SHUT_WR)
        assert wire.receive(200 * 11) == bytes.fromhex("0001 0000 0005 01 04 02 004d") * 200
        assert wire.closed_by_server()


def test_random_frames_never_hurt_the_server(server, written):
    chance = random.Random(20261121)
    for _ in range(2000):
        with Wire(server.port) as wire:
            wire.send(noise(chance))
            wire.socket.shutdown(socket.SHUT_WR)
            assert wire.closed_by_server()
    with Wire(server.port) as wire:
        begun = time.monotonic()
        answer = wire.ask(read(4, 0, 120))
        assert time.monotonic() - begun < 0.2
    assert answer[2:] == encode(LIVE).words
    assert eventually(lambda: server.connections == 0)


def noise(chance: random.Random) -> bytes:
    """Pure noise, a framed random request, or a sound request with one byte flipped."""
    kind = chance.randrange(3)
    if kind == 0:
        return chance.randbytes(chance.randint(1, 300))
    if kind == 1:
        return b"".join(frame(chance.randbytes(chance.randint(1, 253))) for _ in range(chance.randint(1, 4)))
    sound = bytearray(frame(chance.choice([read(4, 0, 120), write_registers(200, 26550), write_coils(32, True)])))
    sound[chance.randrange(len(sound))] ^= 1 << chance.randrange(8)
    return bytes(sound)


def test_a_port_that_is_taken_is_an_os_error(server):
    async def start_another() -> None:
        await ModbusServer("127.0.0.1", server.port).start()

    with pytest.raises(OSError, match="address already in use"):
        asyncio.run(start_another())


def test_stopping_closes_connections_and_frees_the_port():
    server = ModbusServer("127.0.0.1", 0)
    with served(server):
        wire = Wire(server.port)
        wire.ask(read(4, 0, 1))
    assert wire.closed_by_server()
    wire.socket.close()
    with pytest.raises(ConnectionRefusedError):
        Wire(server.port)
    again = ModbusServer("127.0.0.1", server.port)
    with served(again), Wire(again.port) as wire:
        assert wire.ask(read(4, 0, 1))[0] == 4


def test_stopping_what_has_not_started_does_nothing():
    asyncio.run(ModbusServer("127.0.0.1", 0).stop())


def test_before_the_first_image_everything_reads_as_no_value():
    server = ModbusServer("127.0.0.1", 0)
    with served(server), Wire(server.port) as wire:
        values = decode(struct.unpack(">120H", wire.ask(read(4, 0, 120))[2:]))
    assert values["validity"] == 0
    assert values["diameter"] is None
    assert values["test_u32"] == 0x12345678


def test_requests_and_refusals_are_counted(server, wire):
    wire.ask(read(4, 0, 1))
    wire.ask(read(4, 9999, 1))
    assert (server.requests, server.exceptions) == (2, 1)


@pytest.mark.parametrize(
    ("wrong", "named"), [({"port": 65536}, "port"), ({"writes": "some"}, "writes"), ({"connections_max": 0}, "conn")]
)
def test_a_wrong_parameter_is_named(wrong, named):
    with pytest.raises(ValueError, match=named):
        ModbusServer(**{"host": "127.0.0.1", "port": 0} | wrong)


def test_a_single_connection_can_be_allowed():
    server = ModbusServer("127.0.0.1", 0, connections_max=1)
    server.publish(encode(LIVE))
    with served(server), Wire(server.port) as only:
        assert only.ask(read(4, 0, 1))[0] == 4
        with Wire(server.port, timeout_s=3) as refused:
            assert refused.closed_by_server()
        assert only.ask(read(4, 0, 1))[0] == 4


def test_the_last_port_that_there_is_can_be_served():
    server = ModbusServer("127.0.0.1", 65535)
    assert server.port == 65535
