"""A Dask cluster of two worker processes measures an archive to the same bits, also when one of them is killed."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import pyarrow.parquet as pq
import pytest
from running import free_port

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.sizing.reading_rows import COLUMNS
from appliance.sizing.stereo.rig_file import save_rig

pytestmark = pytest.mark.waiting

SIDES = ("left", "right")
RECORDINGS = 6


@pytest.fixture(scope="module")
def archive(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("archive")
    save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), folder / "rig.json")
    with MillSource(seed=1, rate_hz=0) as source:
        for number in range(RECORDINGS):
            pair = source.next(10)
            for side, picture in zip(SIDES, (pair.left, pair.right), strict=True):
                place = folder / "archive" / f"recording_{number}" / side
                place.mkdir(parents=True)
                cv2.imwrite(str(place / "000000.png"), picture)
    return folder


class Cluster:
    def __init__(self, address: str, workers: list[subprocess.Popen]) -> None:
        self.address = address
        self.workers = workers


@contextlib.contextmanager
def cluster(folder: Path) -> Iterator[Cluster]:
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
    words = [sys.executable, "-m", "appliance", "measure", str(archive / "archive"), "--rig", str(archive / "rig.json")]
    subprocess.run([*words, "--output", str(output), *more], check=True, capture_output=True, timeout=300)
    return pq.read_table(output).to_pylist()


def assert_same_bits(one: list[dict], other: list[dict]) -> None:
    assert len(one) == RECORDINGS
    for mine, theirs in zip(one, other, strict=True):
        assert all(mine[name] == theirs[name] for name in ("recording", "error", *COLUMNS) if name != "elapsed_ms")


def test_two_workers_give_the_bits_of_one_process_also_when_one_is_killed(archive, tmp_path):
    alone = measured(archive, tmp_path / "alone.parquet", "--processes", "1")
    with cluster(tmp_path) as both:
        together = measured(archive, tmp_path / "together.parquet", "--dask", both.address)
        assert_same_bits(together, alone)

        def kill() -> None:
            parts = tmp_path / "killed.parquet.parts"
            until_s = time.monotonic() + 120
            while not (parts.is_dir() and list(parts.glob("*.json"))) and time.monotonic() < until_s:
                time.sleep(0.01)
            os.kill(both.workers[0].pid, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        survived = measured(archive, tmp_path / "killed.parquet", "--dask", both.address)
        killer.join()
        assert both.workers[0].wait(5) == -signal.SIGKILL
    assert_same_bits(survived, alone)


def test_an_address_without_a_scheduler_is_refused_in_a_sentence(archive, tmp_path, monkeypatch):
    address = f"tcp://127.0.0.1:{free_port()}"
    words = [sys.executable, "-m", "appliance", "measure", str(archive / "archive"), "--rig", str(archive / "rig.json")]
    said = subprocess.run(
        [*words, "--output", str(tmp_path / "all.parquet"), "--dask", address],
        check=False, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert said.returncode == 2
    assert address in said.stderr
    assert "Traceback" not in said.stderr
