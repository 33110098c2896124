"""The command poll, as a commissioning engineer uses it."""

import csv
import io
import json
import os
import pty
import subprocess

import pytest
from modbus_wire import LIVE, Wire, served, write_registers
from running import HOTGAUGE

from plc.process_image import encode
from plc.server import ModbusServer

SHOWN = LIVE | {
    "decision": 2,
    "correction": 0.25,
    "bar_mean": 265.1,
    "fault_word": 0b1,
    "reason_word": 0b10,
    "device_state": 4,
}


@pytest.fixture
def gauge():
    server = ModbusServer("127.0.0.1", 0, writes="all")
    server.publish(encode(SHOWN))
    with served(server):
        yield server


def poll(*words) -> subprocess.CompletedProcess:
    return subprocess.run([HOTGAUGE, "poll", *map(str, words)], capture_output=True, text=True, timeout=30, check=False)


def test_every_code_is_said_in_words_with_its_remedy(gauge):
    with Wire(gauge.port) as wire:
        wire.ask(write_registers(200, 26550, 40))
    said = poll("127.0.0.1", "--port", gauge.port, "--count", 1).stdout
    for words in (
        "4 failure",
        "2 out",
        "camera_lost: the cameras give no pictures; check power",
        "one_camera: ",
        "265.500 mm",
    ):
        assert words in said.replace("265.5 mm", "265.500 mm")
    assert "correction" in said
    assert "bar_mean" in said


@pytest.mark.parametrize("place", ["127.0.0.1:{port}", "localhost:{port}"])
def test_host_and_port_can_be_given_as_one(gauge, place):
    assert poll(place.format(port=gauge.port), "--count", 1).returncode == 0


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["127.0.0.1:70000"], "70000"),
        (["127.0.0.1:x"], "HOST"),
        (["a b"], "HOST"),
        (["127.0.0.1:502", "--port", "503"], "--port 503"),
    ],
)
def test_a_place_that_cannot_be_is_one_sentence(words, named):
    result = poll(*words)
    assert result.returncode == 2
    assert named in result.stderr
    assert result.stderr.count("\n") == 1


def test_the_wrong_word_order_ends_with_2_and_names_the_switch(gauge):
    for given, published in (("big", "little"), ("little", "big")):
        gauge.publish(encode(SHOWN, word_order=published))
        result = poll(f"127.0.0.1:{gauge.port}", "--word-order", given)
        assert result.returncode == 2
        assert f"--word-order {published}" in result.stderr


def test_json_and_csv_hold_the_same_values(gauge):
    lines = poll(f"127.0.0.1:{gauge.port}", "--count", 2, "--interval", 0.05, "--json").stdout.splitlines()
    (first, second) = map(json.loads, lines)
    assert first["values"] == second["values"]
    assert (first["fault_word"], first["reason_word"]) == (["camera_lost"], ["one_camera"])
    rows = list(
        csv.DictReader(io.StringIO(poll(f"127.0.0.1:{gauge.port}", "--count", 2, "--interval", 0.05, "--csv").stdout))
    )
    assert len(rows) == 2
    for name, value in first["values"].items():
        assert rows[0][name] == ("" if value is None else str(value))


def test_all_shows_every_value_of_the_block(gauge):
    said = poll(f"127.0.0.1:{gauge.port}", "--count", 1, "--all").stdout
    for name in ("ssim_top", "test_float", "diameter_u16", "alarms_shelved"):
        assert name in said


def test_on_a_terminal_it_is_one_screen_in_place(gauge):
    ours, theirs = pty.openpty()
    command = [HOTGAUGE, "poll", f"127.0.0.1:{gauge.port}", "--count", "3", "--interval", "0.05"]
    with subprocess.Popen(command, stdout=theirs) as process:
        os.close(theirs)
        seen = b""
        try:
            while part := os.read(ours, 65536):
                seen += part
        except OSError:  # the other end has been closed
            pass
        assert process.wait(10) == 0
    os.close(ours)
    assert seen.count(b"\x1b[H\x1b[J") == 3
