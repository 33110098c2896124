"""The scan cycle of the miniature PLC against a server whose image the test sets."""

import socket
import time
from collections.abc import Iterator

import pytest
from modbus_wire import Wire, read, served

from plc.client import Plc
from plc.process_image import encode
from plc.server import ModbusServer

SET_POINTS = {"target_diameter": 265.5, "tolerance_plus": 0.4, "product_id": 70000, "steel_temperature": 1050}


@pytest.fixture
def plc(server) -> Iterator[Plc]:
    with Plc("127.0.0.1", server.port) as plc:
        yield plc


def image(**values: float):
    return encode({"heartbeat": time.monotonic_ns() & 0xFFFF, **values})


def test_a_plc_that_starts_with_zeros_and_rewrites_every_scan_sees_no_exception(server, plc, written):
    server.publish(image(validity=1))
    for _ in range(50):
        assert plc.scan() is not None
    assert plc.log == ["connected", "measurement valid"]
    assert all(changed.keys() == {"plc_heartbeat"} for changed in written)
    assert len(written) == 50
    assert server.exceptions == 0


def test_all_outputs_are_written_with_every_scan_but_told_only_once(plc, server, written):
    plc.outputs.set_points = dict(SET_POINTS)
    plc.outputs.beats = False
    plc.outputs.hold = True
    for _ in range(20):
        plc.scan()
    assert written == [
        {"target_diameter": 26550, "tolerance_plus": 40, "product_id": 70000, "steel_temperature": 1050},
        {"hold": True},
    ]
    assert server.requests == 20 * 6  # two writes and four reads a scan: the map grew beyond three


def test_the_other_word_order_is_written_as_it_is_read(server, written):
    server.publish(encode({}, word_order="little"))
    with Plc("127.0.0.1", server.port, word_order="little") as plc:
        plc.outputs.set_points = {"product_id": 70000}
        plc.scan()
    assert written[0]["product_id"] == 70000


def test_acknowledge_is_pressed_for_one_scan(server, plc, written):
    plc.outputs.beats = False
    server.publish(image(alarm_word=0b1001_0000))
    plc.scan()
    plc.press_acknowledge()
    plc.scan()
    plc.scan()
    assert written == [{"acknowledge": True}, {"acknowledge": False}]
    assert plc.log[-1] == "acknowledged alarm_stale, alarm_internal"


def test_every_event_is_one_line_when_it_happens(server, plc):
    for values in (
        {},
        {"validity": 1, "bar_sequence": 1},
        {"validity": 2, "bar_sequence": 1, "alarm_word": 0b10},
        {"validity": 0, "bar_sequence": 1, "alarm_word": 0b11010},
        {"validity": 1, "bar_sequence": 2, "alarm_word": 0b01000},
        {},
    ):
        server.publish(image(**values))
        plc.scan()
        plc.scan()
    assert plc.log == [
        "connected",
        "measurement valid",
        "bar 1",
        "alarm_out_of_tolerance came",
        "measurement not valid",
        "alarm_camera came",
        "alarm_stale came",
        "measurement valid",
        "bar 2",
        "alarm_out_of_tolerance went",
        "alarm_stale went",
        "measurement not valid",
        "alarm_camera went",
    ]


def test_a_heartbeat_that_stands_makes_the_value_invalid_even_if_it_says_valid(server, plc):
    server.publish(image(validity=1))
    plc.scan()
    time.sleep(1.1)
    plc.scan()
    server.publish(image(validity=1))
    plc.scan()
    assert plc.log == [
        "connected",
        "measurement valid",
        "heartbeat stands still",
        "measurement not valid",
        "heartbeat moves",
        "measurement valid",
    ]


def test_a_lost_connection_makes_the_value_invalid_and_is_taken_up_again():
    first = ModbusServer("127.0.0.1", 0, writes="all")
    with served(first):
        plc = Plc("127.0.0.1", first.port)
        first.publish(image(validity=1))
        assert plc.scan() is not None
    assert plc.scan() is None
    assert plc.scan() is None
    second = ModbusServer("127.0.0.1", first.port, writes="all")
    with served(second):
        second.publish(image(validity=1))
        assert plc.scan() is not None
    plc.__exit__()
    assert plc.log == [
        "connected",
        "measurement valid",
        "connection lost",
        "measurement not valid",
        "connected",
        "measurement valid",
    ]


def test_a_gauge_that_permits_no_writes_is_read_all_the_same():
    server = ModbusServer("127.0.0.1", 0, writes="none")
    with served(server), Plc("127.0.0.1", server.port) as plc:
        server.publish(image(validity=1))
        for _ in range(3):
            assert plc.scan() is not None
    assert plc.log == ["connected", "write refused with exception 1", "measurement valid"]


def test_what_is_not_seen_in_time_is_told_with_the_log(plc):
    with pytest.raises(TimeoutError, match=r"not seen within 0\.2 s.*connected"):
        plc.run(lambda snapshot: snapshot.values["validity"] == 2, 0.2)


def test_nobody_there_is_no_snapshot_and_no_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with Plc("127.0.0.1", port) as plc:
        assert plc.scan() is None
    assert plc.log == []


def test_what_was_written_can_be_read_back(server, plc):
    plc.outputs.set_points = dict(SET_POINTS)
    plc.scan()
    with Wire(server.port) as wire:
        assert wire.ask(read(3, 200, 4))[2:] == bytes.fromhex("67b6 0028 0000 041a")
