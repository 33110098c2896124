"""`hotgauge export`: what the history keeps of a time, in units and words, as CSV and Parquet."""

import csv
import sqlite3
import time
from datetime import UTC, datetime, timedelta, timezone

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from appliance.cli.main import main
from appliance.history import database, schema
from appliance.history import export as export_module
from appliance.history.export import column_kinds, exported
from appliance.history.read import moment, open_to_read
from appliance.history.tables import BARS, READINGS, TABLES, Row
from vision.reasons import Reason

START = datetime(2026, 11, 28, 21, 0, tzinfo=UTC)
START_MS = round(1000 * START.timestamp())


def reading(number: int) -> Row:
    return Row(
        "readings",
        {
            "exposed_utc_ms": START_MS + 60_000 * number,
            "run_utc_ms": START_MS,
            "sequence": number,
            "valid": number % 2,
            "diameter_mm": 250 + number / 100 if number % 2 else None,
            "decision": number % 4,
            "reasons": int(Reason.BAR_HEAD | Reason.LOW_CONTRAST) if number % 2 else int(Reason.NO_BAR),
            "simulated": False,
        },
    )


@pytest.fixture
def config(tmp_path):
    connection = database.open_to_write(tmp_path / "history" / database.FILE_NAME)
    database.write(connection, [reading(number) for number in range(120)])
    database.write(connection, [Row("bars", {"started_utc_ms": START_MS, "run_utc_ms": 0, "bar": 1, "mean_mm": 250.5})])
    connection.close()
    (tmp_path / "hotgauge.toml").write_text('[history]\ndirectory = "history"\n')
    return tmp_path / "hotgauge.toml"


def export(config, output, *, what="readings", start="2026-11-28T21:10Z", end="2026-11-28T21:20Z") -> int:
    words = ["export", "--what", what, "--from", start, "--to", end, "--output", str(output), "--config", str(config)]
    return main(words)


def in_zone(monkeypatch, zone: str) -> None:
    monkeypatch.setenv("TZ", zone)
    time.tzset()
    export_module._both_times.cache_clear()


def test_csv_has_the_rows_of_the_time_with_both_times_and_with_words(config, tmp_path, monkeypatch):
    in_zone(monkeypatch, "Europe/Berlin")
    assert export(config, tmp_path / "out.csv") == 0
    with (tmp_path / "out.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["sequence"]) for row in rows] == list(range(10, 20)), "the first moment belongs to it, the last not"
    assert list(rows[0]) == list(column_kinds(READINGS))
    second = rows[1]
    assert second["exposed_utc"] == "2026-11-28T21:11:00.000Z"
    assert second["exposed_local"] == "2026-11-28T22:11:00.000+01:00"
    assert (second["valid"], second["diameter_mm"], second["decision"]) == ("true", "250.11", "undecided")
    assert second["reasons"] == "low_contrast;bar_head"
    assert rows[0]["diameter_mm"] == ""
    in_zone(monkeypatch, "UTC")


def test_parquet_has_the_same_rows_with_types_as_an_independent_reader_sees_them(config, tmp_path):
    export(config, tmp_path / "out.csv")
    assert export(config, tmp_path / "out.parquet") == 0
    table = pq.read_table(tmp_path / "out.parquet")
    assert table.schema.field("exposed_utc").type == pa.timestamp("ms", tz="UTC")
    assert table.schema.field("valid").type == pa.bool_()
    rows = table.to_pylist()
    assert rows[0]["exposed_utc"] == START + timedelta(minutes=10)
    assert rows[0]["diameter_mm"] is None
    with (tmp_path / "out.csv").open(newline="") as file:
        for ours, theirs in zip(csv.DictReader(file), rows, strict=True):
            assert ours["diameter_mm"] == ("" if theirs["diameter_mm"] is None else str(theirs["diameter_mm"]))
            assert ours["reasons"] == theirs["reasons"]


def test_a_moment_without_an_offset_is_local_time(monkeypatch):
    in_zone(monkeypatch, "Europe/Berlin")
    assert moment("2026-11-28T22:00") == START
    assert moment("2026-07-01T12:00").utcoffset() == timedelta(hours=2)
    assert moment("2026-11-28T21:00Z") == START
    assert moment("2026-11-28T23:00+02:00") == START.astimezone(timezone(timedelta(hours=2)))
    in_zone(monkeypatch, "UTC")


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)
def test_every_table_can_be_exported_even_when_nothing_in_it_is_known(table):
    row = dict.fromkeys(column.name for column in table.columns)
    assert set(exported(table, row)) == set(column_kinds(table))
    assert set(exported(table, row).values()) == {None}


@pytest.mark.parametrize("name", ["out.csv", "out.parquet"])
def test_a_time_in_which_nothing_was_measured_is_a_file_without_rows(config, tmp_path, name):
    assert export(config, tmp_path / name, what="bars", start="2020-01-01", end="2020-01-02") == 0
    assert (tmp_path / name).stat().st_size > 0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"what": "barz"}, "--what: there is no barz; did you mean bars?"),
        ({"start": "yesterday"}, "--from yesterday: no moment; write it as 2026-11-28T22:00"),
        ({"end": "2026-11-28T21:10Z"}, "not after"),
        ({"output": "out.xlsx"}, "give a name that ends in .csv or .parquet"),
        ({"output": "nowhere/out.csv"}, "give a place in a writable folder"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_a_sentence(config, capsys, monkeypatch, changes, said):
    monkeypatch.chdir(config.parent)
    given = {"output": "out.csv"} | changes
    assert export(config, **given) == 2
    assert said in capsys.readouterr().err


def test_a_history_that_is_not_there_or_of_a_newer_version_is_refused_in_a_sentence(config, tmp_path, capsys):
    empty = tmp_path / "empty.toml"
    empty.write_text("")
    assert export(empty, tmp_path / "out.csv") == 2
    assert "history.directory is not set" in capsys.readouterr().err
    empty.write_text('[history]\ndirectory = "nowhere"\n')
    assert export(empty, tmp_path / "out.csv") == 2
    assert "there is no history" in capsys.readouterr().err
    connection = sqlite3.connect(tmp_path / "history" / database.FILE_NAME)
    connection.execute(f"PRAGMA user_version = {schema.VERSION + 1}")
    connection.close()
    assert export(config, tmp_path / "out.csv") == 2
    assert "newer version" in capsys.readouterr().err


def test_a_history_is_read_while_it_is_written(config, tmp_path):
    connection = database.open_to_write(tmp_path / "history" / database.FILE_NAME)
    with open_to_read(tmp_path / "history") as history:
        database.write(connection, [Row("bars", {"started_utc_ms": START_MS + 1, "run_utc_ms": 0, "bar": 2})])
        rows = list(history.rows(BARS, START, START + timedelta(days=1)))
    assert [row["bar"] for row in rows] == [1, 2]
    connection.close()


def test_a_history_of_which_sqlites_own_message_cannot_be_read_is_one_sentence(config, capsys):
    file = config.parent / "history" / database.FILE_NAME
    file.write_bytes(file.read_bytes().replace(b"CREATE TABLE readings", b"CREATE TABL\xe0 readings"))
    assert export(config, config.parent / "out.csv") == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "history.db: what it says of its tables is damaged" in error
