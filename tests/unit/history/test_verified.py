"""When a calibration is due: after a failed verification of it, or too long after one that passed."""

import asyncio
from datetime import UTC, datetime, timedelta

import pytest
from pydantic import ValidationError

from appliance.conformity.plc_inputs import PlcInputs
from appliance.diagnostics.alarms import Alarms
from appliance.diagnostics.faults import Faults
from appliance.history import database, keeper
from appliance.history.settings import HistorySettings
from appliance.history.tables import Row
from appliance.history.verified import calibration_due

NOW = datetime(2026, 11, 29, 8, 0, tzinfo=UTC)


def history(folder, *checks: tuple[float, str, str]) -> None:
    connection = database.open_to_write(folder / database.FILE_NAME)
    for days_ago, rig, verdict in checks:
        when = NOW - timedelta(days=days_ago)
        values = {"checked_utc_ms": round(1000 * when.timestamp()), "recording": "r", "rig_sha256": rig}
        database.write(connection, [Row("verifications", {**values, "verdict": verdict})])
    connection.close()


@pytest.mark.parametrize(
    ("checks", "due_days", "said"),
    [
        ([], 0, ""),
        ([], 30, "no verification of this calibration has passed"),
        ([(1, "mine", "pass")], 30, ""),
        ([(31, "mine", "pass")], 30, "the last verification passed on 2026-10-29"),
        ([(31, "mine", "pass")], 0, ""),
        ([(1, "mine", "fail")], 0, "the verification of 2026-11-28 08:00 UTC failed"),
        ([(2, "mine", "fail"), (1, "mine", "pass")], 30, ""),
        ([(2, "mine", "pass"), (1, "mine", "fail")], 30, "failed"),
        ([(1, "another", "fail")], 0, ""),
        ([(1, "another", "pass")], 30, "no verification of this calibration has passed"),
        ([(1, "mine", "undecided")], 30, "no verification of this calibration has passed"),
    ],
)
def test_a_calibration_is_due_after_a_failed_verification_or_a_time(tmp_path, checks, due_days, said):
    history(tmp_path, *checks)
    found = calibration_due(tmp_path, "mine", due_days, NOW)
    assert said in found
    assert bool(said) == bool(found)


def test_a_history_that_cannot_be_read_now_lifts_no_due_date(tmp_path, monkeypatch):
    history(tmp_path, (1, "mine", "fail"))
    monkeypatch.setattr(keeper, "VERIFICATION_PERIOD_S", 0.01)
    settings = HistorySettings(directory=tmp_path)
    kept = keeper.HistoryKeeper(settings, PlcInputs(None, lambda *_: None), trust_min=50.0, wall=NOW.timestamp)
    kept.recorder.set_calibration(None, "mine")
    faults = Faults(lambda: 0)

    async def keep() -> None:
        keeping = asyncio.create_task(kept.keep())
        await asyncio.sleep(0.3)
        (tmp_path / database.FILE_NAME).rename(tmp_path / "away.db")
        await asyncio.sleep(0.3)
        kept.update(faults, Alarms())
        keeping.cancel()

    asyncio.run(keep())
    asyncio.run(kept.stop())
    assert "failed" in faults.details["calibration_due", ""]


def test_a_due_date_without_a_history_is_refused(tmp_path):
    with pytest.raises(ValidationError, match="verification_due_days needs the history"):
        HistorySettings(verification_due_days=30)
    assert HistorySettings(verification_due_days=30, directory=tmp_path).verification_due_days == 30
