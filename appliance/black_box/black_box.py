"""A station's black box: pictures in memory, and a thread of low priority that writes them on a cause.

Adding an exposure stores references and never waits. The thread compresses outside of Python's lock.
"""

import contextlib
import importlib.metadata
import json
import logging
import math
import os
import queue
import shutil
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from appliance.black_box.picture_memory import KeptExposure, PictureMemory
from appliance.black_box.recording_folder import PARTIAL, write_recording
from appliance.black_box.settings import BlackBoxSettings
from appliance.cameras.source import Frame, FramePair
from appliance.files.row_writer import Row

AFTER_S = 1.0  # chosen: what followed a cause belongs to the recording; part of `seconds`
LEAST_FREE_SPACE_BYTES = 200 << 20  # chosen: of the disk, which belongs to the history and to the system
WRITER_NICE = 10  # chosen: a tenth of a measuring thread's share; at 19 a busy computer took minutes for a recording
BOX_FILE = "black_box.json"

logger = logging.getLogger("hotgauge.black_box")


class _Cause(NamedTuple):
    why: str
    moment_s: float
    utc_s: float


class BlackBox:
    """The black box of one station.

    Parameters
    ----------
    settings : BlackBoxSettings
        Without a directory nothing is kept.
    station : str
        Name of the station, part of the names of recordings.

    Attributes
    ----------
    files : mapping of str to bytes
        What belongs into each recording beside pictures and readings: settings and scale, by path in its folder.
    trouble : str
        Why the last recording could not be written; empty if it could.
    """

    def __init__(self, settings: BlackBoxSettings, station: str) -> None:
        self.files: Mapping[str, bytes] = {}
        self.trouble = ""
        self._settings = settings
        self._station = station
        self._memory = PictureMemory(settings.seconds, (settings.memory_max_mb << 20) // 2)
        self._causes: queue.SimpleQueue[_Cause | None] = queue.SimpleQueue()
        self._written_s: dict[str, float] = {}
        self._thread: threading.Thread | None = None
        if settings.directory is not None:
            self._thread = threading.Thread(target=self._run, args=(settings.directory,), name="black box", daemon=True)
            self._thread.start()

    def add(self, exposed: FramePair | Frame, rows: Callable[[], list[Row]], carried: tuple[float, ...] = ()) -> None:
        """Keep an exposure that was measured; never waits.

        Parameters
        ----------
        exposed : FramePair or Frame
        rows : callable
            Makes the rows of its readings; called only when it is written.
        carried : tuple of float
            What the gauge carried over from earlier frames when it measured this one.
        """
        if self._thread is not None:
            self._memory.add(KeptExposure(exposed, rows, carried))

    def keep(self, why: str) -> None:
        """Have the last seconds written, and the second that follows; never waits.

        Parameters
        ----------
        why : str
            Name of the cause, part of the recording's name.
        """
        if self._thread is not None:
            self._causes.put(_Cause(why, time.monotonic(), time.time()))

    def close(self) -> None:
        """End the thread after what it is writing."""
        self._causes.put(None)

    def _run(self, directory: Path) -> None:
        with contextlib.suppress(OSError):  # a service that may not lower its priority keeps recordings all the same
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), WRITER_NICE)
        self._remove_partial(directory)
        while (cause := self._causes.get()) is not None:
            if not self._is_due(cause):
                continue
            time.sleep(max(0.0, cause.moment_s + AFTER_S - time.monotonic()))
            try:
                self._write(directory, [cause, *self._meanwhile()])
            except OSError as error:
                self.trouble = f"{directory}: the pictures of {cause.why} are not kept ({error.strerror})"
            except Exception as error:  # a mistake of our own is a fault, too, and the next cause may succeed
                logger.exception("%s: the pictures of %s", directory, cause.why)
                self._remove_partial(directory)
                self.trouble = f"{directory}: the pictures of {cause.why} are not kept ({error!r}); send the log"
            else:
                self.trouble = ""

    def _remove_partial(self, directory: Path) -> None:
        for left_over in directory.glob(f"{PARTIAL}*-{self._station}-*"):
            shutil.rmtree(left_over, ignore_errors=True)

    def _meanwhile(self) -> list[_Cause]:
        """Causes that came before the pictures are taken, which show them too."""
        found: list[_Cause] = []
        while not self._causes.empty():
            cause = self._causes.get()
            if cause is None:
                self._causes.put(None)
                break
            found.append(cause)
        return found

    def _is_due(self, cause: _Cause) -> bool:
        """Whether its pictures are still in memory, and none were written for the same cause shortly before."""
        forgotten = time.monotonic() - cause.moment_s > self._settings.seconds
        before_s = self._written_s.get(cause.why)
        again = before_s is not None and cause.moment_s - before_s < self._settings.again_after_s
        return not (forgotten or again)

    def _write(self, directory: Path, causes: list[_Cause]) -> None:
        exposures = self._memory.all()
        if not exposures:
            return
        self._written_s |= {cause.why: cause.moment_s for cause in causes}
        first = causes[0]
        directory.mkdir(parents=True, exist_ok=True)
        if shutil.disk_usage(directory).free < LEAST_FREE_SPACE_BYTES + sum(kept.size_bytes for kept in exposures):
            raise OSError(28, "no space left for them on the disk")
        stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime(first.utc_s))
        described = {
            "station": self._station,
            "why": list(dict.fromkeys(cause.why for cause in causes)),
            "utc_ms": round(1000 * first.utc_s),
            "version": importlib.metadata.version("hotgauge"),
            "carried": [number if math.isfinite(number) else None for number in exposures[0].carried],
        }
        files = {BOX_FILE: (json.dumps(described, indent=1) + "\n").encode(), **self.files}
        write_recording(directory / f"{stamp}-{self._station}-{first.why}", exposures, files)
        self._thin(directory)

    def _thin(self, directory: Path) -> None:
        """Delete the oldest recordings of this station while there are too many, or they are too large."""
        recordings = sorted(directory.glob(f"*Z-{self._station}-*"))
        sizes = {folder: _size_bytes(folder) for folder in recordings}
        while len(recordings) > 1 and (
            len(recordings) > self._settings.recordings_max
            or sum(sizes[folder] for folder in recordings) > self._settings.size_max_mb << 20
        ):
            shutil.rmtree(recordings.pop(0), ignore_errors=True)


def _size_bytes(folder: Path) -> int:
    total = 0
    for path in folder.rglob("*"):
        with contextlib.suppress(OSError):  # somebody moves recordings away meanwhile
            total += path.stat().st_size
    return total
