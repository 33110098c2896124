"""One table: what the gauge computes, beside what a user would pick instead, in turn in one run.

The ratios are what to quote: times depend on the machine. `--keep` writes them to `ratios.json`, once for each release;
every other run is set beside the last ones kept, and a row whose processor ratio has slipped by more than 15 % is
marked and ends the program with 1.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from importlib.metadata import version
from pathlib import Path

import cv2
import rivals
from timing import Row

KEPT = Path(__file__).with_name("ratios.json")
TABLE = (
    (partial(rivals.gauge, rivals.SMALL), 9),
    (partial(rivals.gauge, rivals.FULL), 3),
    (partial(rivals.forest, rivals.SMALL), 9),
    (partial(rivals.fusion, rivals.SMALL), 15),
    (partial(rivals.fusion, rivals.FULL), 5),
    (rivals.ingot, 15),
)


def rows() -> Iterator[Row]:
    """All rows of the table, as they are measured."""
    with tempfile.TemporaryDirectory() as folder:
        for work, rounds in TABLE:
            one_core = work is rivals.ingot
            cv2.setNumThreads(1 if one_core else -1)
            yield from work(Path(folder), rounds)


def line(row: Row, kept: dict[str, float]) -> str:
    """A row of the printed table."""
    clock, processor = row.ratios
    slipped = " SLIPPED" if row.has_slipped(kept) else ""
    before = f"{kept[row.work]:8.1f}" if row.work in kept else "       -"
    return (
        f"{row.work:<40} {row.ours.clock_ms:8.1f} {row.ours.processor_ms:8.1f}  {row.rival:<32} "
        f"{row.theirs.clock_ms:8.1f} {row.theirs.processor_ms:8.1f}  {clock:6.1f} {processor:6.1f} {before}{slipped}"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help="write this run's ratios as those of the release")
    keep = parser.parse_args().keep
    releases = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    kept = list(releases.values())[-1] if releases and not keep else {}
    print("ms on the clock and of the processor; then how many times longer the rival takes; last, the ratio kept")
    measured = []
    for row in rows():
        measured.append(row)
        print(line(row, kept), flush=True)
    if keep:
        releases[version("hotgauge")] = {row.work: round(row.ratios[1], 1) for row in measured}
        KEPT.write_text(json.dumps(releases, indent=1) + "\n", encoding="utf-8")
    return int(any(row.has_slipped(kept) for row in measured))


if __name__ == "__main__":
    sys.exit(main())
