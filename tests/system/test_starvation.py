"""A gauge without file descriptors goes on measuring and serving, and does not fill the disk with complaints."""

import contextlib
import os
import resource
import signal
import socket
import time

import pytest
from modbus_wire import eventually, frame, read
from plc_view import has_none, has_value, look, wait_for
from running import Appliance, free_port, running_with_log

DESCRIPTORS = 64
CLIENTS = 80


@pytest.fixture
def starved(tmp_path):
    """The simulated mill with 64 descriptors, and its log."""
    port = free_port()
    config = tmp_path / "gauge.toml"
    config.write_text(f"[plc]\nport = {port}\nconnections_max = 200\n")
    log = tmp_path / "log"
    with running_with_log("run", "--config", config, port=port, log=log) as gauge:
        resource.prlimit(gauge.process.pid, resource.RLIMIT_NOFILE, (DESCRIPTORS, DESCRIPTORS))
        yield gauge, log


def test_clients_beyond_the_descriptors_end_nothing_and_a_killed_measuring_process_comes_back(starved):
    gauge, log = starved
    with gauge.wire() as plc, contextlib.ExitStack() as others:
        before = wait_for(plc, has_value, 60)
        crowd = [others.enter_context(socket.create_connection(("127.0.0.1", gauge.port), 5)) for _ in range(CLIENTS)]
        for client in crowd:
            with contextlib.suppress(OSError):
                client.sendall(frame(read(4, 0, 1)))
        os.kill(gauge.station(), signal.SIGKILL)
        wait_for(plc, has_none, 5)
        seen = wait_for(plc, has_value, 60)
        assert gauge.process.poll() is None
        assert seen["clients_refused"] - before["clients_refused"] >= CLIENTS - DESCRIPTORS
        time.sleep(1)
        assert look(plc)["clients_refused"] == seen["clients_refused"]  # counted once, not with every look
    assert eventually(lambda: is_answered(gauge), 10)
    lines = log.read_text().splitlines()
    assert len(lines) < 30
    assert len([line for line in lines if "descriptors" in line or "too many open files" in line]) == 1


def is_answered(gauge: Appliance) -> bool:
    """Whether a new client is answered, now that others have gone."""
    try:
        with gauge.wire() as later:
            return look(later)["sequence"] >= 0
    except ConnectionError:
        return False
