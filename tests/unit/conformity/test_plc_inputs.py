"""What the PLC has written survives what can happen to a file and a disk."""

import asyncio
import errno
import json
import os
import threading
import time
from pathlib import Path

import pytest

from appliance.cli.gauge.serve import welcome
from appliance.conformity import plc_inputs as kept_module
from appliance.conformity.plc_inputs import FILE_NAME, PlcInputs, PlcInputsError, read, write
from appliance.diagnostics.fault_table import FAULTS
from appliance.supervisor.settings import PlcSettings, Settings, state_folder

WRITTEN = {"target_diameter": 26550, "product_id": 0x12345678, "steel_temperature": 1050, "hold": True}


class Reports(dict):
    """What is wrong, by fault; empty when nothing is any more."""

    def __call__(self, fault: str, detail: str) -> None:
        self[fault] = detail


@pytest.fixture
def reports() -> Reports:
    return Reports()


def loaded(folder: Path | None, reports: Reports) -> PlcInputs:
    inputs = PlcInputs(folder, reports)
    inputs.load()
    return inputs


def test_what_was_written_is_there_after_a_restart(tmp_path, reports):
    inputs = loaded(tmp_path, reports)
    inputs.add(WRITTEN)
    asyncio.run(inputs.save())
    assert loaded(tmp_path, reports).written == WRITTEN
    assert [path.name for path in tmp_path.iterdir()] == [FILE_NAME]


def test_heartbeat_and_acknowledge_are_not_kept(tmp_path, reports):
    inputs = loaded(tmp_path, reports)
    inputs.add({"plc_heartbeat": 7, "acknowledge": True})
    asyncio.run(inputs.save())
    assert list(tmp_path.iterdir()) == []


def test_without_a_folder_nothing_is_written(reports):
    inputs = loaded(None, reports)
    inputs.add(WRITTEN)
    asyncio.run(inputs.save())
    assert inputs.written == WRITTEN
    assert reports == {}


@pytest.mark.parametrize(("writes", "folder", "said"), [("all", None, 1), ("all", "/srv", 0), ("none", None, 0)])
def test_whoever_may_write_is_told_when_nothing_is_kept(monkeypatch, writes, folder, said):
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    plc = PlcSettings(writes=writes, state_directory=folder)
    assert "\n".join(welcome(Settings(plc=plc), 5020)).count("in memory only") == said


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[]",
        b"\xff\xfe",
        b"null",
        b'{"target_diameter": 5}',
        b'{"target_diameter": "26550"}',
        b'{"target_diameter": true}',
        b'{"target_diameter": 26550.0}',
        b'{"target_diameter": -26550}',
        b'{"target_diameter": NaN}',
        b'{"hold": 1}',
        b'{"plc_heartbeat": 1}',
        b'{"diameter": 1}',
        b"[" * 100_000,
    ],
)
def test_a_corrupt_file_is_a_fault_until_the_plc_has_written_again(tmp_path, reports, content):
    (tmp_path / FILE_NAME).write_bytes(content)
    inputs = loaded(tmp_path, reports)
    assert inputs.written == {}
    assert FILE_NAME in reports["set_points_unreadable"]
    inputs.add(WRITTEN)
    asyncio.run(inputs.save())
    assert reports["set_points_unreadable"] == ""
    assert read(tmp_path / FILE_NAME) == WRITTEN


def test_a_file_of_which_half_was_written_never_takes_the_place_of_a_whole_one(tmp_path, monkeypatch):
    file = tmp_path / FILE_NAME
    write(file, WRITTEN)

    def power_cut(*_: object) -> None:
        raise OSError(errno.EIO, "power cut")

    monkeypatch.setattr(os, "fsync", power_cut)
    with pytest.raises(OSError, match="power cut"):
        write(file, {"target_diameter": 1000})
    assert read(file) == WRITTEN


def test_a_full_disk_is_a_fault_and_is_tried_again_until_there_is_room(tmp_path, reports, monkeypatch):
    monkeypatch.setattr(kept_module, "SAVE_PERIOD_S", 0.05)
    really_write, full = write, threading.Event()
    full.set()

    def write_if_there_is_room(file: Path, written: object) -> None:
        if full.is_set():
            raise OSError(errno.ENOSPC, "No space left on device")
        really_write(file, written)

    monkeypatch.setattr(kept_module, "write", write_if_there_is_room)

    async def scenario() -> None:
        inputs = loaded(tmp_path, reports)
        keeping = asyncio.create_task(inputs.keep())
        inputs.add(WRITTEN)
        await asyncio.sleep(0.2)
        assert "No space left" in reports["set_points_not_saved"]
        full.clear()
        await asyncio.sleep(0.3)
        keeping.cancel()

    asyncio.run(scenario())
    assert reports["set_points_not_saved"] == ""
    assert read(tmp_path / FILE_NAME) == WRITTEN


