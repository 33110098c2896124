"""A week of a mill in the history, in fast time: size, memory and speed of the writer, times of report and export.

10 readings a second, a bar of 15 s every 40 s, an ingot every 20 bars, a lost camera every 100 bars.
"""

import resource
import sys
import tempfile
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

from mill_history import MillHistory

from appliance.cli.main import main
from appliance.history.database import FILE_NAME
from appliance.history.settings import HistorySettings
from appliance.history.writer import READINGS_WAITING_MAX, HistoryWriter

HOURS = 7 * 24.0


def fill(folder: Path, start: datetime, hours: float) -> float:
    """Write a week through the thread, as fast as it takes rows; seconds."""
    writer = HistoryWriter(folder, HistorySettings(), round(1000 * start.timestamp()), version="0.1.0")
    writer.start()

    def put(row) -> None:
        while len(writer._waiting) > READINGS_WAITING_MAX // 2:  # fast time waits for the disk, a line does not
            time.sleep(0.01)
        writer.put(row)

    begun_s = time.perf_counter()
    MillHistory(put, start).run(hours)
    writer.stop()
    if writer.dropped:
        raise SystemExit(f"{writer.dropped} rows were dropped")
    return time.perf_counter() - begun_s


def timed(*words: str) -> float:
    """Run a command; seconds."""
    begun_s = time.perf_counter()
    if main(words) != 0:
        raise SystemExit(f"failed: {words}")
    return time.perf_counter() - begun_s


def memory_mb() -> float:
    """Largest memory of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def run(hours: float) -> None:
    """Print all figures of one history."""
    start = datetime.now(tz=UTC) - timedelta(hours=hours)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        before_mb = memory_mb()
        written_s = fill(folder / "history", start, hours)
        print(f"written in {written_s:.0f} s; memory {before_mb:.0f} MB before, {memory_mb():.0f} MB at most")
        size_mb = (folder / "history" / FILE_NAME).stat().st_size / 2**20
        print(f"on disk {size_mb:.1f} MB for {hours:g} h")
        config = folder / "hotgauge.toml"
        config.write_text('[history]\ndirectory = "history"\n', encoding="utf-8")
        period = ("--from", start.isoformat(), "--to", datetime.now(tz=UTC).isoformat(), "--config", str(config))
        for what, file in (("readings", "r.csv"), ("readings", "r.parquet"), ("bars", "b.csv")):
            output = folder / file
            elapsed_s = timed("export", "--what", what, "--output", str(output), *period)
            print(f"export {what} to {output.suffix}: {elapsed_s:.1f} s, {output.stat().st_size / 2**20:.1f} MB")
        for file in ("week.html", "week.pdf"):
            output = folder / file
            elapsed_s = timed("report", "--output", str(output), *period)
            print(f"report {output.suffix}: {elapsed_s:.1f} s, {output.stat().st_size / 2**20:.1f} MB")
        print(f"memory {memory_mb():.0f} MB at most in all")


if __name__ == "__main__":
    run(float(sys.argv[1]) if len(sys.argv) > 1 else HOURS)
