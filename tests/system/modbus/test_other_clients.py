"""Clients that are not ours."""

import re
import shutil
import struct
import subprocess

import pytest
from modbus_wire import LIVE
from pymodbus.client import ModbusTcpClient
from pyModbusTCP.client import ModbusClient


def test_pymodbus_reads_and_writes_everything(server, written):
    with ModbusTcpClient("127.0.0.1", port=server.port, retries=0) as client:
        block = client.read_holding_registers(0, count=120)
        diameter = client.convert_from_registers(block.registers[16:18], client.DATATYPE.FLOAT32)
        assert diameter == pytest.approx(265.53, abs=1e-4)
        assert client.convert_from_registers(block.registers[12:16], client.DATATYPE.UINT64) == LIVE["timestamp"]
        assert client.read_coils(0, count=8).bits == [bool(LIVE["alarm_word"] >> n & 1) for n in range(8)]
        assert not client.write_registers(200, [26550, 40]).isError()
        assert not client.write_register(206, 2).isError()
        assert not client.write_coil(33, True).isError()
        assert client.readwrite_registers(read_address=200, read_count=2, write_address=202, values=[30]).registers == [
            26550,
            40,
        ]
        assert client.read_discrete_inputs(21, count=1).exception_code == 2
        identity = client.read_device_information(read_code=2, object_id=0).information
        assert identity[0] == b"Hotgauge"
    assert written[-2:] == [{"hold": True}, {"tolerance_minus": 30}]


def test_py_modbus_tcp_reads_the_same(server):
    client = ModbusClient(host="127.0.0.1", port=server.port, unit_id=255, timeout=2)
    try:
        words = client.read_input_registers(16, 2)
        assert struct.unpack(">f", struct.pack(">HH", *words))[0] == pytest.approx(265.53, abs=1e-4)
        assert client.read_discrete_inputs(16, 5) == [True, False, False, True, False]
        assert client.write_multiple_registers(200, [26550, 40, 30])
        assert client.read_holding_registers(200, 3) == [26550, 40, 30]
        assert client.read_input_registers(5000, 1) is None
        assert client.last_except == 2
    finally:
        client.close()


def mbpoll(port: int, *arguments: str) -> str:
    program = shutil.which("mbpoll")
    if program is None:
        pytest.fail("mbpoll is missing: install it with `apt-get install mbpoll`")
    command = [program, "-m", "tcp", "-p", str(port), "-0", "-1", "-q", *arguments]
    result = subprocess.run(command, capture_output=True, text=True, timeout=10, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.mark.parametrize("table", ["3", "4"])
def test_mbpoll_reads_the_float_most_significant_word_first(server, table):
    output = mbpoll(server.port, "-a", "1", "-t", f"{table}:float", "-B", "-r", "16", "127.0.0.1")
    (value,) = re.findall(r"^\[16\]:\s+(\S+)", output, flags=re.MULTILINE)
    assert float(value) == pytest.approx(265.53, abs=0.01)


def test_mbpoll_reads_alarm_coils_and_status(server):
    coils = mbpoll(server.port, "-a", "1", "-t", "0", "-r", "0", "-c", "8", "127.0.0.1")
    assert re.findall(r"^\[\d\]:\s+(\d)", coils, flags=re.MULTILINE) == list("01001001")
    states = mbpoll(server.port, "-a", "1", "-t", "1", "-r", "16", "-c", "5", "127.0.0.1")
    assert re.findall(r"^\[\d+\]:\s+(\d)", states, flags=re.MULTILINE) == list("10010")


def test_mbpoll_writes_a_set_point(server, written):
    mbpoll(server.port, "-a", "1", "-t", "4", "-r", "200", "127.0.0.1", "26550")
    assert written == [{"target_diameter": 26550}]
