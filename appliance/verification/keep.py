"""Verifications in the history: read the earlier ones, add the new one."""

import contextlib
import sqlite3
from datetime import UTC, datetime
from pathlib import Path
from typing import cast

from appliance.history import database
from appliance.history.read import open_to_read, to_ms
from appliance.history.schema import HistoryError
from appliance.history.tables import VERIFICATIONS, Row, Value
from appliance.verification.check import Verification

LONG_AGO = datetime(1970, 1, 1, tzinfo=UTC)


def earlier_errors(folder: Path) -> list[tuple[float, float]]:
    """Master's diameter and error of all earlier verifications, oldest first; raises `HistoryError`.

    Parameters
    ----------
    folder : Path
        Of the history; one that is not there has none.
    """
    if not (folder / database.FILE_NAME).is_file():
        return []
    with open_to_read(folder) as history:
        rows = list(history.rows(VERIFICATIONS, LONG_AGO, datetime.now(tz=UTC)))
    return [(cast("float", row["master_mm"]), cast("float", row["error_mm"])) for row in rows]


def keep(found: Verification, when: datetime, words: dict[str, str], folder: Path) -> None:
    """Add a verification to the history, also while the gauge writes to it.

    Parameters
    ----------
    found : Verification
    when : datetime
    words : dict of str to str
        Columns of text: recording, rig, rig_sha256, who.
    folder : Path

    Raises
    ------
    HistoryError
        It cannot be written.
    """
    values: dict[str, Value] = {"checked_utc_ms": to_ms(when), **words}
    values |= {
        "master_mm": found.master.diameter_mm,
        "master_expanded_mm": found.master.expanded_mm,
        "readings": found.readings,
        "missing": found.missing,
        "mean_mm": found.mean_mm,
        "error_mm": found.error_mm,
        "repeatability_mm": found.repeatability_mm,
        "test_expanded_mm": found.test_expanded_mm,
        "limit_mm": found.limit_mm,
        "drift_mm": found.drift_mm,
        "verdict": found.verdict,
    }
    file = folder / database.FILE_NAME
    try:
        with database.undecodable_is_damage(), contextlib.closing(database.open_to_write(file)) as connection:
            database.write(connection, [Row("verifications", values)])
    except (sqlite3.Error, OSError) as error:
        raise HistoryError(f"{file}: {error}; verify as the user of the service") from error