def test_many_changes_are_few_files_and_equal_ones_none(tmp_path, reports, monkeypatch):
    monkeypatch.setattr(kept_module, "SAVE_PERIOD_S", 0.2)
    files = []
    monkeypatch.setattr(kept_module, "write", lambda _, written: files.append(dict(written)))

    async def scenario() -> None:
        inputs = loaded(tmp_path, reports)
        keeping = asyncio.create_task(inputs.keep())
        begun_s = time.monotonic()
        for number in range(100):
            inputs.add({"target_diameter": 20000 + number, "plc_heartbeat": number})
            await asyncio.sleep(0.005)
        await asyncio.sleep(0.3)
        assert 2 <= len(files) <= 2 + (time.monotonic() - begun_s) / 0.2, "at most one in each period"
        assert files[-1] == {"target_diameter": 20099}
        count = len(files)
        for number in range(20):
            inputs.add({"target_diameter": 20099, "plc_heartbeat": number})
            await asyncio.sleep(0.02)
        assert len(files) == count
        keeping.cancel()

    asyncio.run(scenario())


def test_a_slow_disk_does_not_hold_up_the_loop(tmp_path, reports, monkeypatch):
    monkeypatch.setattr(kept_module, "write", lambda *_: time.sleep(0.5))

    async def scenario() -> float:
        inputs = loaded(tmp_path, reports)
        inputs.add(WRITTEN)
        saving = asyncio.create_task(inputs.save())
        await asyncio.sleep(0.05)
        begun_s = time.monotonic()
        await asyncio.sleep(0.01)
        elapsed_s = time.monotonic() - begun_s
        assert not saving.done()
        await saving
        return elapsed_s

    assert asyncio.run(scenario()) < 0.3


def test_the_folder_is_the_setting_or_the_service_managers_or_none(monkeypatch):
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    assert state_folder(PlcSettings(writes="all")) is None
    monkeypatch.setenv("STATE_DIRECTORY", "/var/lib/hotgauge:/var/lib/other")
    assert state_folder(PlcSettings(writes="all")) == Path("/var/lib/hotgauge")
    assert state_folder(PlcSettings(writes="all", state_directory=Path("/srv"))) == Path("/srv")


def test_where_nobody_may_write_an_old_hold_does_not_come_back(monkeypatch):
    monkeypatch.setenv("STATE_DIRECTORY", "/var/lib/hotgauge")
    assert state_folder(PlcSettings(state_directory=Path("/srv"))) is None


def test_an_absent_file_is_nothing_written_and_a_folder_in_its_place_is_trouble(tmp_path):
    assert read(tmp_path / FILE_NAME) == {}
    (tmp_path / FILE_NAME).mkdir()
    with pytest.raises(PlcInputsError, match=FILE_NAME):
        read(tmp_path / FILE_NAME)


def test_the_file_can_be_read_by_people(tmp_path):
    write(tmp_path / FILE_NAME, WRITTEN)
    assert json.loads((tmp_path / FILE_NAME).read_text()) == WRITTEN


@pytest.mark.parametrize("content", [b"", b"{"])
def test_a_fault_of_lost_set_points_ends_even_if_the_plc_writes_nothing_but_zeros(tmp_path, reports, content):
    (tmp_path / FILE_NAME).write_bytes(content)

    async def scenario() -> None:
        inputs = loaded(tmp_path, reports)
        keeping = asyncio.create_task(inputs.keep())
        await asyncio.sleep(0.2)
        keeping.cancel()

    asyncio.run(scenario())
    assert reports["set_points_unreadable"] == ""
    assert read(tmp_path / FILE_NAME) == {}
    assert next(row for row in FAULTS if row.name == "set_points_unreadable").latching, "seen until acknowledged"


@pytest.mark.parametrize(("later", "held"), [("all", True), ("tls", False), ("all 10.0.0.5", False)])
def test_a_hold_comes_back_only_where_those_who_began_it_can_release_it(tmp_path, reports, later, held):
    before = PlcInputs(tmp_path, reports.__setitem__, rights="all")
    before.add({"hold": True, "target_diameter": 26550})
    asyncio.run(before.save())
    after = PlcInputs(tmp_path, reports.__setitem__, rights=later)
    after.load()
    assert after.held == held
    assert after.points.target_mm == pytest.approx(265.5)
    assert set(after.written) <= {"hold", "target_diameter"}
    asyncio.run(after.save())
    again = PlcInputs(tmp_path, reports.__setitem__, rights="all")
    again.load()
    assert again.held == held, "a hold that was dropped does not come back with the rights"
