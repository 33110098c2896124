"""What the history keeps of readings, bars, ingots, alarms, faults and writes."""

import statistics
from pathlib import Path

import pytest
from messages import reading, verdict

from appliance.conformity.plc_inputs import PlcInputs
from appliance.history.recorder import Recorder
from appliance.history.settings import HistorySettings
from appliance.sizing.adjustment import Adjustment
from plc.security.roles import Client, Role
from vision.reasons import Reason

RUN = 1_700_000_000_000


DECIDED = {"date": "2026-11-28", "reason": "master 250.00", "who": "A. Smith", "calibration_sha256": "5e" * 32}


class Kept:
    """A recorder, and the rows that it makes."""

    def __init__(self, **settings: float) -> None:
        self.now_s = 1_700_000_100.0
        self.inputs = PlcInputs(None, lambda *_: None)
        self.rows: list = []
        made = HistorySettings(**settings)
        self.recorder = Recorder(self.rows.append, RUN, made, self.inputs, trust_min=50.0, wall=lambda: self.now_s)
        self.sequence = 0

    def read(self, bar: int = 1, diameter_mm: float | None = 250.0, *, after_s: float = 0.125, **served) -> None:
        """Let a reading come; without a diameter there is no bar."""
        self.sequence += 1
        self.now_s += after_s
        reasons = served.pop("reasons", Reason.NONE if diameter_mm is not None else Reason.NO_BAR)
        moved_px = served.pop("marks_moved_px", float("nan"))
        message = reading(
            sequence=self.sequence,
            exposed_monotonic_s=self.now_s,
            exposed_utc_ms=round(1000 * self.now_s),
            diameter_mm=diameter_mm,
            reasons=reasons,
            marks_moved_px=moved_px,
        )
        values = {"bar_sequence": bar, "validity": int(diameter_mm is not None), "reason_word": int(reasons)}
        if diameter_mm is not None:
            values |= {"measurement_valid": True, "diameter": diameter_mm, "expanded_uncertainty": 0.2, "trust": 90.0}
        self.recorder.add_reading(message, values | served)

    def of(self, table: str) -> list[dict]:
        return [row.values for row in self.rows if row.table == table]


def test_of_a_bar_one_reading_in_the_period_is_kept():
    kept = Kept(reading_period_s=0.5)
    for _ in range(100):
        kept.read()
    assert len(kept.of("readings")) == 25


def test_without_a_bar_one_reading_a_minute_is_kept():
    kept = Kept()
    for _ in range(961):
        kept.read(diameter_mm=None)
    assert len(kept.of("readings")) == 3


@pytest.mark.parametrize(
    "change", [{"decision": 2}, {"reasons": Reason.LOW_CONTRAST}, {"diameter_mm": None}, {"bar": 2}]
)
def test_a_reading_that_says_something_new_is_kept_whenever_it_comes(change):
    kept = Kept(reading_period_s=100)
    kept.read()
    kept.read()
    kept.read(**change)
    kept.read(**change)
    assert [row["sequence"] for row in kept.of("readings")] == [1, 3]


def test_every_reading_is_kept_with_a_period_of_nothing():
    kept = Kept(reading_period_s=0)
    for _ in range(10):
        kept.read()
    assert len(kept.of("readings")) == 10


def test_a_reading_is_kept_as_it_was_served():
    kept = Kept()
    kept.inputs.add({"product_id": 4711})
    kept.read(diameter_mm=249.5, trust=88.0, decision=1)
    (row,) = kept.of("readings")
    assert row["run_utc_ms"] == RUN
    assert (row["diameter_mm"], row["trust"], row["decision"]) == (249.5, 88.0, 1)
    assert row["diameter_cold_mm"] is None
    assert row["product_id"] == 4711


