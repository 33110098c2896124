"""A path-traced recording, calibrated, replayed and read by clients that nobody here wrote."""

import json
import re
import shutil
import socket
import struct
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from plc_view import has_value, look, wait_for
from pyModbusTCP.client import ModbusClient
from running import HOTGAUGE, Appliance, free_port, running

from plc.registers import REGISTERS

pytestmark = pytest.mark.waiting

ADDRESS = next(row.address for row in REGISTERS if row.name == "diameter")


@pytest.fixture(scope="module")
def scene(recordings) -> Path:
    return recordings / "line_a" / "scenes" / "s1_clean"


@pytest.fixture(scope="module")
def diameter_mm(scene) -> float:
    return json.loads((scene / "truth.json").read_text())["diameter_mm"]


@pytest.fixture(scope="module")
def appliance(recordings, scene, tmp_path_factory) -> Iterator[Appliance]:
    folder = tmp_path_factory.mktemp("replay")
    rig, config = folder / "rig.json", folder / "hotgauge.toml"
    subprocess.run([HOTGAUGE, "calibrate", recordings / "line_a", "--output", rig], check=True, capture_output=True)
    port = free_port()
    config.write_text(f"[plc]\nport = {port}\n")
    with running("replay", scene, "--rig", rig, "--config", config, port=port) as appliance:
        with appliance.wire() as wire:
            wait_for(wire, has_value, 20)
        yield appliance


def test_mbpoll_reads_the_diameter(appliance, diameter_mm):
    assert shutil.which("mbpoll"), "mbpoll is missing; install the Debian package mbpoll"
    words = ["mbpoll", "-m", "tcp", "-a", "1", "-p", appliance.port, "-0", "-1", "-B", "-r", ADDRESS, "127.0.0.1"]
    for table in ("3:float", "4:float"):
        command = [str(word) for word in (*words[:-1], "-t", table, words[-1])]
        said = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True).stdout
        value = re.search(rf"^\[{ADDRESS}\]:\s+(\S+)", said, re.MULTILINE)
        assert float(value[1]) == pytest.approx(diameter_mm, abs=0.3)


def test_pymodbustcp_reads_the_diameter(appliance, diameter_mm):
    client = ModbusClient(host="127.0.0.1", port=appliance.port, unit_id=1, timeout=5)
    try:
        for read in (client.read_input_registers, client.read_holding_registers):
            (value,) = struct.unpack(">f", struct.pack(">2H", *read(ADDRESS, 2)))
            assert value == pytest.approx(diameter_mm, abs=0.3)
    finally:
        client.close()


def test_the_bytes_on_the_wire_are_those_of_the_protocol(appliance, diameter_mm):
    with socket.create_connection(("127.0.0.1", appliance.port), timeout=5) as plc:
        plc.sendall(bytes.fromhex("0007 0000 0006 01 04 0010 0002"))
        answer = plc.recv(64)
    assert ADDRESS == 0x10
    assert answer[:9] == bytes.fromhex("0007 0000 0007 01 04 04")
    assert len(answer) == 13
    assert struct.unpack(">f", answer[9:])[0] == pytest.approx(diameter_mm, abs=0.3)


def test_a_recording_is_served_as_simulated_and_again_and_again(appliance):
    with appliance.wire() as wire:
        first = look(wire)
        later = wait_for(wire, lambda seen: seen["sequence"] - first["sequence"] > 5, 10)
    assert later["device_state"] == 3
    assert later["status_word"] >> 4 & 1
    assert later["timestamp"] > first["timestamp"]
