"""A running supervisor keeps a history, and trouble with its disk is a fault that the PLC reads and nothing else."""

import contextlib
import hashlib
import sqlite3
import time

import pytest
from modbus_wire import eventually, write_registers
from plc_view import has_none, has_value, look, wait_for
from rehearsal import rehearsing

from appliance.diagnostics.fault_table import FAULTS
from appliance.history import database, keeper, writer
from appliance.history.tables import Row
from appliance.sizing.stereo.settings import SizingSettings
from plc.registers import SET_POINTS

BITS = {row.name: 1 << row.bit for row in FAULTS}


@pytest.fixture
def rehearsal(tmp_path, monkeypatch):
    monkeypatch.setattr(writer, "COMMIT_PERIOD_S", 0.1)
    monkeypatch.setattr(writer, "RETRY_PERIOD_S", 0.2)
    with rehearsing("fake_station", tmp_path, monkeypatch) as rehearsal:
        yield rehearsal


def rows(folder, words):
    with contextlib.closing(sqlite3.connect(folder / database.FILE_NAME)) as connection:
        return connection.execute(words).fetchall()


def test_what_was_measured_written_and_wrong_is_in_the_history(rehearsal, tmp_path):
    history = tmp_path / "history"
    rehearsal.keep_in(None, history)
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, has_value, 5)
        wire.ask(write_registers(SET_POINTS.start, 30000, 200, 200))
        wait_for(wire, lambda seen: seen["decision"] == 2, 1)
        time.sleep(0.8)
        rehearsal.tell("fault camera_lost")
        wait_for(wire, has_none, 1)
    rehearsal.finish()
    served = rows(
        history, "SELECT diameter_mm, decision, deviation_mm FROM readings WHERE valid ORDER BY exposed_utc_ms"
    )
    assert all(200 <= diameter_mm < 250 for diameter_mm, _, _ in served)
    assert served[-1][1] == 2
    assert served[-1][2] == pytest.approx(served[-1][0] - 300)
    assert rows(history, "SELECT value FROM set_point_writes WHERE name = 'target_diameter'") == [(300.0,)]
    who = rows(history, "SELECT DISTINCT role, address FROM set_point_writes")
    assert who == [("engineer", "127.0.0.1")]
    assert ("alarm_out_of_tolerance",) in rows(history, "SELECT name FROM alarms")
    faults = rows(history, "SELECT name, station, detail FROM faults WHERE name = 'camera_lost'")
    assert faults == [("camera_lost", "sizing", "left.png: broken; mend it")]
    ((readings, decision),) = rows(history, "SELECT readings, decision FROM bars")
    assert readings >= 10
    assert decision == 2


def test_without_a_directory_nothing_is_written(rehearsal, tmp_path):
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, has_value, 5)
    rehearsal.finish()
    assert not list(tmp_path.rglob("*.db"))


def test_a_folder_that_cannot_be_written_is_a_fault_until_it_can(rehearsal, tmp_path):
    history = tmp_path / "history"
    history.write_text("a file where the folder should be")
    rehearsal.keep_in(None, history)
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, has_value, 5)
        wait_for(wire, lambda seen: seen["fault_word"] == BITS["history_not_written"], 3)
        assert has_value(look(wire))
        history.unlink()
        wait_for(wire, lambda seen: seen["fault_word"] == 0, 3)
    rehearsal.finish()
    assert rows(history, "SELECT count(*) FROM readings")[0][0] > 0


def test_a_damaged_file_is_a_fault_that_stays_until_somebody_has_seen_it(rehearsal, tmp_path):
    history = tmp_path / "history"
    rehearsal.keep_in(None, history)
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, has_value, 5)
        assert eventually((history / database.FILE_NAME).exists, 3)
        (history / database.FILE_NAME).write_bytes(b"rubbish " * 1000)
        wait_for(wire, lambda seen: seen["fault_word"] == BITS["history_damaged"], 3)
        assert has_value(look(wire))
    assert list(history.glob("history.damaged-*.db"))


@pytest.mark.alone
def test_a_disk_that_hangs_holds_up_neither_readings_nor_answers(rehearsal, tmp_path, monkeypatch):
    monkeypatch.setattr(database, "write", lambda *_: time.sleep(1.5))
    rehearsal.keep_in(None, tmp_path / "history")
    rehearsal.start()
    with rehearsal.connect() as wire:
        wait_for(wire, has_value, 5)
        begun = look(wire)
        begun_s = time.monotonic()
        while time.monotonic() - begun_s < 2:
            asked_s = time.monotonic()
            assert has_value(look(wire))
            assert time.monotonic() - asked_s < 0.5
        assert look(wire)["sequence"] - begun["sequence"] > 20


def test_a_failed_verification_of_the_rig_in_force_makes_the_calibration_due_until_one_passes(tmp_path, monkeypatch):
    monkeypatch.setattr(keeper, "VERIFICATION_PERIOD_S", 0.2)
    monkeypatch.setattr(writer, "COMMIT_PERIOD_S", 0.1)
    rig, history = tmp_path / "rig.json", tmp_path / "history"
    rig.write_text("{}")
    values = {"recording": "master", "rig_sha256": hashlib.sha256(b"{}").hexdigest()}
    with rehearsing("fake_station", tmp_path, monkeypatch, SizingSettings(rig=rig)) as rehearsal:
        rehearsal.keep_in(None, history)
        rehearsal.start()
        with rehearsal.connect() as wire:
            wait_for(wire, has_value, 5)
            assert look(wire)["fault_word"] == 0
            for minutes, verdict, due in ((1, "fail", True), (2, "pass", False)):
                connection = database.open_to_write(history / database.FILE_NAME)
                checked = {"checked_utc_ms": round(1000 * time.time()) + 1000 * minutes, "verdict": verdict}
                database.write(connection, [Row("verifications", values | checked)])
                connection.close()
                wait_for(wire, lambda seen, due=due: seen["fault_word"] == (BITS["calibration_due"] if due else 0), 5)
                assert has_value(look(wire))


def test_a_rig_file_that_nobody_has_asked_the_gauge_to_read_is_not_the_calibration_in_force(tmp_path, monkeypatch):
    monkeypatch.setattr(writer, "COMMIT_PERIOD_S", 0.1)
    rig, history = tmp_path / "rig.json", tmp_path / "history"
    rig.write_text("{}")
    sha256 = [hashlib.sha256(content).hexdigest() for content in (b"{}", b"{ }")]
    with rehearsing("fake_station", tmp_path, monkeypatch, SizingSettings(rig=rig)) as rehearsal:
        rehearsal.keep_in(None, history)
        rehearsal.start()
        with rehearsal.connect() as wire:
            wait_for(wire, has_value, 5)
            rig.write_text("{ }")
            time.sleep(0.5)
            assert eventually(lambda: rows(history, "SELECT sha256 FROM calibrations") == [(sha256[0],)], 3)
            rehearsal.reload(lambda: rehearsal.settings)
            ordered = "SELECT sha256 FROM calibrations ORDER BY found_utc_ms"
            assert eventually(lambda: rows(history, ordered) == [(one,) for one in sha256], 10)
