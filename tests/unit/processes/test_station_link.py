"""The link between a station and the supervisor: whole messages, none of half a line, no waiting."""

import socket
import threading
import time

import pytest
from messages import reading

from appliance.processes import station_process
from appliance.processes.link import StationLink
from appliance.processes.message import StateMessage
from appliance.sizing.message import MESSAGES


@pytest.fixture
def ends():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        yield ours, theirs


@pytest.mark.parametrize("message", [reading(), StateMessage(state="faulty", fault="camera_lost", detail="ü\n")])
def test_a_message_arrives_as_it_was_sent_on_one_line(ends, message):
    ours, theirs = ends
    StationLink(theirs).send(message)
    line = ours.recv(65536)
    assert line.count(b"\n") == 1
    assert MESSAGES.validate_json(line) == message


def test_nobody_who_does_not_read_can_stop_the_sender(ends):
    _, theirs = ends
    link = StationLink(theirs)
    begun_s = time.monotonic()
    for sequence in range(3000):
        link.send(reading(sequence=sequence))
    assert time.monotonic() - begun_s < 2
    assert 0 < link.dropped < 3000


def test_two_threads_that_send_lose_and_repeat_no_message():
    class Slow:
        """A connection whose `send` lets other threads run before the bytes are gone."""

        def __init__(self) -> None:
            self.received = b""

        def send(self, data: bytes, _flags: int) -> int:
            time.sleep(0.0002)
            self.received += data
            return len(data)

    slow = Slow()
    link = StationLink(slow)

    def send(first: int) -> None:
        for sequence in range(first, 400, 2):
            link.send(reading(sequence=sequence))

    threads = [threading.Thread(target=send, args=(first,)) for first in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(MESSAGES.validate_json(line).sequence for line in slow.received.splitlines()) == list(range(400))


def test_what_is_dropped_never_tears_what_is_sent(ends):
    ours, theirs = ends
    theirs.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    link = StationLink(theirs)
    received = b""
    for sequence in range(400):
        link.send(reading(sequence=sequence))
        if sequence % 7 == 0:
            received += ours.recv(777)
    ours.setblocking(False)
    for sequence in range(400, 600):
        link.send(reading(sequence=sequence))
        try:
            received += ours.recv(100_000)
        except BlockingIOError:
            continue
    numbers = [
        MESSAGES.validate_json(line).sequence for line in received.splitlines(keepends=True) if line.endswith(b"\n")
    ]
    assert numbers == sorted(set(numbers))
    assert link.dropped > 0
    assert len(numbers) == 600 - link.dropped


def test_a_supervisor_that_is_gone_is_no_error_of_the_sender(ends):
    ours, theirs = ends
    ours.close()
    StationLink(theirs).send(reading())


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"\n",
        b"{}\n",
        b"[]\n",
        b"\xff\n",
        b'{"kind":"reading"}\n',
        b'{"kind":"song"}\n',
        b'{"kind":"state","state":"x"}\n',
    ],
)
def test_a_line_that_is_no_message_is_refused(line):
    with pytest.raises(ValueError, match="validation error"):
        MESSAGES.validate_json(line)


def test_a_reading_with_a_number_that_is_none_is_refused():
    line = reading(diameter_mm=1.5).model_dump_json().replace("1.5", "NaN").encode()
    with pytest.raises(ValueError, match="diameter_mm"):
        MESSAGES.validate_json(line)


def test_a_listener_that_fails_ends_the_station_as_a_closed_link_does(ends, monkeypatch):
    ours, theirs = ends
    left, closed = [], threading.Event()
    monkeypatch.setattr(station_process, "LEAVE_TIME_S", 0.0)
    monkeypatch.setattr(station_process.os, "_exit", left.append)

    def fails(_line: bytes) -> None:
        raise RuntimeError

    link = StationLink(theirs)
    link.on_line = fails
    ours.sendall(b"{}\n")
    station_process._listen(theirs, link, closed)
    assert closed.is_set()
    assert left == [1]
