"""The report says what the history holds, each shift on one page, and refuses in sentences."""

import re
import sys
from datetime import UTC, datetime, timedelta

import pytest
from mill_history import MillHistory

from appliance.cli.main import main
from appliance.history import database
from appliance.history.read import open_to_read
from appliance.history.tables import Row
from appliance.reports.intervals import Interval, length_ms, merged, without
from appliance.reports.shift import read_shift, shifts
from plc.codes import Decision

START = datetime(2026, 6, 1, 6, tzinfo=UTC)
START_MS = round(1000 * START.timestamp())
SHIFT = timedelta(hours=8)
HOUR_MS = 3_600_000


def save(folder, rows: list[Row]) -> None:
    connection = database.open_to_write(folder / database.FILE_NAME)
    database.write(connection, rows)
    connection.close()


@pytest.fixture
def config(tmp_path):
    (tmp_path / "hotgauge.toml").write_text('[history]\ndirectory = "history"\n')
    return tmp_path / "hotgauge.toml"


@pytest.fixture(scope="module")
def mill(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mill")
    (folder / "hotgauge.toml").write_text('[history]\ndirectory = "history"\n')
    rows: list[Row] = []
    MillHistory(rows.append, START).run(3)
    save(folder / "history", rows)
    return folder / "hotgauge.toml"


def report(config, output, *more: str, end: str = "2026-06-01T14:00Z") -> int:
    words = ["report", "--from", "2026-06-01T06:00Z", "--to", end, "--output", str(output), "--config", str(config)]
    return main([*words, *more])


def event(table: str, name: str, came_h: float, gone_h: float | None, **values) -> Row:
    gone = {"gone_utc_ms": None if gone_h is None else START_MS + round(gone_h * HOUR_MS)}
    key = {"came_utc_ms": START_MS + round(came_h * HOUR_MS), "run_utc_ms": START_MS, "name": name}
    return Row(table, key | gone | values)


def run(started_h: float, alive_h: float) -> Row:
    times = {
        "started_utc_ms": START_MS + round(started_h * HOUR_MS),
        "alive_utc_ms": START_MS + round(alive_h * HOUR_MS),
    }
    return Row("runs", {**times, "version": "1.2.3"})


def bar(number: int, deviation_mm: float, decision: Decision, target_mm: float = 250.0) -> Row:
    values: dict = {"started_utc_ms": START_MS + 60_000 * number, "run_utc_ms": START_MS, "bar": number, "grade": None}
    values |= {
        "target_mm": target_mm,
        "tolerance_plus_mm": 2.0,
        "tolerance_minus_mm": 1.0,
        "deviation_mm": deviation_mm,
    }
    values |= {"decision": int(decision), "expanded_uncertainty_mm": 0.1, "mean_mm": target_mm + deviation_mm}
    return Row("bars", values)


def read(folder, rows: list[Row]):
    save(folder, rows)
    with open_to_read(folder) as history:
        return read_shift(history, START, START + SHIFT)


def test_available_is_the_time_that_it_ran_without_a_failure(tmp_path):
    rows = [
        run(-1, 3),  # began before the shift
        run(4, 9),  # goes on after it
        event("faults", "camera_lost", 2.5, 3.5, station="sizing", state=4),  # half an hour of it while nothing ran
        event("faults", "camera_lost", 2.75, 3.0, station="ingot", state=4),  # counted once
        event("faults", "camera_hot", 5, 6, station="sizing", state=1),  # no failure
        event("faults", "rig_unusable", 7, None, station="sizing", state=4),
    ]
    shift = read(tmp_path, rows)
    assert shift.running_share == pytest.approx(7 / 8)
    assert shift.available_share == pytest.approx((7 - 0.5 - 1) / 8)
    assert shift.versions == ["1.2.3"]


def test_alarms_count_with_the_time_that_they_had_in_the_shift_longest_first(tmp_path):
    rows = [
        event("alarms", "alarm_stale", 1, 1.5),
        event("alarms", "alarm_camera", -2, 1),
        event("alarms", "alarm_camera", 6, 6.25),
        event("alarms", "alarm_low_trust", -3, -1),
    ]
    camera, stale = read(tmp_path, rows).alarms
    assert (camera.name, camera.times, camera.total_s, camera.longest_s) == ("alarm_camera", 2, 4500, 3600)
    assert (stale.name, stale.times, stale.total_s) == ("alarm_stale", 1, 1800)


def test_bars_are_counted_by_decision_and_judged_by_target(tmp_path):
    rows = [bar(number, 0.1 * (number % 7), Decision.IN) for number in range(20)]
    rows += [bar(20 + number, -1.5, Decision.OUT, 150.0) for number in range(3)]
    rows += [bar(30, 9.0, Decision.OUT), bar(31, 1.95, Decision.UNDECIDED), bar(480, 0.0, Decision.IN)]
    shift = read(tmp_path, rows)
    assert shift.decisions == {Decision.IN: 20, Decision.OUT: 4, Decision.UNDECIDED: 1}, "one began with the next shift"
    assert [bar["bar"] for bar in shift.out] == [30, 20, 21, 22]
    assert [(one.target_mm, len(one.bars)) for one in shift.series] == [(250.0, 22), (150.0, 3)]
    assert shift.series[0].capability.bars == 22
    assert shift.series[1].capability is None
    assert len(shift.chart.means) == 4, "a subgroup holds bars of one target only"


def test_a_time_is_cut_into_shifts_and_ends_now(tmp_path):
    save(tmp_path, [])
    now = datetime.now(tz=UTC)
    with open_to_read(tmp_path) as history:
        found = list(shifts(history, now - timedelta(hours=20), now + timedelta(days=1), hours=8))
        assert list(shifts(history, now + timedelta(hours=1), now + timedelta(days=1), hours=8)) == []
    assert [round((one.end - one.start).total_seconds() / 3600, 1) for one in found] == [8, 8, 4]
    assert abs(found[-1].end - now) < timedelta(minutes=1)


def test_intervals_that_overlap_are_counted_once():
    parts = [Interval(0, 10), Interval(5, 12), Interval(20, 30), Interval(30, 31)]
    assert merged(parts) == [Interval(0, 12), Interval(20, 31)]
    assert length_ms(parts) == 23
    assert without(parts, [Interval(8, 22), Interval(25, 26)]) == 8 + 8
    assert Interval(0, 10).within(Interval(20, 30)).length_ms == 0
    assert Interval(25, 40).within(Interval(20, 30)) == Interval(25, 30)


def test_html_stands_alone_and_says_the_figures(mill, tmp_path):
    assert report(mill, tmp_path / "shift.html") == 0
    html = (tmp_path / "shift.html").read_text()
    with open_to_read(mill.parent / "history") as history:
        shift = read_shift(history, START, START + SHIFT)
    assert len(shift.bars) == 270
    assert f"<b>{shift.decisions[Decision.IN]}</b>in tolerance" in html
    assert f"{shift.series[0].capability.cpk.value:.2f} (" in html
    assert f"{100 * shift.available_share:.1f} %" in html
    assert html.count("data:image/svg+xml") == 2
    assert not re.search(r'(?:src|href)="http', html), "a page that needs the network is no page for a mill"


def test_a_shift_in_which_nothing_ran_is_a_page_that_says_so(config, tmp_path):
    save(tmp_path / "history", [])
    assert report(config, tmp_path / "empty.html") == 0
    html = (tmp_path / "empty.html").read_text()
    assert "not running" in html
    assert "No bar was judged" in html


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("shift.docx", "give a name that ends in .html or .pdf"),
        ("nowhere/shift.html", "give a place in a writable folder"),
    ],
)
def test_what_cannot_be_written_is_refused_in_a_sentence(mill, tmp_path, capsys, name, said):
    assert report(mill, tmp_path / name) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("library", ["jinja2", "matplotlib"])
def test_without_a_library_the_sentence_says_how_to_install_it(mill, capsys, monkeypatch, library):
    monkeypatch.setitem(sys.modules, library, None)
    monkeypatch.chdir(mill.parent)
    assert report(mill, "without.html") == 2
    assert "pip install jinja2 matplotlib weasyprint" in capsys.readouterr().err
    assert not (mill.parent / "without.html").exists()
