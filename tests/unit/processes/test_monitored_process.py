"""The supervisor's side of a station process: restarts, pauses, silence, nothing left behind."""

import asyncio
import os
import time

import pytest
from messages import reading
from station_cycles import WARM_UP, cycles, without_pauses
from station_path import STATION_PATH

from appliance.processes import monitored_process as keeper
from appliance.processes.monitored_process import Health, MonitoredProcess
from appliance.sizing.message import MESSAGES


@pytest.fixture
def environment(monkeypatch):
    for name in ("BLINKING_STATION", "PYTHONPATH"):
        monkeypatch.setenv(name, os.environ.get(name, ""))
    return monkeypatch


def test_fifty_starts_and_crashes_leave_nothing_behind(environment, tmp_path):
    without_pauses(environment.setattr)
    result = cycles(50, tmp_path)
    assert result["readings"] == result["ends"] == WARM_UP + 50
    assert result["descriptors"][1] <= result["descriptors"][0]
    assert result["children"][1] <= result["children"][0]
    assert result["rss_kb"][1] - result["rss_kb"][0] < 3000


def healths(environment, tmp_path, wanted: int) -> list[tuple[float, Health]]:
    """The first so many things that a keeper tells of a process that crashes after each reading, with their moments."""
    (tmp_path / "reading").write_bytes(reading().model_dump_json().encode() + b"\n")
    environment.setenv("BLINKING_STATION", str(tmp_path / "reading"))
    environment.setenv("PYTHONPATH", STATION_PATH)
    told: list[tuple[float, Health]] = []

    async def run() -> None:
        over = asyncio.Event()

        def tell(health: Health) -> None:
            told.append((time.monotonic(), health))
            if len(told) == wanted:
                over.set()

        task = asyncio.create_task(MonitoredProcess("blinking_station", "{}", MESSAGES, lambda _: None, tell).run())
        await asyncio.wait_for(over.wait(), 60)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(run())
    return told


def test_pauses_grow_and_a_station_that_keeps_ending_fails_and_cools_down(environment, tmp_path):
    environment.setattr(keeper, "FIRST_PAUSE_S", 0.1)
    environment.setattr(keeper, "FAILING_PAUSE_S", 3.0)
    environment.setattr(keeper, "ENDS_BEFORE_FAILING", 3)
    told = healths(environment, tmp_path, 6)
    assert [(health.state, health.ended) for _, health in told] == [
        ("restarting", True),
        ("running", False),
        ("restarting", True),
        ("running", False),
        ("failing", True),
        ("failing", True),  # one reading more is no good run
    ]
    assert "3 times; next try in 3 s" in told[4][1].detail
    assert "signal 9" in told[4][1].detail
    assert told[1][0] - told[0][0] >= 0.1
    assert told[3][0] - told[2][0] >= 0.2
    assert told[5][0] - told[4][0] >= 3


def test_a_good_run_makes_the_next_end_the_first_again(environment, tmp_path):
    environment.setattr(keeper, "FIRST_PAUSE_S", 0.01)
    environment.setattr(keeper, "GOOD_RUN_TIME_S", -1.0)  # every run that gives a reading is good
    told = healths(environment, tmp_path, 16)
    assert {health.state for _, health in told} == {"running", "restarting"}


def test_a_program_that_does_not_exist_is_an_end_like_any_other(environment):
    environment.setattr(keeper.sys, "executable", "/nowhere/python")
    told: list[Health] = []

    async def run() -> None:
        task = asyncio.create_task(
            MonitoredProcess("blinking_station", "{}", MESSAGES, lambda _: None, told.append).run()
        )
        await asyncio.sleep(0.3)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(run())
    assert told[0].state == "restarting"
    assert "cannot be started" in told[0].detail


def test_a_keeper_that_is_cancelled_as_a_message_arrives_is_cancelled():
    async def run() -> bool:
        reader = asyncio.StreamReader()
        task = asyncio.create_task(keeper._listen(reader, MESSAGES, lambda _: None))
        await asyncio.sleep(0.05)
        reader.feed_data(reading().model_dump_json().encode() + b"\n")
        task.cancel()
        await asyncio.wait({task}, timeout=0.5)
        ended = task.cancelled()
        task.cancel()
        return ended

    assert asyncio.run(run())


def test_new_settings_end_the_process_without_any_failure(environment, tmp_path):
    (tmp_path / "reading").write_bytes(b"")
    environment.setenv("BLINKING_STATION", str(tmp_path / "reading"))
    environment.setenv("PYTHONPATH", STATION_PATH)
    environment.setattr(keeper, "_listen", lambda *_: asyncio.sleep(60, ""))
    told: list[Health] = []

    async def run() -> None:
        kept = MonitoredProcess("blinking_station", "{}", MESSAGES, lambda _: None, told.append)
        task = asyncio.create_task(kept.run())
        await asyncio.sleep(0.5)
        kept.renew("{}")
        await asyncio.sleep(0.5)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(run())
    assert told == [Health("renewing", ended=True)]
