"""A Dask cluster of two worker processes measures an archive to the same bits, also when one of them is killed."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from archive_on_dask import cluster, have_same_bits, measured, write_archive
from running import free_port

pytestmark = pytest.mark.waiting

RECORDINGS = 6


@pytest.fixture(scope="module")
def archive(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("archive")
    write_archive(folder, RECORDINGS, pairs=1)
    return folder


def test_two_workers_give_the_bits_of_one_process_also_when_one_is_killed(archive, tmp_path):
    alone = measured(archive, tmp_path / "alone.parquet", "--processes", "1")
    with cluster(tmp_path) as both:
        together = measured(archive, tmp_path / "together.parquet", "--dask", both.address)
        assert len(alone) == RECORDINGS
        assert have_same_bits(together, alone)

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
    assert have_same_bits(survived, alone)


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
