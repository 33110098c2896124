"""Whatever one client sends, another reads the same words in time."""

import random
import struct
import time
from collections.abc import Iterator

import pytest
from modbus_wire import (
    LIVE,
    Wire,
    eventually,
    exception,
    frame,
    read,
    served,
    write_and_read,
    write_coils,
    write_registers,
)

from plc.process_image import encode
from plc.security import places
from plc.server import ModbusServer

IN_TIME_S = 0.2
WORDS = encode(LIVE).words
SOUND_READS = [read(function, 0, count) for function in (1, 2, 3, 4) for count in (1, 16)] + [read(4, 300, 100)]
SOUND = [
    *SOUND_READS,
    write_registers(200, 26550, 40, 30, 1050, 1, 2, 2, 99),
    write_coils(32, True, False),
    write_and_read(0, 120, 200, 26550),
    struct.pack(">BHH", 6, 200, 26550),
    struct.pack(">BHH", 5, 33, 0xFF00),
    bytes((43, 14, 2, 0)),
]


class Witness:
    """A well-behaved client that reads the block after each misdeed of another."""

    def __init__(self, port: int) -> None:
        self._wire = Wire(port)
        self.waits_s: list[float] = []

    def __enter__(self) -> "Witness":
        return self

    def __exit__(self, *_: object) -> None:
        self._wire.socket.close()

    def check(self) -> None:
        begun_s = time.monotonic()
        answer = self._wire.ask(read(4, 0, 120))
        self.waits_s.append(time.monotonic() - begun_s)
        assert answer[2:] == WORDS

    @property
    def late(self) -> int:
        return sum(wait_s >= IN_TIME_S for wait_s in self.waits_s)


@pytest.fixture
def witness(server: ModbusServer) -> Iterator[Witness]:
    with Witness(server.port) as witness:
        yield witness


@pytest.mark.parametrize("length", [0, 1, 255, 256, 65535])
@pytest.mark.parametrize("body", [b"", b"\1", b"\1\4\0\0\0\1", bytes(300)])
def test_an_impossible_length_closes_that_connection_only(server, witness, length, body):
    with Wire(server.port, timeout_s=3) as wire:
        wire.send(struct.pack(">HHH", 1, 0, length) + body)
        assert wire.closed_by_server()
    witness.check()
    assert witness.late == 0


@pytest.mark.parametrize("protocol", [1, 0x0100, 0xFFFF])
def test_another_protocol_closes_that_connection_only(server, witness, protocol):
    with Wire(server.port, timeout_s=3) as wire:
        wire.send(struct.pack(">HHHB", 1, protocol, 6, 1) + read(4, 0, 1))
        assert wire.closed_by_server()
    witness.check()
    assert witness.late == 0


def test_the_shortest_and_the_longest_length_are_answered(wire):
    assert wire.ask(b"\4") == exception(4, 3)  # length 2
    assert wire.ask(bytes((100,)) + bytes(252)) == exception(100, 1)  # length 254


def test_sixteen_requests_of_every_kind_in_one_segment_are_answered_in_order(wire, written):
    requests = (SOUND * 2)[:16]
    wire.send(b"".join(frame(request, transaction=n) for n, request in enumerate(requests)))
    for n, request in enumerate(requests):
        answer = wire.receive_frame()
        assert struct.unpack(">H", answer[:2])[0] == n
        assert answer[7] == request[0]


def test_two_hundred_half_open_connections_keep_no_plc_out(written):
    server = ModbusServer("127.0.0.1", 0, connections_max=64)
    server.publish(encode(LIVE))
    with served(server), Witness(server.port) as in_use:
        in_use.check()
        half_open = []
        for number in range(200):
            wire = Wire(server.port)
            wire.send(frame(read(4, 0, 120))[: number % 12])  # silent, or in the middle of a request
            half_open.append(wire)
            in_use.check()
        with Witness(server.port) as newcomer:
            newcomer.check()
            assert newcomer.late == 0
        assert server.connections <= 64
        assert in_use.late == 0
        for wire in half_open:
            wire.socket.close()
        assert eventually(lambda: server.connections == 1)


def test_a_newcomer_takes_the_place_of_the_oldest_that_never_asked_and_of_no_other(server):
    silent, asked = [Wire(server.port) for _ in range(2)], [Wire(server.port) for _ in range(6)]
    for wire in asked:
        wire.ask(read(4, 0, 1))
    with Wire(server.port) as newcomer:
        assert newcomer.ask(read(4, 0, 1))[0] == 4
        assert silent[0].closed_by_server()
        assert silent[1].ask(read(4, 0, 1))[0] == 4
        with Wire(server.port, timeout_s=3) as too_many:
            assert too_many.closed_by_server()
        assert all(wire.ask(read(4, 0, 1))[0] == 4 for wire in (newcomer, silent[1], *asked))
    for wire in (*silent, *asked):
        wire.socket.close()


