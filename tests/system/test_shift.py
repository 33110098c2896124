"""A short shift: the miniature PLC and the whole appliance as a process, event by event."""

import itertools
import os
import signal
import struct
from pathlib import Path

import pytest
from ingot_recording import BOTTOM, EMPTY, TOP, write_recording
from modbus_wire import read
from running import Appliance, free_port, running

from appliance.simulation.bars.bars import bar_at
from plc.client import Plc
from plc.poll import Snapshot

pytestmark = pytest.mark.waiting

SEED = 5
SCAN_S = 0.02
FIRST_BAR_MM = bar_at(SEED, 0).diameter_mm
SETTINGS = """
[plc]
port = {port}
writes = "all"
state_directory = "state"
silent_after_s = 1
[sizing]
stale_after_ms = 5000  # a busy computer may be late; lateness has tests of its own
[sizing.liveness]
lost_after_ms = 5000
idle_after_s = 120
[sizing.camera]
kind = "mill"
seed = {seed}
rate_hz = 8
"""
INGOTS = """
[ingot]
references = "{references}"
[ingot.camera]
kind = "recording"
path = "{recording}"
rate_hz = 12
loop = false
"""
WRONG = "alarm_wrong_orientation"


class Shift:
    """The program of the PLC for one shift, and the lines that its log must show."""

    def __init__(self, plc: Plc) -> None:
        self.plc = plc
        self.expected: list[str] = []

    def until(self, wanted, *lines: str, within_s: float = 15) -> Snapshot:
        snapshot = self.plc.run(wanted, within_s, every_s=SCAN_S)
        self.expected += lines
        assert self.plc.log == self.expected
        return snapshot

    def next_bar(self, number: int) -> Snapshot:
        self.until(lambda seen: seen.values["validity"] == 0, "measurement not valid")
        return self.until(lambda seen: seen.values["validity"] != 0, "measurement valid", f"bar {number}")

    def until_among_bars(self, *lines: str, within_s: float = 30) -> None:
        """Wait for lines in this order; between them only bars come and go, one after the other."""
        before = len(self.expected)
        self.plc.run(lambda _: self._others(before) == list(lines), within_s, every_s=SCAN_S)
        bars = [line for line in self.plc.log[before:] if _is_of_bars(line)]
        first = next((int(line.split()[1]) for line in bars if line.startswith("bar")), 1)
        rounds = (["measurement valid", f"bar {number}", "measurement not valid"] for number in itertools.count(first))
        course = list(itertools.islice(itertools.chain.from_iterable(rounds), len(bars) + 2))
        assert any(bars == course[start : start + len(bars)] for start in (0, 2)), bars
        self.expected = list(self.plc.log)

    def _others(self, before: int) -> list[str]:
        return [line for line in self.plc.log[before:] if not _is_of_bars(line)]

    def until_lost(self) -> None:
        while self.plc.scan() is not None:
            pass
        self.expected += ["connection lost", "measurement not valid"]
        assert self.plc.log == self.expected

    def want(self, **set_points: float) -> None:
        self.plc.outputs.set_points = set_points

    def acknowledge(self, alarm: str) -> None:
        """Press while the cause is over and the alarm still shown."""
        with pytest.raises(TimeoutError):
            self.plc.run(lambda seen: not seen.alarms, 1.2, every_s=SCAN_S)
        self.plc.press_acknowledge()
        self.until(lambda seen: not seen.alarms, f"acknowledged {alarm}", f"{alarm} went", within_s=0.5)


def _is_of_bars(line: str) -> bool:
    return line.startswith(("bar ", "measurement "))


def test_a_whole_shift_event_by_event(tmp_path, recordings):
    port = free_port()
    file = tmp_path / "hotgauge.toml"
    file.write_text(SETTINGS.format(port=port, seed=SEED))
    with Plc("127.0.0.1", port) as plc:
        shift = Shift(plc)
        with running("run", "--config", file, port=port) as appliance:
            the_line_starts(shift)
            a_bar_is_out_of_tolerance(shift)
            the_measuring_process_is_killed(shift, appliance)
            leave_set_points(shift)
            appliance.process.kill()
            shift.until_lost()
        with running("run", "--config", file, port=port) as appliance:
            assert_set_points_are_there(appliance, tmp_path)
            the_line_goes_on(shift)
            the_plc_holds_the_gauge(shift)
            the_plc_falls_silent(shift)
            appliance.process.kill()
            shift.until_lost()
        ingots = write_recording(tmp_path / "ingots", recordings / "ingot_line", EMPTY, BOTTOM, TOP, EMPTY)
        file.write_text(
            file.read_text().replace("rate_hz = 8", "rate_hz = 4")
            + INGOTS.format(references=recordings / "ingot_line", recording=ingots)
        )
        with running("run", "--config", file, port=port) as appliance:
            ingots_come(shift)
            the_ingot_station_is_killed(shift, appliance)


