"""The supervisor with a measuring process that does what it is told, seen over the wire as a PLC sees it."""

import asyncio
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from modbus_wire import Wire
from plc_view import has_none, has_value, look, look_at_bits, wait_for

from appliance import supervisor as supervisor_module
from appliance.faults import DeviceState
from appliance.settings import PlcSettings, Settings
from appliance.stations import keeper
from appliance.supervisor import StartRefusedError, Supervisor
from vision.readings import Reason

TESTS = Path(__file__).parents[1]


class Rehearsal:
    """A supervisor in a thread, its fake station's script, and a PLC's connection."""

    def __init__(self, script: Path) -> None:
        self._script = script
        self._serving = threading.Event()
        self._port = 0
        plc = PlcSettings().model_copy(update={"port": 0})
        self.supervisor = Supervisor(Settings().model_copy(update={"plc": plc}))
        self.refused: StartRefusedError | None = None
        self._thread = threading.Thread(target=self._run)

    def tell(self, mode: str) -> None:
        new = self._script.with_suffix(".new")
        new.write_text(mode, encoding="utf-8")
        new.replace(self._script)

    def start(self) -> None:
        self._thread.start()

    def connect(self) -> Wire:
        assert self._serving.wait(10)
        return Wire(self._port)

    def finish(self) -> None:
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self.supervisor.stop)
        self.wait_for_end()

    def wait_for_end(self) -> None:
        self._thread.join(10)
        assert not self._thread.is_alive()

    def _run(self) -> None:
        try:
            asyncio.run(self._supervise())
        except StartRefusedError as error:
            self.refused = error

    async def _supervise(self) -> None:
        self._loop = asyncio.get_running_loop()
        await self.supervisor.run(self._on_serving)

    def _on_serving(self, port: int) -> None:
        self._port = port
        self._serving.set()


@pytest.fixture
def rehearsal(tmp_path, monkeypatch) -> Iterator[Rehearsal]:
    script = tmp_path / "script"
    monkeypatch.setenv("FAKE_STATION", str(script))
    monkeypatch.setenv("PYTHONPATH", str(TESTS))
    monkeypatch.setattr(supervisor_module, "SIZING_STATION", "fake_station")
    rehearsal = Rehearsal(script)
    rehearsal.tell("measure")
    yield rehearsal
    rehearsal.finish()


@pytest.fixture
def wire(rehearsal) -> Iterator[Wire]:
    rehearsal.start()
    with rehearsal.connect() as wire:
        yield wire


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
    assert not look_at_bits(wire)["alarm_stale"]


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
    seen = wait_for(wire, has_none, 1)
    assert seen["reason_word"] == Reason.STARTING
    assert seen["diameter"] is None
    assert seen["measurement_age"] is None
    assert seen["device_state"] == DeviceState.FAILURE
    assert look_at_bits(wire)["alarm_internal"]
    rehearsal.tell("measure")
    seen = wait_for(wire, has_value, 10)
    assert seen["diameter"] < 250
    assert seen["device_state"] == DeviceState.FUNCTION_CHECK
    assert not look_at_bits(wire)["alarm_internal"]


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
    assert look(wire)["alarm_word"] == 0


def test_a_process_that_gets_ready_is_served_as_starting(rehearsal):
    rehearsal.tell("start")
    rehearsal.start()
    with rehearsal.connect() as wire:
        seen = look(wire)
        assert seen["validity"] == 0
        assert seen["reason_word"] == Reason.STARTING
        assert seen["device_state"] == DeviceState.FUNCTION_CHECK


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
