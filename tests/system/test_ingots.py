"""Ingots end to end: a recording in; a PLC sees the coil, acknowledges it, and hardly notices a killed station."""

import os
import signal
import struct
import time

import pytest
from ingot_recording import BOTTOM, EMPTY, TOP, write_recording
from modbus_wire import read
from plc_view import look, wait_for
from running import free_port, running

from plc.process_image import decode
from plc.registers import INGOT_RING

pytestmark = pytest.mark.waiting

SETTINGS = """
[plc]
port = {port}
writes = "all"
[sizing]
stale_after_ms = 10000  # a busy computer may be late; lateness has tests of its own
[sizing.liveness]
idle_after_s = 120
[sizing.camera]
kind = "mill"
seed = 5
rate_hz = 2
[ingot]
references = "{references}"
[ingot.camera]
kind = "recording"
path = "{recording}"
rate_hz = 12
loop = false
"""
ALARM = 1


@pytest.fixture
def line(recordings, tmp_path):
    """Starts the appliance on a recording made of these parts."""

    def start(*parts):
        port = free_port()
        file = tmp_path / "hotgauge.toml"
        references = recordings / "ingot_line"
        folder = write_recording(tmp_path / f"line{port}", references, *parts)
        file.write_text(SETTINGS.format(port=port, references=references, recording=folder))
        return running("run", "--config", file, port=port)

    return start


def press(wire, coil):
    for state in (0xFF00, 0x0000):
        wire.ask(struct.pack(">BHH", 5, coil, state))


def ring(wire):
    words = struct.unpack(f">{len(INGOT_RING)}H", wire.ask(read(4, INGOT_RING.start, len(INGOT_RING)))[2:])
    return decode(words, block="ingot_ring")


def test_a_top_sets_the_coil_until_it_is_acknowledged_and_a_bottom_never_does(line):
    with line(EMPTY, BOTTOM, TOP, EMPTY) as appliance, appliance.wire() as wire:
        seen = wait_for(wire, lambda seen: seen["ingot_validity"] != 0, 40)
        assert seen["ingot_orientation"] == 2
        assert seen["ingot_confidence"] > 99
        assert not seen["alarm_word"] & ALARM
        seen = wait_for(wire, lambda seen: seen["alarm_word"] & ALARM, 40)
        assert wire.ask(read(1, 0, 1))[2:] == b"\x01"
        told = ring(wire)
        assert [told[f"ingot_{slot}_orientation"] for slot in range(2)] == [2, 1]
        assert 1000 * time.time() - told["ingot_1_timestamp"] < 200 + 20  # of which 20 ms between two looks
        wait_for(wire, lambda seen: seen["ingot_orientation"] == 0, 40)
        time.sleep(1.5)
        assert look(wire)["alarm_word"] & ALARM, "it must stay until it is acknowledged"
        press(wire, 32)
        wait_for(wire, lambda seen: not seen["alarm_word"] & ALARM, 1)
        assert look(wire)["ingot_sequence"] == 2


def test_a_killed_ingot_station_leaves_the_bar_alone(line):
    with line(EMPTY, *[BOTTOM] * 8) as appliance, appliance.wire() as wire:
        wait_for(wire, lambda seen: seen["ingot_validity"] and seen["validity"], 40)
        sizing = appliance.station("sizing")
        os.kill(appliance.station("ingot"), signal.SIGKILL)
        gone = wait_for(wire, lambda seen: seen["ingot_validity"] == 0 and seen["ssim_top"] is None, 1)
        assert gone["measurement_age"] is not None
        assert gone["ingot_sequence"] >= 1
        back = wait_for(wire, lambda seen: seen["ingot_validity"] != 0, 40)
        assert back["ingot_sequence"] > gone["ingot_sequence"] - 1
        assert appliance.station("sizing") == sizing
