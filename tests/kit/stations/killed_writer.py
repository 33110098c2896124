"""A process that writes the history as fast as it can, killed at some moment; what is in the file afterwards."""

import contextlib
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

ROWS_AT_ONCE = 3
WRITING = f"""
import sys
from pathlib import Path
from appliance.history import database
from appliance.history.tables import Row
connection = database.open_to_write(Path(sys.argv[1]))
for first in range(int(sys.argv[2]), 10**9, {ROWS_AT_ONCE}):
    keys = [dict(exposed_utc_ms=n, run_utc_ms=0, sequence=n) for n in range(first, first + {ROWS_AT_ONCE})]
    database.write(connection, [Row("readings", key) for key in keys])
    print(first + {ROWS_AT_ONCE - 1}, flush=True)
"""


class Found(NamedTuple):
    """What is in the file after a kill.

    Attributes
    ----------
    rows : int
    lost : int
        Rows whose commit had returned, and which are not there.
    twice : int
        Rows that are there more than once.
    partial : bool
        Whether part of a transaction is there.
    whole : bool
        Whether SQLite finds the file in order, opened without any repair.
    """

    rows: int
    lost: int
    twice: int
    partial: bool
    whole: bool


def write_and_kill(file: Path, after_s: float) -> Found:
    """Go on writing where the file ends, and kill the process some time after its first commit."""
    first = len(_sequences(file)) if file.exists() else 0
    words = [sys.executable, "-c", WRITING, str(file), str(first)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        committed = int(process.stdout.readline())
        time.sleep(after_s)
        process.send_signal(signal.SIGKILL)
        lines = process.stdout.read().split("\n")
    told = [int(line) for line in lines[:-1]]  # the last one may be cut
    committed = told[-1] if told else committed
    kept = _sequences(file)
    with contextlib.closing(sqlite3.connect(file)) as connection:
        whole = connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    missing = set(range(committed + 1)) - set(kept)
    return Found(len(kept), len(missing), len(kept) - len(set(kept)), len(kept) % ROWS_AT_ONCE != 0, whole)


def _sequences(file: Path) -> list[int]:
    with contextlib.closing(sqlite3.connect(file)) as connection:
        return [number for (number,) in connection.execute("SELECT sequence FROM readings")]
