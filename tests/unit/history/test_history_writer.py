"""The history's file survives what disks and power do; who gives it rows never waits."""

import contextlib
import sqlite3
import time
from pathlib import Path

import pytest
from hanging_disk import HangingDisk
from killed_writer import write_and_kill
from modbus_wire import eventually

from appliance.history import database, schema, writer
from appliance.history.schema import HistoryError
from appliance.history.settings import HistorySettings
from appliance.history.tables import TABLES, Row
from appliance.history.writer import HistoryWriter

RUN = round(1000 * time.time())  # rows of long ago would be deleted


def reading(number: int, **values) -> Row:
    fields = {"exposed_utc_ms": RUN + number, "run_utc_ms": RUN, "sequence": number, "diameter_mm": 250.0}
    return Row("readings", fields | values)


def bar(number: int) -> Row:
    return Row("bars", {"started_utc_ms": RUN + number, "run_utc_ms": RUN, "bar": number})


@pytest.fixture
def made(tmp_path, monkeypatch):
    monkeypatch.setattr(writer, "COMMIT_PERIOD_S", 0.02)
    monkeypatch.setattr(writer, "RETRY_PERIOD_S", 0.05)
    writers = []

    def make(folder: Path = tmp_path, **settings) -> HistoryWriter:
        one = HistoryWriter(folder, HistorySettings(**settings), RUN, version="1.2.3")
        writers.append(one)
        one.start()
        return one

    yield make
    for one in writers:
        one.stop()


def looking(file: Path) -> contextlib.closing[sqlite3.Connection]:
    return contextlib.closing(sqlite3.connect(file))


COUNT = {table.name: "SELECT count(*) FROM " + table.name for table in TABLES}


def count(folder: Path, table: str = "readings") -> int:
    with contextlib.suppress(sqlite3.Error), looking(folder / database.FILE_NAME) as connection:
        return connection.execute(COUNT[table]).fetchone()[0]
    return 0  # not made yet


