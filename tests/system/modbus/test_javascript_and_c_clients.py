"""Clients in C and JavaScript that are not ours: libmodbus, and modbus-serial and jsmodbus from npm."""

import ctypes
import ctypes.util
import json
import shutil
import struct
import subprocess
from pathlib import Path

import pytest
from modbus_wire import LIVE

from plc.process_image import encode

SCRIPTS = Path(__file__).with_name("npm")
WORDS = list(struct.unpack(">120H", encode(LIVE).words))


@pytest.fixture(scope="session")
def npm(tmp_path_factory) -> Path:
    """Folder with the packages of package-lock.json, and the scripts beside them."""
    if shutil.which("npm") is None:
        pytest.fail("npm is missing: install it with `apt-get install npm`")
    folder = tmp_path_factory.mktemp("npm")
    for file in SCRIPTS.iterdir():
        shutil.copy(file, folder)
    subprocess.run(["npm", "ci", "--silent", "--no-audit", "--no-fund"], cwd=folder, check=True, timeout=300)
    return folder


@pytest.mark.parametrize("client", ["modbus_serial", "jsmodbus"])
def test_a_client_in_javascript_reads_the_block_and_writes_set_points_and_commands(server, written, npm, client):
    command = ["node", f"{client}.js", str(server.port)]
    result = subprocess.run(command, cwd=npm, capture_output=True, text=True, timeout=30, check=True)
    seen = json.loads(result.stdout)
    assert seen["words"] == WORDS
    assert seen["coils"] == [bool(LIVE["alarm_word"] >> bit & 1) for bit in range(8)]
    assert seen["written"] == [26550, 40, 30]
    assert written == [{"target_diameter": 26550, "tolerance_plus": 40, "tolerance_minus": 30}, {"hold": True}]


class LibModbus:
    """libmodbus by its C interface."""

    def __init__(self, port: int) -> None:
        name = ctypes.util.find_library("modbus")
        if name is None:
            pytest.fail("libmodbus is missing: install it with `apt-get install libmodbus5`")
        self.library = ctypes.CDLL(name)
        self.library.modbus_new_tcp.restype = ctypes.c_void_p
        self.context = ctypes.c_void_p(self.library.modbus_new_tcp(b"127.0.0.1", port))
        assert self.library.modbus_connect(self.context) == 0

    def call(self, name: str, *arguments) -> int:
        return getattr(self.library, name)(self.context, *arguments)

    def close(self) -> None:
        self.call("modbus_close")
        self.call("modbus_free")


def test_libmodbus_reads_the_block_and_writes_set_points_and_commands(server, written):
    client = LibModbus(server.port)
    words = (ctypes.c_uint16 * 125)()
    assert client.call("modbus_read_input_registers", 0, 120, words) == 120
    assert list(words)[:120] == WORDS
    assert client.call("modbus_read_registers", 0, 125, words) == 125  # an aligned block that ends between rows
    assert list(words) == WORDS + [0xFFFF] * 5
    bits = (ctypes.c_uint8 * 32)()
    assert client.call("modbus_read_bits", 0, 32, bits) == 32
    assert list(bits)[:8] == [LIVE["alarm_word"] >> bit & 1 for bit in range(8)]
    assert client.call("modbus_write_registers", 200, 3, (ctypes.c_uint16 * 3)(26550, 40, 30)) == 3
    assert client.call("modbus_write_bit", 33, 1) == 1
    assert client.call("modbus_read_registers", 200, 3, words) == 3
    assert list(words)[:3] == [26550, 40, 30]
    client.close()
    assert written == [{"target_diameter": 26550, "tolerance_plus": 40, "tolerance_minus": 30}, {"hold": True}]