def hostile(chance: random.Random) -> bytes:
    """Noise, a framed random request, a good request with some bytes changed, cut or doubled."""
    kind = chance.randrange(4)
    if kind == 0:
        return chance.randbytes(chance.randint(1, 300))
    if kind == 1:
        return frame(chance.randbytes(chance.randint(1, 253)), unit=chance.randrange(256))
    good = bytearray(frame(chance.choice(SOUND), transaction=chance.randrange(65536)))
    for _ in range(chance.randint(1, 4)):
        good[chance.randrange(len(good))] = chance.randrange(256)
    if kind == 3:
        return bytes(good[: chance.randint(1, len(good))]) * chance.randint(1, 3)
    return bytes(good)


def test_ten_thousand_hostile_frames_change_nothing_that_the_gauge_says(server, witness, written):
    chance = random.Random(20261122)
    hostile_wire, connections = Wire(server.port), 1
    for _ in range(10_000):
        hostile_wire.send(hostile(chance))
        witness.check()
        if not hostile_wire.drained():
            hostile_wire.socket.close()
            hostile_wire = Wire(server.port)
            connections += 1
    hostile_wire.socket.close()
    print(f"{connections} connections, slowest read {1000 * max(witness.waits_s):.1f} ms")
    assert connections > 1000
    assert witness.late <= 3  # a busy computer may stop for a moment; the server may not
    assert server.connections <= 2


@pytest.mark.parametrize("writes", ["none", "tls"])
def test_without_permission_no_hostile_frame_writes_anything(writes):
    told = []
    server = ModbusServer("127.0.0.1", 0, writes=writes, on_write=lambda changed, _: told.append(changed))
    server.publish(encode(LIVE))
    chance = random.Random(7)
    with served(server), Wire(server.port) as wire:
        for _ in range(2000):
            request = bytearray(chance.choice(SOUND))
            request[chance.randrange(len(request))] = chance.randrange(256)
            wire.ask(bytes(request))
        assert wire.ask(read(3, 200, 8))[2:] == bytes(16)
        assert wire.ask(read(1, 32, 2)) == bytes((1, 1, 0))
    assert told == []


@pytest.mark.parametrize("function", [3, 4])
def test_a_ring_is_read_whole_or_in_part_in_both_tables(server, wire, function):
    image = encode({"reading_ring_index": 9, "reading_0_diameter": 250.0, "ingot_7_orientation": 2})
    server.publish(image)
    assert wire.ask(read(function, 300, 100))[2:] == image.reading_ring
    assert wire.ask(read(function, 420, 100))[2:] == image.ingot_ring
    assert wire.ask(read(function, 300, 1))[2:] == b"\0\x09"
    assert wire.ask(read(function, 308, 2))[2:] == struct.pack(">f", 250.0)
    for start, count in ((624, 1), (623, 107), (65535, 1)):
        assert wire.ask(read(function, start, count)) == exception(function, 2)


@pytest.mark.parametrize("address", [300, 304, 399, 420, 519])
def test_a_ring_cannot_be_written(wire, written, address):
    for request in (struct.pack(">BHH", 6, address, 1), write_registers(address, 1), write_and_read(0, 1, address, 1)):
        assert wire.ask(request) == exception(request[0], 2)
    assert written == []


def test_function_23_can_read_a_ring(wire):
    assert wire.ask(write_and_read(300, 100, 200, 26550))[:2] == bytes((23, 200))


def test_what_is_restored_is_read_back_and_told_to_nobody(written):
    server = ModbusServer("127.0.0.1", 0, writes="all", on_write=written)
    server.publish(encode(LIVE, word_order="little"))
    server.restore({"target_diameter": 26550, "product_id": 0x12345678, "hold": True})
    with served(server), Wire(server.port) as wire:
        assert struct.unpack(">8H", wire.ask(read(3, 200, 8))[2:]) == (26550, 0, 0, 0, 0x5678, 0x1234, 0, 0)
        assert wire.ask(read(1, 32, 2)) == bytes((1, 1, 0b10))
        wire.ask(write_registers(200, 26550, 0, 0, 0, 0x5678, 0x1234))
        wire.ask(write_coils(32, False, True))
    assert written == []


def test_a_client_that_leaks_connections_locks_nobody_out(written, monkeypatch):
    monkeypatch.setattr(places, "LEAK_SILENT_S", 0.5)
    server = ModbusServer("127.0.0.1", 0, connections_max=64)
    server.publish(encode(LIVE))
    with served(server), Wire(server.port, source="127.0.0.9") as plc:
        leaked = [Wire(server.port) for _ in range(63)]
        for wire in leaked:
            wire.ask(read(4, 0, 1))
        plc.ask(read(4, 0, 1))
        with Wire(server.port, source="127.0.0.8", timeout_s=3) as too_soon:
            assert too_soon.closed_by_server()
        time.sleep(0.6)
        for wire in leaked[10:]:
            wire.ask(read(4, 0, 1))
        for source in ("127.0.0.8", "127.0.0.1"):  # another client, and the one that leaks
            with Wire(server.port, source=source) as newcomer:
                assert newcomer.ask(read(4, 0, 1))[0] == 4
        assert leaked[0].closed_by_server()
        assert leaked[10].ask(read(4, 0, 1))[0] == 4
        assert plc.ask(read(4, 0, 1))[0] == 4, "a client with few places keeps them, however silent"
        for wire in leaked:
            wire.socket.close()