def test_the_columns_of_the_file_are_those_that_are_documented(tmp_path):
    connection = database.open_to_write(tmp_path / database.FILE_NAME)
    made = {name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    assert made == {table.name for table in TABLES}
    for table in TABLES:
        names = [row[1] for row in connection.execute(f"PRAGMA table_info({table.name})")]
        assert sorted(names) == sorted(column.name for column in table.columns)
        assert names[0] == table.time, "rows are selected by their time, so it leads the key"
    connection.close()


def test_rows_are_on_the_disk_within_a_moment_and_after_the_end(made, tmp_path):
    one = made()
    one.put(reading(1))
    assert eventually(lambda: count(tmp_path) == 1, 5)
    one.put(bar(1))
    one.stop()
    assert count(tmp_path, "bars") == 1
    with looking(tmp_path / database.FILE_NAME) as connection:
        assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
        ((started, alive, version),) = connection.execute("SELECT * FROM runs")
    assert (started, version) == (RUN, "1.2.3")
    assert abs(alive - 1000 * time.time()) < 10_000


def test_a_row_with_the_same_key_takes_the_place_of_the_one_before(made, tmp_path):
    one = made()
    one.put(reading(1, trust=10.0))
    one.put(reading(1, trust=20.0))
    one.stop()
    assert count(tmp_path) == 1


def test_nothing_waits_while_the_disk_hangs_and_what_is_too_much_is_dropped_readings_first(made, monkeypatch):
    disk = HangingDisk()
    monkeypatch.setattr(database, "write", disk.hang)
    one = made()
    disk.wait_for_hanging()
    for number in range(12_000):
        one.put(reading(number))
    assert one.dropped == 12_000 - writer.READINGS_WAITING_MAX
    one.put(bar(1))
    assert one.dropped == 12_000 - writer.READINGS_WAITING_MAX, "a bar has room where readings have none"
    assert disk.still_hangs
    disk.go_on()


def test_a_folder_that_cannot_be_made_is_trouble_until_it_can_and_no_row_is_lost(made, tmp_path):
    blocked = tmp_path / "place"
    blocked.write_text("a file where the folder should be")
    one = made(blocked / "history")
    one.put(reading(1))
    assert eventually(lambda: "place" in one.trouble, 5)
    blocked.unlink()
    assert eventually(lambda: not one.trouble, 5)
    assert eventually(lambda: count(blocked / "history") == 1, 5)
    assert one.dropped == 0


def test_a_full_disk_is_trouble_until_there_is_room_and_no_row_is_lost(made, tmp_path, monkeypatch):
    real = database.open_to_write

    def small(file):
        connection = real(file)
        connection.execute("PRAGMA max_page_count = 40")  # SQLite's own "database or disk is full", SQLITE_FULL
        return connection

    monkeypatch.setattr(database, "open_to_write", small)
    one = made()
    for number in range(3000):
        one.put(reading(number))
    assert eventually(lambda: "full" in one.trouble, 10)
    kept = count(tmp_path)
    assert kept % writer.ROWS_AT_ONCE == 0, "a batch is written whole or not at all"
    monkeypatch.setattr(database, "open_to_write", real)
    assert eventually(lambda: not one.trouble, 5)
    assert eventually(lambda: count(tmp_path) == 3000, 10)


@pytest.mark.parametrize("rubbish", [b"rubbish " * 4000, b""])
def test_a_file_overwritten_while_it_is_open_is_kept_beside_a_fresh_one(made, tmp_path, rubbish):
    one = made()
    one.put(reading(1))
    assert eventually(lambda: count(tmp_path) == 1, 5)
    (tmp_path / database.FILE_NAME).write_bytes(rubbish)
    assert eventually(lambda: one.damage, 5)
    one.put(reading(2))
    one.stop()
    assert count(tmp_path) >= 1
    assert count(tmp_path, "runs") == 1
    assert len(list(tmp_path.glob("history.damaged-*.db"))) == 1


def test_a_file_that_cannot_be_read_is_no_whole_database(made, tmp_path):
    one = made()
    assert eventually(lambda: database.is_whole(tmp_path / database.FILE_NAME), 5)
    one.stop()
    assert not database.is_whole(tmp_path / "gone.db")
    assert not database.is_whole(tmp_path), "a folder"


def test_a_file_that_is_damaged_inside_is_set_aside_at_the_start(made, tmp_path):
    file = tmp_path / database.FILE_NAME
    connection = database.open_to_write(file)
    database.write(connection, [reading(number) for number in range(2000)])
    connection.close()
    size = file.stat().st_size
    with file.open("r+b") as inside:
        inside.seek(size // 2)
        inside.write(b"\xff" * 8192)
    one = made()
    one.put(reading(1))
    assert eventually(lambda: one.damage, 5)
    assert eventually(lambda: count(tmp_path) == 1, 5)
    assert not one.trouble
    (aside,) = tmp_path.glob("history.damaged-*.db")
    assert aside.stat().st_size == size


def test_a_file_of_which_sqlites_own_message_cannot_be_read_is_set_aside_at_the_start(made, tmp_path):
    """SQLite quotes the damaged bytes of a table's definition, and Python raises no `sqlite3.Error` for them."""
    file = tmp_path / database.FILE_NAME
    database.open_to_write(file).close()
    file.write_bytes(file.read_bytes().replace(b"CREATE TABLE readings", b"CREATE TABL\xe0 readings"))
    one = made()
    one.put(reading(1))
    assert eventually(lambda: one.damage, 5)
    assert eventually(lambda: count(tmp_path) == 1, 5)
    assert not one.trouble


def test_a_file_of_a_newer_version_is_left_alone(made, tmp_path):
    connection = database.open_to_write(tmp_path / database.FILE_NAME)
    connection.execute(f"PRAGMA user_version = {schema.VERSION + 1}")
    connection.close()
    one = made()
    assert eventually(lambda: "newer version" in one.trouble, 5)
    assert not list(tmp_path.glob("*damaged*"))


def test_a_file_of_an_older_version_is_brought_up_to_date(tmp_path, monkeypatch):
    file = tmp_path / database.FILE_NAME
    connection = database.open_to_write(file)
    database.write(connection, [reading(1)])
    connection.close()
    monkeypatch.setattr(schema, "MIGRATIONS", (*schema.MIGRATIONS, "ALTER TABLE readings ADD COLUMN newest REAL;"))
    monkeypatch.setattr(schema, "VERSION", schema.VERSION + 1)
    with looking(file) as older, pytest.raises(HistoryError, match="start the gauge once"):
        schema.check_readable(older, str(file))
    connection = database.open_to_write(file)
    assert connection.execute("SELECT sequence, newest FROM readings").fetchall() == [(1, None)]
    connection.close()


def test_a_migration_that_fails_leaves_the_older_version_whole(tmp_path, monkeypatch):
    file = tmp_path / database.FILE_NAME
    database.open_to_write(file).close()
    broken = "ALTER TABLE readings ADD COLUMN newest REAL; ALTER TABLE nowhere ADD COLUMN x REAL;"
    monkeypatch.setattr(schema, "MIGRATIONS", (*schema.MIGRATIONS, broken))
    monkeypatch.setattr(schema, "VERSION", schema.VERSION + 1)
    with pytest.raises(sqlite3.OperationalError, match="nowhere"):
        database.open_to_write(file)
    with looking(file) as connection:
        assert schema.version(connection) == schema.VERSION - 1
        assert "newest" not in [row[1] for row in connection.execute("PRAGMA table_info(readings)")]


def test_rows_that_are_too_old_are_deleted_and_no_others(tmp_path):
    connection = database.open_to_write(tmp_path / database.FILE_NAME)
    database.write(connection, [reading(number) for number in range(12_000)])
    while database.thin(connection, RUN + 11_000, 10**9):
        pass
    first, last, rows = connection.execute("SELECT min(sequence), max(sequence), count(*) FROM readings").fetchone()
    assert (first, last, rows) == (11_000, 11_999, 1000)
    connection.close()


def test_verifications_outlast_the_days_of_other_rows(tmp_path):
    connection = database.open_to_write(tmp_path / database.FILE_NAME)
    database.write(connection, [reading(0), Row("verifications", {"checked_utc_ms": RUN, "recording": "master"})])
    while database.thin(connection, RUN + 11_000, 10**9):
        pass
    assert connection.execute("SELECT count(*) FROM readings").fetchone() == (0,)
    assert connection.execute("SELECT count(*) FROM verifications").fetchone() == (1,)
    connection.close()


def test_the_file_stays_below_its_limit_and_bars_outlast_readings(tmp_path):
    file = tmp_path / database.FILE_NAME
    connection = database.open_to_write(file)
    database.write(connection, [bar(number) for number in range(100)])
    limit = 1 << 20
    for start in range(0, 50_000, 10_000):
        database.write(connection, [reading(number) for number in range(start, start + 10_000)])
        while database.thin(connection, 0, limit):
            pass
    connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    assert file.stat().st_size <= limit
    assert connection.execute("SELECT max(sequence) FROM readings").fetchone() == (49_999,)
    assert connection.execute("SELECT count(*) FROM bars").fetchone() == (100,)
    connection.close()


def test_what_an_earlier_run_left_open_ends_when_it_was_last_alive(made, tmp_path):
    connection = database.open_to_write(tmp_path / database.FILE_NAME)
    earlier = RUN - 100_000
    database.write(
        connection,
        [
            Row("runs", {"started_utc_ms": earlier, "alive_utc_ms": earlier + 5000}),
            Row("alarms", {"came_utc_ms": earlier + 1000, "run_utc_ms": earlier, "name": "alarm_camera"}),
            Row("faults", {"came_utc_ms": earlier + 9000, "run_utc_ms": earlier, "name": "x", "station": ""}),
        ],
    )
    connection.close()
    one = made()
    one.put(Row("alarms", {"came_utc_ms": RUN, "run_utc_ms": RUN, "name": "alarm_stale"}))
    one.stop()
    with looking(tmp_path / database.FILE_NAME) as connection:
        ended = connection.execute("SELECT name, gone_utc_ms FROM alarms ORDER BY came_utc_ms").fetchall()
        assert ended == [("alarm_camera", earlier + 5000), ("alarm_stale", None)]
        assert connection.execute("SELECT gone_utc_ms FROM faults").fetchall() == [(earlier + 9000,)], (
            "not before it came"
        )


def test_killed_at_any_moment_every_committed_row_is_there_once(tmp_path):
    for number in range(10):
        found = write_and_kill(tmp_path / database.FILE_NAME, 0.013 * number)
        assert found == (found.rows, 0, 0, False, True)
