"""Whatever breaks: what the PLC sees, second by second, and how soon it measures again.

Promises: no value within 1 s, the right fault and alarm, nothing but true values at any time, measuring again within
10 s of the end of the trouble, and a connection that is never lost. The measuring process is the real loop with a
camera and a gauge that do what they are told.
"""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from rehearsal import Rehearsal, rehearsing
from second_by_second import Polling, Seen

from appliance.diagnostics.fault_table import FAULTS
from appliance.processes import monitored_process as keeper
from appliance.settings.file import SettingsError
from appliance.sizing.stereo.settings import SizingSettings
from appliance.supervisor.settings import Settings

OFF_S = 1.0
BACK_S = 10.0
CLASSES = {row.name: row.state for row in FAULTS}


@pytest.fixture
def rehearsal(tmp_path, monkeypatch) -> Iterator[Rehearsal]:
    sizing = SizingSettings(memory_max_mb=1500)
    with rehearsing("faulty_station", tmp_path, monkeypatch, sizing) as rehearsal:
        yield rehearsal


@pytest.fixture
def plc(rehearsal) -> Iterator[Polling]:
    rehearsal.start()
    with rehearsal.connect() as wire, Polling(wire) as polling:
        polling.first(0, is_valid, float("inf"))
        yield polling
    assert polling.lost is None
    assert all(seen.diameter_mm is None or 200 <= seen.diameter_mm <= 202 for seen in polling.seen)
    assert all((seen.diameter_mm is None) == (seen.validity == 0) for seen in polling.seen)
    assert all(seen.age_ms < 900 for seen in polling.seen if is_valid(seen))


def is_valid(seen: Seen) -> bool:
    return seen.validity != 0


def station() -> int:
    """Process id of the measuring process, which is the only child of this one that is a station."""
    for children in Path("/proc/self/task").glob("*/children"):
        for child in children.read_text().split():
            if b"faulty_station" in Path(f"/proc/{child}/cmdline").read_bytes():
                return int(child)
    raise AssertionError("no measuring process")


def assert_goes_and_comes_back(plc: Polling, rehearsal: Rehearsal, mode: str, fault: str, alarm: str) -> None:
    begun_s = time.monotonic()
    rehearsal.tell(mode)
    off = plc.first(begun_s, lambda seen: not is_valid(seen), OFF_S)
    named = plc.first(begun_s, lambda seen: fault in seen.faults, 6)
    assert named.state == CLASSES[fault]
    plc.first(named.at_s, lambda seen: alarm in seen.alarms, 0.5)
    time.sleep(1.2)
    mended_s = time.monotonic()
    rehearsal.tell("measure")
    back = plc.first(max(mended_s, named.at_s), is_valid, BACK_S)
    assert not any(map(is_valid, plc.since(off.at_s, min(mended_s, back.at_s)))), plc.told(begun_s)
    plc.first(back.at_s, lambda seen: fault not in seen.faults, 1)
    line = f"{fault}: no value after {off.at_s - begun_s:.2f} s, named after {named.at_s - begun_s:.2f} s"
    print(f"{line}, back after {back.at_s - mended_s:.2f} s{plc.told(begun_s)}")


@pytest.mark.parametrize(
    ("mode", "fault"),
    [
        ("unplugged", "camera_lost"),
        ("silent", "camera_lost"),
        ("frozen", "camera_frozen"),
        ("time stamps stand still", "camera_frozen"),
        ("out of step", "pair_out_of_step"),
        ("black", "picture_blank"),
        ("wrong size", "picture_size_changed"),
        ("clock a day ahead", "camera_clock_wrong"),
    ],
)
def test_a_camera_that_fails_is_named_and_comes_back(rehearsal, plc, mode, fault):
    assert_goes_and_comes_back(plc, rehearsal, mode, fault, "alarm_camera")


@pytest.mark.parametrize("mode", ["native crash", "too much memory", "error"])
def test_a_process_that_dies_of_itself_comes_back(rehearsal, plc, mode):
    assert_goes_and_comes_back(plc, rehearsal, mode, "station_restarting", "alarm_internal")


def test_a_process_that_is_killed_comes_back(rehearsal, plc):
    def kill() -> None:
        os.kill(station(), signal.SIGKILL)

    killed_s = time.monotonic()
    kill()
    off = plc.first(killed_s, lambda seen: not is_valid(seen), OFF_S)
    assert "station_restarting" in off.faults
    assert off.age_ms is None
    back = plc.first(off.at_s, is_valid, BACK_S)
    assert "station_restarting" not in back.faults
    print(f"no value after {off.at_s - killed_s:.2f} s, back after {back.at_s - killed_s:.2f} s{plc.told(killed_s)}")


