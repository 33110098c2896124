"""Who may write on the plain port, and what is logged of those who write and of those who may not."""

import contextlib
import logging
import random
import socket
import struct
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
from plc.registers import MAP_VERSION
from plc.security.addresses import Network
from plc.server import ModbusServer

WRITES = [
    struct.pack(">BHH", 5, 32, 0xFF00),
    struct.pack(">BHH", 6, 200, 26550),
    write_coils(32, True, True),
    write_registers(200, 26550, 40, 30),
    write_and_read(0, 1, 200, 26550),
]


@contextlib.contextmanager
def gauge(written, **options) -> Iterator[ModbusServer]:
    server = ModbusServer("127.0.0.1", 0, on_write=written, **options)
    server.publish(encode(LIVE))
    with served(server):
        yield server


def test_only_addresses_in_the_list_may_write_and_everybody_may_read(written):
    writers = [Network.parse("127.0.0.5"), Network.parse("127.1.0.0/16")]
    with gauge(written, writes="all", writers=writers) as server:
        for address in ("127.0.0.1", "127.0.0.6", "127.2.0.1"):
            with Wire(server.port, source=address) as wire:
                assert [wire.ask(request) for request in WRITES] == [exception(one[0], 1) for one in WRITES]
                assert wire.ask(read(4, 0, 120))[2:] == encode(LIVE).words
        assert written == []
        for address in ("127.0.0.5", "127.1.2.3"):
            with Wire(server.port, source=address) as wire:
                assert all(wire.ask(request)[0] == request[0] for request in WRITES)
    assert written[0] == {"acknowledge": True}


def test_every_write_is_logged_with_role_address_old_and_new_value(written, caplog):
    caplog.set_level(logging.INFO, "hotgauge.clients")
    with gauge(written, writes="all") as server, Wire(server.port) as wire:
        wire.ask(write_registers(200, 26550, 40))
        wire.ask(write_registers(200, 25000, 40))
        wire.ask(write_registers(200, 25000, 40))  # equal: nothing to log
        wire.ask(write_coils(32, False, True))
        for beat in range(20):
            wire.ask(write_registers(207, beat))
    lines = [record.getMessage() for record in caplog.records if record.name == "hotgauge.clients"]
    assert lines == [
        "written by 127.0.0.1 (engineer): target_diameter 0.00 mm -> 265.50 mm, tolerance_plus 0.00 mm -> 0.40 mm",
        "written by 127.0.0.1 (engineer): target_diameter 265.50 mm -> 250.00 mm",
        "written by 127.0.0.1 (engineer): hold 0 -> 1",
    ]


def test_a_client_that_writes_without_end_does_not_fill_the_log_and_what_is_left_out_is_counted(written, caplog):
    caplog.set_level(logging.INFO, "hotgauge.clients")
    with gauge(written, writes="all") as server, Wire(server.port) as wire:
        for number in range(3000):
            wire.ask(write_registers(200, 10000 + number))
    assert len(written) == 3000
    assert 200 <= len(caplog.records) < 300


def test_a_client_without_right_is_logged_once_however_often_it_tries(written, caplog):
    with gauge(written, writes="tls") as server:
        for _ in range(5):
            with Wire(server.port) as wire:
                for _ in range(100):
                    wire.ask(write_registers(200, 26550))
    (line,) = [record.getMessage() for record in caplog.records if record.name == "hotgauge.clients"]
    assert "127.0.0.1" in line
    assert 'plc.writes is "tls"' in line


def test_a_writer_gets_a_place_although_others_have_taken_them_all(written):
    writers = [Network.parse("127.0.0.5")]
    with gauge(written, writes="all", writers=writers, connections_max=4) as server:
        others = [Wire(server.port, source="127.0.0.9") for _ in range(4)]
        assert all(wire.ask(read(4, 0, 1))[0] == 4 for wire in others)
        with Wire(server.port, source="127.0.0.9") as one_more:
            assert one_more.closed_by_server()
        with Wire(server.port, source="127.0.0.5") as plc:
            assert plc.ask(write_registers(200, 26550))[0] == 16
            assert others[0].closed_by_server()
            assert all(wire.ask(read(4, 0, 1))[0] == 4 for wire in others[1:])
        for wire in others:
            wire.socket.close()


def test_half_open_connections_of_one_address_take_no_place_from_a_newcomer_of_another(written):
    with gauge(written, connections_max=4) as server, Wire(server.port, source="127.0.0.8") as hesitant:
        flood = [Wire(server.port, source="127.0.0.9") for _ in range(20)]
        assert eventually(lambda: server.connections == 4)
        assert hesitant.ask(read(4, 0, 1))[0] == 4
        for wire in flood:
            wire.socket.close()


def test_two_thousand_random_requests_without_right_change_nothing(written):
    chance = random.Random(20261129)
    before = encode(LIVE).words
    with gauge(written, writes="none") as server, Wire(server.port) as wire:
        for _ in range(2000):
            body = bytearray(chance.choice(WRITES))
            for _ in range(chance.randrange(4)):
                body[chance.randrange(1, len(body))] = chance.randrange(256)
            wire.send(frame(bytes(body), unit=chance.choice([0, 1, 255])))
            assert wire.receive_frame()[7] & 0x80
        assert wire.ask(read(4, 0, 120))[2:] == before
        assert wire.ask(read(3, 200, 8))[2:] == bytes(16)
        assert wire.ask(read(1, 32, 2)) == bytes((1, 1, 0))
    assert written == []


@pytest.mark.parametrize(
    ("host", "places"), [("::", ["127.0.0.1", "::1"]), ("::1", ["::1"]), ("localhost", ["127.0.0.1"])]
)
def test_the_server_binds_to_names_and_to_both_kinds_of_addresses(written, host, places):
    server = ModbusServer(host, 0, on_write=written)
    with served(server):
        for place in places:
            with socket.create_connection((place, server.port), timeout=5) as client:
                client.sendall(frame(read(4, 1, 1)))
                assert client.recv(64)[7:] == bytes((4, 2, 0, MAP_VERSION))


def test_an_ipv4_writer_is_known_also_when_it_comes_through_an_ipv6_socket(written):
    server = ModbusServer("::", 0, writes="all", writers=[Network.parse("127.0.0.5")], on_write=written)
    with served(server):
        with Wire(server.port, source="127.0.0.5") as wire:
            assert wire.ask(write_registers(200, 26550))[0] == 16
        with Wire(server.port, source="127.0.0.6") as wire:
            assert wire.ask(write_registers(200, 26550)) == exception(16, 1)
