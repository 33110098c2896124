"""The SQL of the history, in versions; a file of an older one is brought to the newest when it is opened to write."""

import sqlite3

from appliance.errors import HotgaugeError


class HistoryError(HotgaugeError):
    """The history cannot be read; the message says what, where and what to do."""


MIGRATIONS: tuple[str, ...] = (
    """
    CREATE TABLE readings (
        exposed_utc_ms INTEGER, run_utc_ms INTEGER, sequence INTEGER, bar INTEGER, valid INTEGER,
        diameter_mm REAL, expanded_uncertainty_mm REAL, diameter_cold_mm REAL, expanded_uncertainty_cold_mm REAL,
        diameter_virtual_board_mm REAL, weighted_deviation_mm REAL, trust REAL, deviation_mm REAL, decision INTEGER,
        reasons INTEGER, windows_kept INTEGER, windows_total INTEGER, alignment_quality REAL, plane_height_mm REAL,
        axis_height_mm REAL, offset_mm REAL, u_edge_mm REAL, u_calibration_mm REAL, u_board_mm REAL, u_light_mm REAL,
        u_shape_mm REAL, u_model_mm REAL, elapsed_ms REAL, product_id INTEGER, simulated INTEGER,
        PRIMARY KEY (exposed_utc_ms, run_utc_ms, sequence)
    ) WITHOUT ROWID;
    CREATE TABLE bars (
        started_utc_ms INTEGER, run_utc_ms INTEGER, bar INTEGER, ended_utc_ms INTEGER, product_id INTEGER,
        grade INTEGER, temperature_c REAL, target_mm REAL, tolerance_plus_mm REAL, tolerance_minus_mm REAL,
        readings INTEGER, readings_out INTEGER, head_mm REAL, body_mm REAL, tail_mm REAL, smallest_mm REAL,
        mean_mm REAL, largest_mm REAL, spread_mm REAL, expanded_uncertainty_mm REAL, mean_cold_mm REAL,
        expanded_uncertainty_cold_mm REAL, deviation_mm REAL, decision INTEGER, trust REAL, reasons INTEGER,
        simulated INTEGER,
        PRIMARY KEY (started_utc_ms, run_utc_ms, bar)
    ) WITHOUT ROWID;
    CREATE TABLE ingots (
        told_utc_ms INTEGER, run_utc_ms INTEGER, ingot INTEGER, orientation TEXT, confidence REAL, ssim_top REAL,
        ssim_bottom REAL, product_id INTEGER, simulated INTEGER,
        PRIMARY KEY (told_utc_ms, run_utc_ms, ingot)
    ) WITHOUT ROWID;
    CREATE TABLE alarms (
        came_utc_ms INTEGER, run_utc_ms INTEGER, name TEXT, acknowledged_utc_ms INTEGER, gone_utc_ms INTEGER,
        product_id INTEGER,
        PRIMARY KEY (came_utc_ms, run_utc_ms, name)
    ) WITHOUT ROWID;
    CREATE TABLE faults (
        came_utc_ms INTEGER, run_utc_ms INTEGER, name TEXT, station TEXT, code INTEGER, state INTEGER, detail TEXT,
        gone_utc_ms INTEGER,
        PRIMARY KEY (came_utc_ms, run_utc_ms, name, station)
    ) WITHOUT ROWID;
    CREATE TABLE set_point_writes (
        written_utc_ms INTEGER, run_utc_ms INTEGER, name TEXT, value REAL,
        PRIMARY KEY (written_utc_ms, run_utc_ms, name)
    ) WITHOUT ROWID;
    CREATE TABLE calibrations (
        found_utc_ms INTEGER, run_utc_ms INTEGER, file TEXT, sha256 TEXT,
        PRIMARY KEY (found_utc_ms, run_utc_ms, file)
    ) WITHOUT ROWID;
    CREATE TABLE runs (
        started_utc_ms INTEGER, alive_utc_ms INTEGER, version TEXT,
        PRIMARY KEY (started_utc_ms)
    ) WITHOUT ROWID;
    """,
    """
    CREATE TABLE verifications (
        checked_utc_ms INTEGER, recording TEXT, rig TEXT, rig_sha256 TEXT, who TEXT, master_mm REAL,
        master_expanded_mm REAL, readings INTEGER, missing INTEGER, mean_mm REAL, error_mm REAL, repeatability_mm REAL,
        test_expanded_mm REAL, limit_mm REAL, drift_mm REAL, verdict TEXT,
        PRIMARY KEY (checked_utc_ms, recording)
    ) WITHOUT ROWID;
    """,
    """
    ALTER TABLE readings ADD COLUMN adjustment_mm REAL;
    ALTER TABLE set_point_writes ADD COLUMN role TEXT;
    ALTER TABLE set_point_writes ADD COLUMN address TEXT;
    ALTER TABLE set_point_writes ADD COLUMN certificate TEXT;
    CREATE TABLE mark_checks (
        day_utc_ms INTEGER, run_utc_ms INTEGER, readings INTEGER, mean_px REAL, largest_px REAL, simulated INTEGER,
        PRIMARY KEY (day_utc_ms, run_utc_ms)
    ) WITHOUT ROWID;
    CREATE TABLE adjustments (
        found_utc_ms INTEGER, run_utc_ms INTEGER, added_mm REAL, expanded_mm REAL, date TEXT, reason TEXT, who TEXT,
        PRIMARY KEY (found_utc_ms, run_utc_ms)
    ) WITHOUT ROWID;
    """,
    """
    ALTER TABLE adjustments ADD COLUMN calibration_sha256 TEXT;
    """,
)
"""SQL that leads from each version to the next; one that was released never changes."""

VERSION = len(MIGRATIONS)


def version(connection: sqlite3.Connection) -> int:
    """Version of the schema that a file has; 0 for a new file."""
    return int(connection.execute("PRAGMA user_version").fetchone()[0])


def check_readable(connection: sqlite3.Connection, file: str) -> None:
    """Raise `HistoryError` unless the file has the version that this software reads."""
    found = version(connection)
    if found > VERSION:
        raise HistoryError(f"{file}: written by a newer version of Hotgauge (schema {found}); update this one")
    if found < VERSION:
        raise HistoryError(
            f"{file}: schema {found}, read is {VERSION}; start the gauge once, which brings it up to date"
        )


def migrate(connection: sqlite3.Connection, file: str) -> None:
    """Bring a file to the newest version, each step whole or not at all.

    Parameters
    ----------
    connection : sqlite3.Connection
        In autocommit mode.
    file : str
        Its name, for the sentence that refuses.

    Raises
    ------
    HistoryError
        A newer version of the software has written the file.
    """
    if version(connection) > VERSION:
        check_readable(connection, file)
    for number in range(version(connection), VERSION):
        connection.executescript(f"BEGIN IMMEDIATE; {MIGRATIONS[number]} PRAGMA user_version = {number + 1}; COMMIT;")