def test_a_bar_is_kept_with_head_body_and_tail_apart():
    kept = Kept()
    body = [249.8, 250.1, 250.3, 249.9]
    kept.read(diameter_mm=253.0, reasons=Reason.BAR_HEAD)
    for diameter_mm in body:
        kept.read(diameter_mm=diameter_mm)
    kept.read(diameter_mm=247.0, reasons=Reason.BAR_TAIL)
    kept.recorder.end_bar()
    (bar,) = kept.of("bars")
    assert (bar["head_mm"], bar["tail_mm"]) == (253.0, 247.0)
    assert bar["mean_mm"] == bar["body_mm"] == pytest.approx(statistics.mean(body))
    assert bar["spread_mm"] == pytest.approx(statistics.stdev(body))
    assert (bar["smallest_mm"], bar["largest_mm"]) == (249.8, 250.3)
    assert bar["readings"] == 6
    assert bar["expanded_uncertainty_mm"] == pytest.approx(0.2)
    assert bar["reasons"] == Reason.BAR_HEAD | Reason.BAR_TAIL
    assert bar["ended_utc_ms"] - bar["started_utc_ms"] == 625


@pytest.mark.parametrize(
    ("diameter_mm", "decision"),
    [(250.2, 1), (251.1, 3), (251.3, 2), (248.7, 2)],
    ids=["in", "undecided", "out", "under"],
)
def test_a_bar_is_decided_by_its_mean_with_its_uncertainty_as_guard_band(diameter_mm, decision):
    kept = Kept()
    kept.inputs.add({"target_diameter": 25000, "tolerance_plus": 100, "tolerance_minus": 100})
    kept.read(diameter_mm=diameter_mm, decision=2)
    kept.read(diameter_mm=diameter_mm, decision=1)
    kept.recorder.end_bar()
    (bar,) = kept.of("bars")
    assert bar["decision"] == decision
    assert bar["deviation_mm"] == pytest.approx(diameter_mm - 250)
    assert bar["readings_out"] == 1


def test_a_bar_that_cannot_be_trusted_is_undecided():
    kept = Kept()
    kept.inputs.add({"target_diameter": 25000, "tolerance_plus": 100, "tolerance_minus": 100})
    for trust in (80.0, 10.0, 20.0):
        kept.read(diameter_mm=255.0, trust=trust)
    kept.recorder.end_bar()
    (bar,) = kept.of("bars")
    assert (bar["decision"], bar["trust"]) == (3, pytest.approx(110 / 3))


def test_a_bar_with_a_grade_is_decided_by_its_cold_size_and_not_at_all_without_one():
    kept = Kept()
    kept.inputs.add({"target_diameter": 24600, "tolerance_plus": 100, "tolerance_minus": 100, "expansion_grade": 1})
    kept.read(diameter_cold=246.3, expanded_uncertainty_cold=0.3)
    kept.read(bar=2)
    kept.recorder.end_bar()
    cold, without = kept.of("bars")
    assert (cold["deviation_mm"], cold["decision"]) == (pytest.approx(0.3), 1)
    assert (without["deviation_mm"], without["decision"]) == (None, 0)


def test_the_next_bar_ends_the_one_before_and_a_bar_is_kept_once():
    kept = Kept()
    kept.read(bar=1)
    kept.read(bar=2)
    kept.recorder.end_bar()
    kept.recorder.end_bar()
    assert [row["bar"] for row in kept.of("bars")] == [1, 2]


def test_an_ingot_is_kept_with_its_number_since_the_start_of_the_run():
    kept = Kept()
    kept.recorder.add_verdict(verdict(ingot=1, orientation="bottom"), 17, simulated=False)
    (row,) = kept.of("ingots")
    assert (row["ingot"], row["orientation"], row["confidence"]) == (17, "bottom", 99.5)


def test_an_alarm_is_one_row_that_learns_of_its_acknowledgement_and_of_its_end():
    kept = Kept()
    name = "alarm_camera"
    kept.recorder.update_alarms({name}, {name})
    kept.now_s += 1
    kept.recorder.update_alarms({name}, {name})
    kept.recorder.update_alarms(set(), {name})
    kept.now_s += 1
    kept.recorder.update_alarms(set(), set())
    rows = kept.of("alarms")
    assert len({(row["came_utc_ms"], row["name"]) for row in rows}) == 1
    came = rows[0]["came_utc_ms"]
    assert "gone_utc_ms" not in rows[0]
    assert (rows[-1]["gone_utc_ms"] - came, rows[-1]["acknowledged_utc_ms"] - came) == (1000, 2000)


