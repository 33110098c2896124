"""Hands recordings to processes of this computer, or to a Dask cluster; what a lost worker had is handed out again."""

import importlib
import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from appliance.archives.parts import Rows
from appliance.archives.recordings import ArchiveError

LOST_MOST = 3  # times that a recording may lose its worker before it counts as the cause

CONNECT_TIME_S = "10s"

Measure = Callable[[Path], Rows]
"""Measures one recording; must be importable by another process. Never raises for a recording that cannot be read."""


def by_processes(measure: Measure, recordings: Sequence[Path], processes: int) -> Iterator[tuple[Path, Rows]]:
    """Measure in processes of this computer; yields each recording with its rows as it is done.

    Parameters
    ----------
    measure : callable
    recordings : sequence of Path
    processes : int

    Yields
    ------
    tuple of Path and list of dict
    """
    os.environ.setdefault("TQDM_DISABLE", "1")  # for the processes: no progress bars of single recordings
    lost = dict.fromkeys(recordings, 0)
    waiting = list(recordings)
    while waiting:
        # what was in work when a worker was lost goes on its own: then the recording that loses it is known
        suspects = [one for one in waiting if lost[one]]
        done: set[Path] = set()
        for recording, rows in _by_pool(measure, suspects or waiting, 1 if suspects else processes):
            done.add(recording)
            yield recording, rows
        waiting = [one for one in waiting if one not in done]
        for one in [one for one in suspects or waiting if one not in done][: 1 if suspects else processes]:
            lost[one] += 1
            if lost[one] > LOST_MOST:
                waiting.remove(one)
                yield one, [failed("the process that measured it ended each time; its pictures may be damaged")]


def _by_pool(measure: Measure, recordings: Sequence[Path], workers: int) -> Iterator[tuple[Path, Rows]]:
    """What a pool of processes measures until it is done or has lost one."""
    pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    try:
        futures: dict[Future[Rows], Path] = {pool.submit(measure, one): one for one in recordings}
        for future in as_completed(tuple(futures)):
            recording = futures.pop(future)  # and its rows with it, once they are handed on
            try:
                rows = future.result()
            except BrokenProcessPool:
                continue
            yield recording, rows
    finally:
        pool.shutdown(cancel_futures=True)


def by_dask(measure: Measure, recordings: Sequence[Path], address: str) -> Iterator[tuple[Path, Rows]]:
    """Measure on a Dask cluster, whose workers see recordings and rig under the same paths.

    Parameters
    ----------
    measure : callable
    recordings : sequence of Path
    address : str
        Of its scheduler, as `tcp://10.0.0.7:8786`.

    Yields
    ------
    tuple of Path and list of dict

    Raises
    ------
    ArchiveError
        The library is not installed, or no scheduler answers.
    """
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError as error:
        raise ArchiveError("--dask: its library is missing; pip install 'hotgauge[cluster]'") from error
    try:
        client: Any = distributed.Client(address, timeout=CONNECT_TIME_S)
    except (OSError, ValueError) as error:
        raise ArchiveError(f"--dask {address}: no scheduler answers there; start one with dask scheduler") from error
    with client:
        futures = {client.submit(measure, one, pure=False, retries=LOST_MOST): one for one in recordings}
        for future in distributed.as_completed(tuple(futures)):
            recording = futures.pop(future)  # with which the cluster forgets its rows
            if future.status == "finished":
                yield recording, future.result()
            else:
                yield recording, [failed(f"the cluster gave it up: {future.exception()}")]


def failed(why: str) -> dict[str, Any]:
    """Row of a recording that cannot be measured."""
    return {"frame": None, "error": why}
