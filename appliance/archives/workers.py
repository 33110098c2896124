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
        done: set[Path] = set()
        # one at a time once a worker was lost: then the recording that loses it is known
        workers = 1 if any(lost.values()) else processes
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(workers, mp_context=context) as pool:
            futures: dict[Future[Rows], Path] = {pool.submit(measure, one): one for one in waiting}
            for future in as_completed(futures):
                recording = futures[future]
                try:
                    rows = future.result()
                except BrokenProcessPool:
                    continue
                done.add(recording)
                yield recording, rows
        left = [one for one in waiting if one not in done]
        if left:
            lost[left[0]] += 1
            if lost[left[0]] > LOST_MOST:
                yield left[0], [failed("the process that measured it ended each time; its pictures may be damaged")]
                left = left[1:]
        waiting = left


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
        futures = {
            client.submit(measure, one, pure=False, retries=LOST_MOST, key=f"hotgauge-{number}-{one.name}"): one
            for number, one in enumerate(recordings)
        }
        for future in distributed.as_completed(futures):
            if future.status == "finished":
                yield futures[future], future.result()
            else:
                yield futures[future], [failed(f"the cluster gave it up: {future.exception()}")]


def failed(why: str) -> dict[str, Any]:
    """Row of a recording that cannot be measured."""
    return {"frame": None, "error": why}
