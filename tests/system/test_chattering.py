"""A camera that comes and goes, seen from the outside: alarms calm down, words of state stay true, shelving ends."""

import struct
import time
from collections.abc import Iterator

import pytest
from modbus_wire import Wire
from plc_view import look, wait_for
from rehearsal import Rehearsal, rehearsing

from appliance.sizing.stereo.settings import SizingSettings
from plc.registers import REGISTERS

pytestmark = pytest.mark.waiting

COIL = {row.name: row.address for row in REGISTERS if "coil" in row.tables}
CAMERA = 1 << COIL["alarm_camera"]
FAULT = {"unplugged": 0, "black": 4}  # bits of fault_word


@pytest.fixture
def rehearsal(tmp_path, monkeypatch) -> Iterator[Rehearsal]:
    with rehearsing("faulty_station", tmp_path, monkeypatch, SizingSettings(memory_max_mb=1500)) as rehearsal:
        yield rehearsal


@pytest.fixture
def plc(rehearsal) -> Iterator[Wire]:
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, lambda seen: seen["validity"] != 0, 60)
        yield wire


def set_coil(wire: Wire, name: str, level: bool) -> None:
    request = struct.pack(">BHH", 5, COIL[name], 0xFF00 * level)
    assert wire.ask(request) == request


def acknowledge(wire: Wire) -> None:
    set_coil(wire, "acknowledge", True)
    set_coil(wire, "acknowledge", False)


def test_in_half_a_minute_no_alarm_is_shown_anew_more_than_three_times_and_faults_stay_true(rehearsal, plc):
    begun_s, shown, before, told = time.monotonic(), dict.fromkeys(range(8), 0), 0, set()
    turn = 0
    while (now_s := time.monotonic() - begun_s) < 30:
        if now_s >= 1.8 * turn:
            rehearsal.tell(["unplugged", "measure", "black", "measure"][turn % 4])
            turn += 1
        seen = look(plc)
        for bit in shown:
            shown[bit] += bool(seen["alarm_word"] & ~before & 1 << bit)
        told |= {name for name, bit in FAULT.items() if seen["fault_word"] >> bit & 1}
        acknowledge(plc)
        before = look(plc)["alarm_word"]
        time.sleep(0.03)
    assert 1 <= shown[COIL["alarm_camera"]] <= 3
    assert max(shown.values()) <= 3, shown
    assert told == set(FAULT)


def test_a_shelved_alarm_is_not_shown_and_comes_back_when_its_shelf_ends(rehearsal, plc):
    set_coil(plc, "shelve_camera", True)
    rehearsal.tell("unplugged")
    seen = wait_for(plc, lambda seen: seen["fault_word"] & 1, 10)
    assert seen["device_state"] == 4
    time.sleep(0.5)
    seen = look(plc)
    assert not seen["alarm_word"] & CAMERA
    assert seen["alarms_shelved"] == CAMERA
    set_coil(plc, "shelve_camera", False)
    assert wait_for(plc, lambda seen: seen["alarm_word"] & CAMERA, 1)["alarms_shelved"] == 0
