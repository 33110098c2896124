"""What a PLC writes, seen over the wire: set points and what comes of them, hold, acknowledgement, and what is kept."""

import struct
import time

import pytest
from modbus_wire import Wire, eventually, read, write_coils, write_registers
from plc_view import acknowledge, has_none, has_value, look, look_at_bits, wait_for

from appliance.conformity.plc_inputs import FILE_NAME
from appliance.diagnostics.fault_table import FAULTS
from plc.codes import Decision, DeviceState
from plc.registers import REGISTERS, SET_POINTS
from vision.reasons import Reason


def set_points(wire: Wire, *words: int) -> None:
    """Write target, tolerances, temperature, product number, grade and heartbeat, from the first on."""
    assert wire.ask(write_registers(SET_POINTS.start, *words))[0] == 16


def alarms(wire: Wire) -> set[str]:
    return {name for name, on in look_at_bits(wire).items() if on and name.startswith("alarm")}


def test_hold_is_function_check_without_value_and_alarms_until_it_ends(rehearsal, wire):
    wait_for(wire, has_value, 5)
    wire.ask(write_coils(33, True))
    seen = wait_for(wire, has_none, 0.3)
    assert seen["reason_word"] == Reason.HELD
    assert seen["diameter"] is None
    assert seen["device_state"] == DeviceState.FUNCTION_CHECK
    assert wire.ask(read(1, 32, 2)) == bytes((1, 1, 0b10))
    rehearsal.tell("fault camera_lost")
    wait_for(wire, lambda seen: seen["device_state"] == DeviceState.FAILURE, 1)
    assert alarms(wire) == set()
    wire.ask(write_coils(33, False))
    assert eventually(lambda: alarms(wire) == {"alarm_camera"}, 0.3)


def test_an_alarm_is_acknowledged_on_the_rising_edge_only(rehearsal, wire):
    wait_for(wire, has_value, 5)
    assert wire.ask(write_coils(32, True))[0] == 15  # and left at 1
    rehearsal.tell("fault camera_lost")
    wait_for(wire, has_none, 1)
    rehearsal.tell("measure")
    wait_for(wire, has_value, 1)
    time.sleep(1.2)
    wire.ask(write_coils(32, True))
    time.sleep(0.2)
    assert alarms(wire) == {"alarm_camera"}
    wire.ask(write_coils(32, False))
    time.sleep(0.2)
    assert alarms(wire) == {"alarm_camera"}
    wire.ask(write_coils(32, True))
    assert eventually(lambda: not alarms(wire), 0.2)


def test_a_bar_out_of_tolerance_is_decided_alarmed_and_corrected(wire):
    wait_for(wire, has_value, 5)
    set_points(wire, 30000, 200, 200)
    seen = wait_for(wire, lambda seen: seen["decision"] == 2, 1)
    assert seen["deviation"] == pytest.approx(seen["diameter"] - 300, abs=1e-3)
    assert eventually(lambda: alarms(wire) == {"alarm_out_of_tolerance"}, 1)
    seen = wait_for(wire, lambda seen: seen["correction"] == 1.0, 3)
    set_points(wire, 0)
    seen = wait_for(wire, lambda seen: seen["decision"] == 0, 0.3)
    assert seen["deviation"] is None
    assert seen["correction"] is None


def test_a_temperature_and_a_grade_give_the_cold_size(wire):
    wait_for(wire, has_value, 5)
    assert look(wire)["diameter_cold"] is None
    set_points(wire, 0, 0, 0, 1050, 0, 0, 1)
    seen = wait_for(wire, lambda seen: seen["diameter_cold"] is not None, 0.3)
    assert seen["diameter_cold"] == pytest.approx(seen["diameter"] / 1.0148, abs=0.01)
    assert seen["diameter_cold_u16"] == pytest.approx(seen["diameter_cold"], abs=0.006)


def test_a_low_trust_is_an_alarm_when_it_lasts(wire):
    wait_for(wire, has_value, 5)
    set_points(wire, 0, 1, 1)  # a tolerance of 0.02 mm: U of 0.2 mm is far too much for it
    seen = wait_for(wire, lambda seen: (seen["trust"] or 0) < 10, 0.3)
    assert has_value(seen)
    assert not alarms(wire)
    assert eventually(lambda: alarms(wire) == {"alarm_low_trust"}, 2)


def test_a_plc_that_falls_silent_is_an_alarm_once_it_has_spoken(wire):
    wait_for(wire, has_value, 5)
    time.sleep(1.2)
    for beat in range(1, 15):
        assert not alarms(wire)
        set_points(wire, 0, 0, 0, 0, 0, 0, 0, beat)
        time.sleep(0.1)
    for _ in range(15):  # rewritten, but not changed
        set_points(wire, 0, 0, 0, 0, 0, 0, 0, 14)
        time.sleep(0.1)
    assert alarms(wire) == {"alarm_plc_silent"}


def test_what_the_plc_has_written_is_served_after_a_restart(rehearsal, tmp_path):
    state = tmp_path / "state"
    rehearsal.keep_in(state)
    rehearsal.start()
    with rehearsal.connect() as wire:
        set_points(wire, 26550, 40, 30, 1050, 0x1234, 0x5678, 1, 99)
        wire.ask(write_coils(32, True, True))
        written = wire.ask(read(3, 200, 8))
    rehearsal.finish()
    rehearsal.keep_in(state)
    rehearsal.start()
    with rehearsal.connect() as wire:
        assert wire.ask(read(3, 200, 8)) == written[:-2] + b"\0\0"  # all but the heartbeat
        assert wire.ask(read(1, 32, 2)) == bytes((1, 1, 0b10))
        assert look(wire)["reason_word"] & Reason.HELD
        wire.ask(write_coils(33, False))
        assert wait_for(wire, has_value, 5)["deviation"] is not None


def test_set_points_that_are_lost_are_maintenance_and_not_the_end(rehearsal, tmp_path):
    (tmp_path / "state").mkdir()
    (tmp_path / "state" / FILE_NAME).write_bytes(b"\0\0\0")
    rehearsal.keep_in(tmp_path / "state")
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, has_value, 5)
        bit = 1 << next(row.bit for row in FAULTS if row.name == "set_points_unreadable")
        assert eventually(lambda: not rehearsal.supervisor._faults.active, 3), "the file is there again"
        assert look(wire)["fault_word"] & bit, "until somebody has seen it"
        acknowledge(wire)
        assert eventually(lambda: not look(wire)["fault_word"] & bit, 1)


def test_a_folder_that_cannot_be_written_is_maintenance_and_set_points_still_count(rehearsal, tmp_path):
    (tmp_path / "state").write_text("a file where the folder should be")
    rehearsal.keep_in(tmp_path / "state" / "below")
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, has_value, 5)
        set_points(wire, 30000)
        assert wait_for(wire, lambda seen: seen["deviation"] is not None, 0.3)
        assert eventually(lambda: "set_points_not_saved" in rehearsal.supervisor._faults.active, 2)


def test_a_request_that_writes_and_reads_answers_with_what_its_writing_has_changed(wire):
    wait_for(wire, has_value, 5)
    place = next(row.address for row in REGISTERS if row.name == "decision" and "input" in row.tables)
    for target, decision in ((22500, Decision.IN), (30000, Decision.OUT), (0, Decision.NONE)):
        request = struct.pack(">BHHHHBHHH", 23, place, 1, SET_POINTS.start, 3, 6, target, 5000, 5000)
        answer = wire.ask(request)
        assert answer[:2] == bytes((23, 2))
        assert int.from_bytes(answer[2:]) == decision
