"""An archive by one process, by two, and by two workers of a Dask cluster: seconds, and whether the bits are equal."""

import os
import tempfile
import time
from pathlib import Path

from archive_on_dask import cluster, have_same_bits, measured, write_archive

TEXT = (
    "Recordings of the simulated mill, 20 pairs of 800 x 600 each, measured by `hotgauge measure` into Parquet: by one "
    "process, by two (`--processes`), by two Dask workers that have just started, and by the same workers again. "
    "Seconds are the whole command's; each process loads its compiled code first. Of two processors; load is "
    "that when the study began."
)
REPEATABLE = False  # times of a computer and a day
RECORDINGS, PAIRS = 12, 20


def cases():
    return [{"recordings": RECORDINGS, "pairs": PAIRS}]


def run(case):
    load = round(os.getloadavg()[0], 1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_archive(folder, case["recordings"], case["pairs"])
        _timed(folder, "warm", "--processes", "1")  # compiled code is on the disk from now on
        alone, alone_s = _timed(folder, "alone", "--processes", "1")
        two, two_s = _timed(folder, "two", "--processes", "2")
        with cluster(folder) as both:
            first, first_s = _timed(folder, "first", "--dask", both.address)
            again, again_s = _timed(folder, "again", "--dask", both.address)
    return {
        "rows": len(alone),
        "same_bits": all(have_same_bits(alone, other) for other in (two, first, again)),
        "one_process_s": alone_s,
        "two_processes_s": two_s,
        "two_workers_s": first_s,
        "two_workers_again_s": again_s,
        "load": load,
    }


def _timed(folder, name, *more):
    begun_s = time.perf_counter()
    rows = measured(folder, folder / f"{name}.parquet", *more)
    return rows, round(time.perf_counter() - begun_s, 1)


def summary(rows):
    return rows[0]
