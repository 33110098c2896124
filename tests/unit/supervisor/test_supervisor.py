"""The supervisor with a measuring process that does what it is told, seen over the wire as a PLC sees it."""

import itertools
import struct
import threading
import time

import pytest
from modbus_wire import Wire, eventually, read
from plc_view import Values, acknowledge, has_none, has_value, look, look_at_bits, wait_for

from appliance.processes import monitored_process as keeper
from appliance.processes.message import StateMessage
from appliance.supervisor.settings import Settings
from appliance.supervisor.supervisor import Supervisor
from plc.codes import DeviceState
from plc.process_image import decode
from plc.registers import READING_RING
from vision.reasons import Reason


def assert_latched_until_acknowledged(wire: Wire, alarm: str) -> None:
    time.sleep(1.2)  # longer than the off-delay
    assert look_at_bits(wire)[alarm]
    acknowledge(wire)
    assert eventually(lambda: not look_at_bits(wire)[alarm], 0.2)


def test_readings_reach_the_plc_with_their_true_age(wire):
    first = wait_for(wire, has_value, 5)
    seen = wait_for(wire, lambda seen: seen["sequence"] != first["sequence"], 1)
    assert 20 <= seen["measurement_age"] < 150
    assert 200 <= seen["diameter"] < 250
    assert seen["device_state"] == DeviceState.FUNCTION_CHECK
    bits = look_at_bits(wire)
    assert bits["running"]
    assert bits["simulated"]
    assert bits["measurement_valid"]


def test_the_heartbeat_keeps_the_time_whether_or_not_anything_is_measured(rehearsal, wire):
    rehearsal.tell("be silent")
    begun_s, begun = time.monotonic(), look(wire)["heartbeat"]
    time.sleep(2)
    beats, elapsed_s = look(wire)["heartbeat"] - begun, time.monotonic() - begun_s
    assert beats == pytest.approx(elapsed_s / 0.1, abs=1.6)


def test_a_silent_process_leaves_no_value_standing(rehearsal, wire):
    wait_for(wire, has_value, 5)
    rehearsal.tell("be silent")
    seen = wait_for(wire, has_none, 1.2)
    assert seen["diameter"] is None
    assert seen["reason_word"] == Reason.STALE
    assert seen["device_state"] == DeviceState.FAILURE
    assert look_at_bits(wire)["alarm_stale"]
    assert not look_at_bits(wire)["running"]
    rehearsal.tell("measure")
    wait_for(wire, has_value, 1)
    assert_latched_until_acknowledged(wire, "alarm_stale")


def test_a_process_that_stays_silent_is_ended_and_started_again(rehearsal, monkeypatch):
    monkeypatch.setattr(keeper, "SILENCE_LIMIT_S", 2.0)
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, has_value, 5)
        rehearsal.tell("be silent")
        wait_for(wire, lambda seen: seen["reason_word"] == Reason.STARTING, 4)
        assert look_at_bits(wire)["alarm_internal"]
        rehearsal.tell("measure")
        wait_for(wire, has_value, 10)


@pytest.mark.parametrize("end", ["break off", "end", "babble"])
def test_a_process_that_ends_takes_its_value_with_it_and_comes_back(rehearsal, wire, end):
    wait_for(wire, has_value, 5)
    rehearsal.tell(end)
    wait_for(wire, has_none, 1)  # on a busy computer the value may be too old before its process is known to be gone
    seen = wait_for(wire, lambda seen: seen["reason_word"] == Reason.STARTING, 1)
    assert seen["diameter"] is None
    assert seen["measurement_age"] is None
    assert seen["device_state"] == DeviceState.FAILURE
    assert look_at_bits(wire)["alarm_internal"]
    rehearsal.tell("measure")
    seen = wait_for(wire, has_value, 10)
    assert seen["diameter"] < 250
    assert seen["device_state"] == DeviceState.FUNCTION_CHECK
    assert_latched_until_acknowledged(wire, "alarm_internal")


@pytest.mark.parametrize(
    ("fault", "alarm", "state"),
    [
        ("camera_lost", "alarm_camera", DeviceState.FAILURE),
        ("rig_unusable", "alarm_calibration", DeviceState.FAILURE),
        ("recording_over", None, DeviceState.FUNCTION_CHECK),
    ],
)
def test_trouble_of_the_equipment_is_a_state_and_an_alarm_until_it_is_over(rehearsal, wire, fault, alarm, state):
    wait_for(wire, has_value, 5)
    rehearsal.tell(f"fault {fault}")
    seen = wait_for(wire, has_none, 1)
    assert seen["reason_word"] == Reason.NO_PAIR
    assert seen["device_state"] == state
    alarms = {name for name, on in look_at_bits(wire).items() if on and name.startswith("alarm")}
    assert alarms == ({alarm} if alarm else set())
    rehearsal.tell("measure")
    wait_for(wire, has_value, 1)
    if alarm:
        assert_latched_until_acknowledged(wire, alarm)
    assert look(wire)["alarm_word"] == 0


def test_a_process_that_gets_ready_is_served_as_starting(rehearsal):
    rehearsal.tell("start")
    rehearsal.start()
    with rehearsal.connect() as wire:
        seen = look(wire)
        assert seen["validity"] == 0
        assert seen["reason_word"] == Reason.STARTING
        assert seen["device_state"] == DeviceState.FUNCTION_CHECK