def the_line_starts(shift: Shift) -> None:
    started = "connected", "measurement valid", "bar 1"
    shift.until(lambda seen: seen.values["validity"] != 0, *started, within_s=60)
    seen = shift.next_bar(2)
    assert seen.values["decision"] == 0
    assert seen.values["correction"] is None


def a_bar_is_out_of_tolerance(shift: Shift) -> None:
    shift.want(target_diameter=10, tolerance_plus=2, tolerance_minus=2)
    seen = shift.until(lambda seen: bool(seen.alarms), "alarm_out_of_tolerance came")
    assert seen.values["decision"] == 2
    assert seen.values["correction"] < 0
    shift.want(target_diameter=round(seen.values["diameter"], 2), tolerance_plus=2, tolerance_minus=2)
    seen = shift.until(lambda seen: seen.values["decision"] == 1)
    assert abs(seen.values["deviation"]) < 0.5
    shift.acknowledge("alarm_out_of_tolerance")
    shift.want()
    shift.next_bar(3)


def the_measuring_process_is_killed(shift: Shift, appliance: Appliance) -> None:
    os.kill(appliance.station(), signal.SIGKILL)
    shift.until(lambda seen: bool(seen.alarms), "measurement not valid", "alarm_internal came", within_s=1)
    shift.until(lambda seen: seen.values["validity"] != 0, "measurement valid", "bar 4", within_s=10)
    shift.acknowledge("alarm_internal")


def leave_set_points(shift: Shift) -> None:
    shift.want(target_diameter=FIRST_BAR_MM, tolerance_plus=2, tolerance_minus=2, product_id=70000)
    with pytest.raises(TimeoutError):  # longer than the disk is left alone between two writes
        shift.plc.run(lambda seen: bool(seen.alarms), 1.5, every_s=SCAN_S)


def assert_set_points_are_there(appliance: Appliance, folder: Path) -> None:
    assert (folder / "state").is_dir()
    with appliance.wire() as wire:
        words = struct.unpack(">8H", wire.ask(read(3, 200, 8))[2:])
    assert words[:3] == (round(100 * FIRST_BAR_MM), 200, 200)
    assert words[4:6] == divmod(70000, 65536)


def the_line_goes_on(shift: Shift) -> None:
    started = "connected", "measurement valid", "bar 1"
    seen = shift.until(lambda seen: seen.values["validity"] != 0, *started, within_s=60)
    assert seen.values["deviation"] == pytest.approx(seen.values["diameter"] - FIRST_BAR_MM, abs=0.01)
    assert seen.values["decision"] == 1


def the_plc_holds_the_gauge(shift: Shift) -> None:
    shift.want()
    shift.plc.outputs.hold = True
    seen = shift.until(lambda seen: seen.values["validity"] == 0, "measurement not valid", within_s=0.5)
    assert seen.values["device_state"] == 3
    assert seen.values["diameter"] is None
    shift.plc.outputs.hold = False
    shift.until(lambda seen: seen.values["bar_sequence"] == 2, "measurement valid", "bar 2", within_s=1)
    shift.next_bar(3)


def the_plc_falls_silent(shift: Shift) -> None:
    shift.plc.outputs.beats = False
    shift.until(lambda seen: bool(seen.alarms), "alarm_plc_silent came", within_s=2)
    shift.plc.outputs.beats = True
    shift.acknowledge("alarm_plc_silent")


def ingots_come(shift: Shift) -> None:
    shift.until_among_bars("connected", "ingot 1 shows its bottom", "ingot 2 shows its top", f"{WRONG} came")
    acknowledge_the_ingot(shift)


def acknowledge_the_ingot(shift: Shift) -> None:
    """The alarm outlasts the ingot by more than its off-delay; only the key ends it."""
    shift.plc.run(lambda seen: seen.values["ingot_orientation"] == 0, 15, every_s=SCAN_S)
    with pytest.raises(TimeoutError):
        shift.plc.run(lambda seen: not seen.alarms, 1.2, every_s=SCAN_S)
    shift.plc.press_acknowledge()
    shift.until_among_bars(f"acknowledged {WRONG}", f"{WRONG} went", within_s=0.5)


def the_ingot_station_is_killed(shift: Shift, appliance: Appliance) -> None:
    """Bars go on; the station starts again, counts on, and sees the recording from its start."""
    sizing = appliance.station()
    os.kill(appliance.station("ingot"), signal.SIGKILL)
    shift.until_among_bars("alarm_internal came", within_s=1)
    shift.until_among_bars("ingot 3 shows its bottom")
    shift.plc.press_acknowledge()
    shift.until_among_bars("acknowledged alarm_internal", "alarm_internal went", within_s=1.5)
    shift.until_among_bars("ingot 4 shows its top", f"{WRONG} came")
    acknowledge_the_ingot(shift)
    assert appliance.station() == sizing