@pytest.mark.parametrize("how", ["stopped", "hang"])
def test_a_process_that_hangs_is_ended_and_comes_back(rehearsal, plc, how):
    hung_s = time.monotonic()
    hung = station()
    if how == "stopped":
        os.kill(hung, signal.SIGSTOP)
    else:
        rehearsal.tell("hang")
    off = plc.first(hung_s, lambda seen: not is_valid(seen), OFF_S)
    assert "reading_stale" in off.faults
    time.sleep(1)
    rehearsal.tell("measure")
    back = plc.first(off.at_s, is_valid, keeper.SILENCE_LIMIT_S + keeper.LEAVE_TIME_S + BACK_S)
    assert station() != hung
    ages = [seen.age_ms for seen in plc.since(off.at_s, back.at_s) if seen.age_ms is not None]
    assert ages == sorted(ages)
    print(f"no value after {off.at_s - hung_s:.2f} s, back after {back.at_s - hung_s:.2f} s{plc.told(hung_s)}")


def test_a_process_that_keeps_dying_is_a_failure_and_told_until_somebody_has_seen_it(rehearsal, plc, monkeypatch):
    monkeypatch.setattr(keeper, "ENDS_BEFORE_FAILING", 3)
    monkeypatch.setattr(keeper, "FAILING_PAUSE_S", 2.0)
    monkeypatch.setattr(keeper, "GOOD_RUN_TIME_S", 3.0)
    begun_s = time.monotonic()
    rehearsal.tell("error")
    failing = plc.first(begun_s, lambda seen: "station_failing" in seen.faults, 30)
    assert failing.state == 4
    assert "station_restarting" not in failing.faults
    time.sleep(1)
    assert all("station_failing" in seen.faults for seen in plc.since(failing.at_s))
    rehearsal.tell("measure")
    back = plc.first(failing.at_s, is_valid, 2 + BACK_S)
    assert back.state == 4  # it has to run well for a while
    well = plc.first(back.at_s, lambda seen: seen.state == 1, 5)
    assert "station_failing" in well.faults
    assert well.at_s - back.at_s > 1


def test_a_loop_that_runs_without_measuring_is_a_fault_and_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(keeper, "START_LIMIT_S", 4.0)
    sizing = SizingSettings.model_validate({"liveness": {"idle_after_s": 1.0}})
    with rehearsing("fake_station", tmp_path, monkeypatch, sizing) as rehearsal:
        rehearsal.tell("start")
        rehearsal.start()
        with rehearsal.connect() as wire, Polling(wire) as plc:
            idle = plc.first(0, lambda seen: "not_measuring" in seen.faults, float("inf"))
            assert idle.state == 4
            plc.first(idle.at_s, lambda seen: "alarm_internal" in seen.alarms, 0.5)
            plc.first(idle.at_s, lambda seen: "station_restarting" in seen.faults, 8)
            rehearsal.tell("measure")
            back = plc.first(idle.at_s, is_valid, 20)
            plc.first(back.at_s, lambda seen: not seen.faults, 1)


def test_a_clock_that_is_set_by_a_day_is_told_and_touches_no_value(rehearsal, plc, monkeypatch):
    from appliance.supervisor import clock_watch as wall_clock  # noqa: PLC0415

    monkeypatch.setattr(wall_clock, "STEP_MEMORY_S", 2.0)
    for step_s in (86_400, -86_400):
        begun_s = time.monotonic()
        rehearsal.wall = lambda step_s=step_s: time.time() + step_s
        told = plc.first(begun_s, lambda seen: "clock_stepped" in seen.faults, 1)
        assert told.state == 1
        plc.first(told.at_s, lambda seen: not seen.faults, 4)
        assert all(map(is_valid, plc.since(begun_s)))


def test_settings_that_are_broken_at_a_reload_leave_the_old_ones_in_force(rehearsal, plc):
    def broken() -> Settings:
        raise SettingsError("hotgauge.toml: plc.prot: unknown key; did you mean plc.port?")

    before = station()
    begun_s = time.monotonic()
    rehearsal.reload(broken)
    told = plc.first(begun_s, lambda seen: "settings_unusable" in seen.faults, 1)
    assert told.state == 1
    rehearsal.reload(lambda: rehearsal.settings)
    plc.first(told.at_s, lambda seen: not seen.faults, 1)
    assert station() == before
    assert all(map(is_valid, plc.since(begun_s)))


def test_new_settings_start_the_measuring_process_again_and_others_wait_for_a_restart(rehearsal, plc):
    before = station()
    sizing = rehearsal.settings.sizing.model_copy(update={"stale_after_ms": 900})
    begun_s = time.monotonic()
    rehearsal.reload(lambda: rehearsal.settings.model_copy(update={"sizing": sizing}))
    off = plc.first(begun_s, lambda seen: not is_valid(seen), OFF_S)
    plc.first(off.at_s, is_valid, BACK_S)
    assert station() != before
    begun_s = time.monotonic()
    plc_settings = rehearsal.settings.plc.model_copy(update={"port": 502})
    rehearsal.reload(lambda: rehearsal.settings.model_copy(update={"sizing": sizing, "plc": plc_settings}))
    plc.first(begun_s, lambda seen: seen.faults == {"restart_needed"}, 1)
    assert all(map(is_valid, plc.since(begun_s)))
