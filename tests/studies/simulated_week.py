"""A week of a mill in the history, in fast time: size, the writer's memory, times of export and report."""

import os
import resource
import subprocess
import tempfile
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pyarrow.parquet as pq
from mill_history import MillHistory
from running import HOTGAUGE

from appliance.history.database import FILE_NAME
from appliance.history.settings import HistorySettings
from appliance.history.writer import READINGS_WAITING_MAX, HistoryWriter

TEXT = (
    "10 readings a second, a bar of 15 s every 40 s, an ingot every 20 bars, a lost camera every 100 bars, written "
    "through the recorder and the writer as fast as the disk takes them; then the commands that a user gives, each in "
    "its own process, for the last day and for all of it. Seconds and memory include the process's start; load is that "
    "of the computer, of two processors, at the end."
)
REPEATABLE = False  # times of a computer and a day
HOURS = 7 * 24
DAY_HOURS = 24
COMMANDS = {
    "readings.csv": ("export", "--what", "readings"),
    "readings.parquet": ("export", "--what", "readings"),
    "bars.csv": ("export", "--what", "bars"),
    "report.html": ("report", "--shift-hours", "8"),
    "report.pdf": ("report", "--shift-hours", "8"),
}


def cases():
    return [{"hours": HOURS}]


def run(case):
    start = datetime.now(tz=UTC) - timedelta(hours=case["hours"])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = _fill(folder / "history", start, case["hours"])
        config = folder / "hotgauge.toml"
        config.write_text('[history]\ndirectory = "history"\n', encoding="utf-8")
        until = start + timedelta(hours=case["hours"])
        found["day"] = _commands(folder, config, until - timedelta(hours=DAY_HOURS), until)
        found["all"] = _commands(folder, config, start, until)
        for table in ("readings", "bars"):
            found[table] = pq.read_metadata(_exported(folder, config, table, start, until)).num_rows
    return found | {"load": round(os.getloadavg()[0], 1)}


def _fill(folder, start, hours):
    """Write the hours through the writer's thread, as fast as it takes rows."""
    before_mb = _peak_mb()
    writer = HistoryWriter(folder, HistorySettings(), round(1000 * start.timestamp()), version="0.1.0")
    writer.start()

    def put(row):
        while len(writer._waiting) > READINGS_WAITING_MAX // 2:  # fast time waits for the disk, a line does not
            time.sleep(0.01)
        writer.put(row)

    begun_s = time.perf_counter()
    MillHistory(put, start).run(hours)
    writer.stop()
    return {
        "written_s": round(time.perf_counter() - begun_s, 1),
        "dropped": writer.dropped,
        "on_disk_mb": round((folder / FILE_NAME).stat().st_size / 2**20, 1),
        "grown_mb": round(_peak_mb() - before_mb, 1),
    }


def _peak_mb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _commands(folder, config, since, until):
    found = {}
    for file, words in COMMANDS.items():
        period = ("--from", since.isoformat(), "--to", until.isoformat(), "--config", str(config))
        begun_s = time.perf_counter()
        process = subprocess.Popen([HOTGAUGE, *words, *period, "--output", str(folder / file)])
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0, words
        found[file] = {
            "seconds": round(time.perf_counter() - begun_s, 1),
            "memory_mb": round(used.ru_maxrss / 1024),
            "size_mb": round((folder / file).stat().st_size / 2**20, 1),
        }
    return found


def _exported(folder, config, table, since, until):
    file = folder / f"all_{table}.parquet"
    period = ("--from", since.isoformat(), "--to", until.isoformat(), "--config", str(config))
    subprocess.run([HOTGAUGE, "export", "--what", table, *period, "--output", str(file)], check=True)
    return file


def summary(rows):
    return rows[0]
