"""An archive of simulated recordings, and a Dask cluster on this computer that measures it."""

import contextlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import pyarrow.parquet as pq
from running import free_port

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.sizing.reading_rows import COLUMNS
from appliance.sizing.stereo.rig_file import save_rig

SIDES = ("left", "right")


def write_archive(folder: Path, recordings: int, pairs: int) -> None:
    """So many recordings of so many pairs below `archive`, and their rig beside it."""
    save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), folder / "rig.json")
    with MillSource(seed=1, rate_hz=0) as source:
        for number in range(recordings):
            places = [folder / "archive" / f"recording_{number}" / side for side in SIDES]
            for place in places:
                place.mkdir(parents=True)
            for frame in range(pairs):
                pair = source.next(10)
                for place, picture in zip(places, (pair.left, pair.right), strict=True):
                    cv2.imwrite(str(place / f"{frame:06d}.png"), picture)


class Cluster:
    def __init__(self, address: str, workers: list[subprocess.Popen]) -> None:
        self.address = address
        self.workers = workers


@contextlib.contextmanager
def cluster(folder: Path) -> Iterator[Cluster]:
    """A scheduler and two workers, each of one thread, in processes of their own."""
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    dask = str(Path(sys.executable).with_name("dask"))
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder, "start_new_session": True}
    words = [dask, "scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
    scheduler = subprocess.Popen(words, **quiet)
    worker = [dask, "worker", address, "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    worker += ["--local-directory", str(folder / "scratch")]
    workers = [subprocess.Popen(worker, **quiet) for _ in range(2)]
    try:
        yield Cluster(address, workers)
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait(10)


def measured(archive: Path, output: Path, *more: str) -> list[dict]:
    """Rows of the whole archive by `hotgauge measure`."""
    words = [sys.executable, "-m", "appliance", "measure", str(archive / "archive"), "--rig", str(archive / "rig.json")]
    subprocess.run([*words, "--output", str(output), *more], check=True, capture_output=True, timeout=900)
    return pq.read_table(output).to_pylist()


def have_same_bits(one: list[dict], other: list[dict]) -> bool:
    """Whether all but the times of computing is equal."""
    names = [name for name in ("recording", "error", *COLUMNS) if name != "elapsed_ms"]
    return len(one) == len(other) and all(
        mine[name] == theirs[name] for mine, theirs in zip(one, other, strict=True) for name in names
    )
