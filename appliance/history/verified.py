"""Whether the calibration in force has passed a verification, and how long ago."""

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import cast

from appliance.history.read import open_to_read
from appliance.history.tables import VERIFICATIONS

LONG_AGO = datetime(1970, 1, 1, tzinfo=UTC)


def calibration_due(folder: Path, calibration: str, due_days: int, now: datetime) -> str:
    """Why the calibration is due; empty when it is not.

    Parameters
    ----------
    folder : Path
        Of the history.
    calibration : str
        SHA-256 of the file in force; verifications of others do not count.
    due_days : int
        Longest time since a verification passed; 0: time does not count.
    now : datetime

    Raises
    ------
    HistoryError
        The history cannot be read now.
    """
    with open_to_read(folder) as history:
        rows = list(history.rows(VERIFICATIONS, LONG_AGO, now + timedelta(days=1)))
    checked = [
        (datetime.fromtimestamp(cast("int", row["checked_utc_ms"]) / 1000, tz=UTC), str(row["verdict"]))
        for row in rows
        if row["rig_sha256"] == calibration
    ]
    if checked and checked[-1][1] == "fail":
        return f"the verification of {checked[-1][0]:%Y-%m-%d %H:%M} UTC failed"
    if not due_days:
        return ""
    passed = [when for when, verdict in checked if verdict == "pass"]
    if not passed:
        return "no verification of this calibration has passed; run hotgauge verify"
    if now - passed[-1] > timedelta(days=due_days):
        return f"the last verification passed on {passed[-1]:%Y-%m-%d}, more than {due_days} days ago"
    return ""
