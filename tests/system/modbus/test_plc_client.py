"""The miniature PLC against our server and against what is not a gauge."""

import dataclasses
import itertools
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from types import SimpleNamespace

import pytest
from modbus_wire import served

from plc.poll import PollError, poll, snapshot_lines
from plc.process_image import encode
from plc.server import ModbusServer

LIVE = {
    "sequence": 7,
    "heartbeat": 1234,
    "validity": 2,
    "reason_word": 1 << 17,
    "device_state": 3,
    "diameter": 265.53,
    "expanded_uncertainty": 0.21,
    "timestamp": 1_790_000_000_123,
    "alarm_word": 0b1001_0000,
    "measurement_valid": True,
    "simulated": True,
}


@pytest.fixture
def server() -> Iterator[ModbusServer]:
    server = ModbusServer("127.0.0.1", 0)
    server.publish(encode(LIVE))
    with served(server):
        yield server


def test_a_snapshot_holds_what_was_published(server):
    snapshot = next(poll("127.0.0.1", server.port))
    assert snapshot.values["diameter"] == pytest.approx(265.53, abs=1e-4)
    assert snapshot.values["diameter_u16"] == 265.53
    assert snapshot.values["diameter_cold"] is None
    assert snapshot.discretes["simulated"]
    assert not snapshot.discretes["bar_present"]
    assert snapshot.alarms == ["alarm_stale", "alarm_internal"]
    assert snapshot.whole
    assert snapshot.word_order_fits


def test_polling_follows_what_is_published_at_the_rate_asked_for(server):
    begun = time.monotonic()
    seen = []
    for snapshot in itertools.islice(poll("127.0.0.1", server.port, every_s=0.05), 5):
        seen.append(snapshot.values["sequence"])
        server.publish(encode({"sequence": 10 * len(seen)}))
    assert seen == [7, 10, 20, 30, 40]
    assert 0.2 <= time.monotonic() - begun < 2.0


def test_a_poll_that_is_late_is_followed_by_the_next_one_at_once(server):
    begun = time.monotonic()
    assert len(list(itertools.islice(poll("127.0.0.1", server.port, every_s=0.001), 20))) == 20
    assert time.monotonic() - begun < 1.5  # a pause of 0.1 s after each would make it 2


def test_how_long_a_poll_took_is_said_in_milliseconds(server, monkeypatch):
    moments_s = itertools.count(100.0, 0.25)
    monkeypatch.setattr("plc.poll.time", SimpleNamespace(monotonic=lambda: next(moments_s), sleep=lambda _: None))
    (snapshot,) = itertools.islice(poll("127.0.0.1", server.port), 1)
    assert snapshot.elapsed_ms == pytest.approx(250.0, rel=1e-4)


def test_the_other_word_order_is_read_when_it_is_asked_for_and_noticed_when_not(server):
    server.publish(encode(LIVE, word_order="little"))
    assert next(poll("127.0.0.1", server.port, word_order="little")).values["timestamp"] == LIVE["timestamp"]
    wrong = next(poll("127.0.0.1", server.port))
    assert not wrong.word_order_fits
    assert "word order" in snapshot_lines(wrong)[0]


def test_lines_for_people_say_every_main_value_or_that_there_is_none(server):
    text = "\n".join(snapshot_lines(next(poll("127.0.0.1", server.port))))
    assert "diameter                  265.530 mm" in text
    assert "diameter_cold             no value" in text
    assert "2 valid with reasons, reasons 0x00020000" in text
    assert "3 test, not for control" in text
    assert "2026-09-21 14:13:20.123" in text
    assert "measurement_valid, simulated" in text
    assert "alarm_stale, alarm_internal" in text
    assert "torn" not in text


def test_a_torn_block_is_told(server):
    image = encode(LIVE)
    server.publish(dataclasses.replace(image, words=image.words[:-1] + b"\x08"))
    snapshot = next(poll("127.0.0.1", server.port))
    assert not snapshot.whole
    assert "torn" in snapshot_lines(snapshot)[-1]


def test_nobody_there_is_one_sentence_with_the_place():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with pytest.raises(PollError, match=f"127.0.0.1:{port}: nobody answers; check"):
        next(poll("127.0.0.1", port))
    program = f"from plc.poll import PollError, poll\ntry: next(poll('127.0.0.1', {port}))\nexcept PollError: pass"
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=20, check=True)
    assert result.stderr == b""  # the library below prints nothing beside the sentence


def test_a_gauge_that_goes_away_is_told():
    server = ModbusServer("127.0.0.1", 0)
    with served(server):
        scans = poll("127.0.0.1", server.port, every_s=0)
        next(scans)
    with pytest.raises(PollError, match="connection lost"):
        next(scans)


def test_a_device_that_is_no_gauge_is_told():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=refuse_everything, args=(listener,))
        thread.start()
        with pytest.raises(PollError, match="answers Modbus exception 2"):
            next(poll("127.0.0.1", listener.getsockname()[1]))
        thread.join()


def refuse_everything(listener: socket.socket) -> None:
    connection, _ = listener.accept()
    with connection:
        while request := connection.recv(12):
            connection.sendall(request[:4] + b"\0\3" + request[6:7] + bytes((request[7] | 0x80, 2)))