def test_a_process_that_compiles_counts_as_working_and_has_not_spoken_yet():
    sizing = Supervisor(Settings())._sizing
    before_s = sizing._worked_s
    time.sleep(0.01)
    sizing._receive(StateMessage(state="warming"))
    assert sizing._worked_s > before_s
    assert sizing._gate._silent == {"sizing"}
    sizing._receive(StateMessage(state="starting"))
    assert not sizing._gate._silent


def test_settings_that_the_process_cannot_use_refuse_the_start(rehearsal):
    rehearsal.tell("fault camera_lost")
    rehearsal.start()
    rehearsal.wait_for_end()
    assert str(rehearsal.refused) == "left.png: broken; mend it"


def test_a_process_that_cannot_start_is_served_as_a_failure(rehearsal):
    rehearsal.tell("end")
    rehearsal.start()
    with rehearsal.connect() as wire:
        assert look(wire)["device_state"] == DeviceState.FAILURE
        rehearsal.tell("measure")
        wait_for(wire, has_value, 10)


def test_a_fault_is_logged_once_when_it_comes_and_once_when_it_goes(rehearsal, wire, caplog):
    caplog.set_level("INFO", logger="hotgauge")
    wait_for(wire, has_value, 5)
    rehearsal.tell("fault camera_lost")
    wait_for(wire, has_none, 1)
    time.sleep(0.5)
    rehearsal.tell("measure")
    wait_for(wire, has_value, 1)
    lines = [record.getMessage() for record in caplog.records if record.name.startswith("hotgauge")]
    assert len(lines) == 2
    assert "left.png: broken; mend it" in lines[0]
    assert "101" in lines[1]


def test_the_ring_holds_every_reading_between_two_looks(wire):
    wait_for(wire, has_value, 5)
    known, seen = None, []
    until_s = time.monotonic() + 2
    while time.monotonic() < until_s:
        ring = look_at_ring(wire)
        index = ring["reading_ring_index"]
        slots = range(index if known is None else known, index)
        assert len(slots) <= 8
        seen += [(ring[f"reading_{n % 8}_sequence"], ring[f"reading_{n % 8}_diameter"]) for n in slots]
        known = index
        time.sleep(0.2)
    assert len(seen) > 20
    for (sequence, diameter), (next_sequence, next_diameter) in itertools.pairwise(seen):
        assert next_sequence == sequence + 1
        assert next_diameter == 200 + (diameter - 199) % 50


def look_at_ring(wire: Wire) -> Values:
    words = wire.ask(read(3, READING_RING.start, len(READING_RING)))[2:]
    return decode(struct.unpack(f">{len(READING_RING)}H", words), block="reading_ring")


@pytest.mark.parametrize("moment", ["-1e308", "1e308", "1e9"])
def test_a_process_whose_exposures_cannot_be_is_ended_and_its_value_never_stands(rehearsal, moment):
    rehearsal.tell(f"expose {moment}")
    rehearsal.start()
    rehearsal.supervisor._gate.open()
    with rehearsal.connect() as wire:
        seen = wait_for(wire, lambda seen: seen["alarm_word"] & 1 << 7, 5)
        assert seen["validity"] == 0
        rehearsal.tell("measure")
        assert wait_for(wire, has_value, 10)["diameter"] >= 200


def test_of_two_reloads_the_later_one_wins_and_an_error_of_any_kind_is_a_fault(rehearsal, wire):
    wait_for(wire, has_value, 5)
    kept = rehearsal.settings

    def slow_old() -> Settings:
        time.sleep(0.5)
        return kept

    def broken() -> Settings:
        raise RecursionError

    first = threading.Thread(target=rehearsal.reload, args=[slow_old])
    first.start()
    time.sleep(0.1)
    rehearsal.reload(broken)
    first.join()
    assert rehearsal.supervisor._faults.active & {"settings_unusable"}


def test_a_computer_that_has_slept_serves_no_reading_from_before(rehearsal, wire):
    wait_for(wire, has_value, 5)
    rehearsal.tell("be silent")
    asleep = iter([3600.0])
    rehearsal.supervisor._sleep._boot = lambda: time.monotonic() + next(asleep, 3600.0)
    assert eventually(lambda: has_none(look(wire)), 0.3), "0.8 s before the reading would be stale"


def test_a_reload_is_no_failure_and_a_rig_that_was_replaced_is_read(rehearsal, wire, tmp_path):
    wait_for(wire, has_value, 5)
    rig = tmp_path / "rig.json"
    rig.write_text("one")
    sizing = rehearsal.settings.sizing.model_copy(update={"rig": rig})
    settings = rehearsal.settings.model_copy(update={"sizing": sizing})
    for renews in (True, False, True):
        rehearsal.reload(lambda: settings)
        seen = []
        while len(seen) < 20 or (renews and not has_none(seen[-1]) and len(seen) < 200):
            seen.append(look(wire))
            time.sleep(0.02)
        assert any(has_none(one) for one in seen) == renews
        assert not any(one["alarm_word"] for one in seen)
        assert max(one["device_state"] for one in seen) <= DeviceState.FUNCTION_CHECK
        wait_for(wire, has_value, 10)
        if not renews:
            rig.write_text("another")
