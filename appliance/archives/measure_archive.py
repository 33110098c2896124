"""Measures all recordings of an archive into one Parquet file, and goes on where an earlier run was ended."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from appliance.archives.parquet import write_archive
from appliance.archives.parts import Parts, Rows
from appliance.archives.recordings import find_recordings
from appliance.archives.workers import Measure, by_dask, by_processes
from appliance.archives.workers import failed as failed_row


class ArchiveResult(NamedTuple):
    """What came of it.

    Attributes
    ----------
    recordings : int
    frames : int
    resumed : int
        Recordings that an earlier run had measured.
    failed : dict of str to str
        Why, by the name of each recording that cannot be measured.
    """

    recordings: int
    frames: int
    resumed: int
    failed: dict[str, str]


def measure_archive(
    archive: Path,
    output: Path,
    measure: Measure,
    options: Mapping[str, str],
    *,
    columns: Sequence[str],
    processes: int | None,
    dask: str | None,
    show: Callable[[int, int], None],
) -> ArchiveResult:
    """Measure every recording once.

    Parameters
    ----------
    archive : Path
        Folder with recordings at any depth.
    output : Path
        Parquet file; while it is made, a folder of parts lies beside it.
    measure : callable
        Measures one recording.
    options : mapping of str to str
        All that decides a value beside the recording.
    columns : sequence of str
        Of its rows.
    processes : int or None
        On this computer; None: one for each processor.
    dask : str or None
        Address of a cluster's scheduler instead.
    show : callable
        Gets how many recordings are done, of how many.

    Raises
    ------
    ArchiveError
        There are no recordings, a library is missing, or the cluster does not answer.
    OSError
        A file cannot be written.
    """
    recordings = find_recordings(archive)
    parts = Parts(output, options)
    # as they are before they are measured: the rows of one that changes meanwhile are not those of what it has become
    places = {one: parts.place(one) for one in recordings}
    open_ones = [one for one in recordings if not _is_measured(parts.read(places[one]))]
    done = resumed = len(recordings) - len(open_ones)
    show(done, len(recordings))
    if dask:
        workers = by_dask(measure, open_ones, dask)
    else:
        workers = by_processes(measure, open_ones, processes or _processors())
    for recording, rows in workers:
        parts.write(places[recording], rows)
        done += 1
        show(done, len(recordings))
    names = {one: str(one.relative_to(archive)) for one in recordings}
    failed: dict[str, str] = {}
    frames = 0

    def all_rows() -> Iterator[tuple[str, Rows]]:
        nonlocal frames
        for recording, name in names.items():
            rows = parts.read(places[recording]) or [failed_row("its part is gone; measure again")]
            for row in rows:
                if row.get("error"):
                    failed[name] = str(row["error"])
            frames += len(rows)
            yield name, rows

    write_archive(output, columns, all_rows())
    if not failed:
        parts.remove()
    return ArchiveResult(len(recordings), frames - len(failed), resumed, failed)


def _is_measured(rows: Rows | None) -> bool:
    """Whether a part is there, and not one that says why there is none: what failed is tried again."""
    return rows is not None and not any(row.get("error") for row in rows)


def _processors() -> int:
    return len(os.sched_getaffinity(0))