def test_a_fault_of_two_stations_is_two_rows_and_each_ends_by_itself():
    kept = Kept()
    both = {("camera_lost", "sizing"): "left.png: broken", ("camera_lost", "ingot"): ""}
    kept.recorder.update_faults(both)
    kept.now_s += 1
    kept.recorder.update_faults({("camera_lost", "ingot"): ""})
    sizing, ingot, ended = kept.of("faults")
    assert (sizing["station"], sizing["detail"], sizing["code"], sizing["state"]) == (
        "sizing",
        "left.png: broken",
        101,
        4,
    )
    assert ingot["detail"] == "the cameras give no pictures"
    assert (ended["station"], ended["gone_utc_ms"] - ended["came_utc_ms"]) == ("sizing", 1000)


def test_writes_are_kept_in_units_and_a_heartbeat_is_none():
    kept = Kept()
    changed = {"target_diameter": 25015, "hold": True, "plc_heartbeat": 3, "product_id": 70000}
    kept.recorder.add_writes(changed, Client("10.0.0.5", Role.OPERATOR, "line 3"))
    assert {row["name"]: row["value"] for row in kept.of("set_point_writes")} == {
        "target_diameter": 250.15, "hold": 1.0, "product_id": 70000,
    }  # fmt: skip
    who = {(row["role"], row["address"], row["certificate"]) for row in kept.of("set_point_writes")}
    assert who == {("operator", "10.0.0.5", "line 3")}


def test_the_still_marks_of_a_day_are_one_row_that_grows_and_the_next_day_has_its_own():
    kept = Kept()
    kept.now_s = 1_700_006_400.0  # 2023-11-15, midnight UTC
    for number in range(200):
        kept.read(marks_moved_px=0.1 if number % 2 else 0.2, after_s=60.0)
    kept.read(marks_moved_px=float("nan"))
    days = kept.of("mark_checks")
    assert {row["day_utc_ms"] for row in days} == {1_700_006_400_000}
    assert days[-1]["mean_px"] == pytest.approx(0.15, abs=0.01)
    assert days[-1]["largest_px"] == 0.2
    assert days[-1]["readings"] > days[0]["readings"] >= 60
    kept.now_s = 1_700_092_800.0
    for _ in range(100):
        kept.read(marks_moved_px=0.4)
    assert (kept.of("mark_checks")[-1]["day_utc_ms"], kept.of("mark_checks")[-1]["mean_px"]) == (1_700_092_800_000, 0.4)


def test_what_the_still_marks_showed_in_a_days_last_hour_is_kept_at_midnight():
    kept = Kept()
    kept.now_s = 1_700_092_800.0 - 151.0
    for _ in range(150):
        kept.read(marks_moved_px=0.2, after_s=1.0)
    assert kept.of("mark_checks")[-1]["readings"] == 100
    kept.read(marks_moved_px=0.4, after_s=2.0)
    row = kept.of("mark_checks")[-1]
    assert (row["readings"], row["day_utc_ms"], row["largest_px"]) == (150, 1_700_006_400_000, 0.2)
    kept.recorder.end_day()
    assert kept.of("mark_checks")[-1] == row  # one reading of the next day is no day


def test_a_calibration_is_a_row_when_its_content_is_another():
    kept = Kept()
    for sha256 in ("", "one", "one", "two"):
        kept.recorder.set_calibration(Path("rig.json"), sha256)
    assert [(row["file"], row["sha256"]) for row in kept.of("calibrations")] == [
        ("rig.json", "one"),
        ("rig.json", "two"),
    ]
    assert kept.recorder.calibration == "two"


def test_a_known_error_that_stays_is_one_row_however_often_settings_are_read():
    kept = Kept()
    known = Adjustment(added_mm=-0.1, expanded_mm=0.02, **DECIDED)
    for _ in range(3):
        kept.recorder.set_adjustment(known)
    kept.recorder.set_adjustment(known.model_copy(update={"who": "B. Jones"}))
    assert [row["who"] for row in kept.of("adjustments")] == ["A. Smith", "B. Jones"]


def test_a_known_error_that_is_taken_off_is_a_row_and_so_is_its_end_but_none_is_none():
    kept = Kept()
    kept.recorder.set_adjustment(Adjustment())
    assert kept.of("adjustments") == []
    known = Adjustment(added_mm=-0.1, expanded_mm=0.02, **DECIDED)
    kept.recorder.set_adjustment(known)
    kept.recorder.set_adjustment(Adjustment())
    assert [(row["added_mm"], row["who"]) for row in kept.of("adjustments")] == [(-0.1, "A. Smith"), (0.0, "")]
