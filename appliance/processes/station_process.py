"""Main loop that all station processes share: settings are the first line of the link, and its close ends the process.

The supervisor runs `python -m appliance.NAME.station DESCRIPTOR`; the descriptor is a connected socket.
"""

import contextlib
import logging
import os
import socket
import sys
import threading
import time
from collections.abc import Callable
from typing import Protocol, TypeVar

from pydantic import TypeAdapter

from appliance.cameras.liveness import Verdict
from appliance.cameras.source import CameraError
from appliance.processes.link import StationLink
from appliance.processes.message import StateMessage
from appliance.processes.resource_limits import EXIT_OUT_OF_MEMORY, limit_process

LEAVE_TIME_S = 2.0  # chosen: a loop that has not returned so long after the link's close hangs; the process exits
REOPEN_AFTER_S = 5.0  # chosen: cameras whose frames were rejected for longer are closed and opened again

logger = logging.getLogger("hotgauge.station")


class StationSettings(Protocol):
    """Settings that every station has."""

    @property
    def memory_max_mb(self) -> int:
        """Memory of the process, MB; above it the process ends and is started again."""
        ...


SettingsT = TypeVar("SettingsT", bound=StationSettings)


def serve(
    settings_type: TypeAdapter[SettingsT], run: Callable[[SettingsT, StationLink, threading.Event], None]
) -> None:
    """Run a station until the supervisor closes the link or dies.

    Parameters
    ----------
    settings_type : TypeAdapter
        Reads the settings from the first line of the link.
    run : callable
        Receives the settings, the link, and an event that is set when the link is closed.
    """
    connection = socket.socket(fileno=int(sys.argv[1]))
    with connection:
        with connection.makefile("rb", buffering=0) as lines:  # without a buffer: what follows belongs to the listener
            settings = settings_type.validate_json(lines.readline())
        limit_process(settings.memory_max_mb)
        closed = threading.Event()
        link = StationLink(connection)
        threading.Thread(target=_listen, args=(connection, link, closed), daemon=True).start()
        try:
            run(settings, link, closed)
        except MemoryError:
            os._exit(EXIT_OUT_OF_MEMORY)  # an orderly exit would need memory


def _listen(connection: socket.socket, link: StationLink, closed: threading.Event) -> None:
    """Hand lines to whom they are for until the link is closed; one that cannot be read ends the process."""
    try:
        _hand_on(connection, link)
    except Exception:  # without a listener a station would measure for a supervisor that is long gone
        logger.exception("the link to the supervisor")
    closed.set()
    time.sleep(LEAVE_TIME_S)
    os._exit(1)  # the loop has not returned: it hangs in a camera driver or in native code


def _hand_on(connection: socket.socket, link: StationLink) -> None:
    unread = b""
    with contextlib.suppress(ConnectionError, ValueError):  # reset: the supervisor died with unread messages
        while received := connection.recv(1 << 12):
            *lines, unread = (unread + received).split(b"\n")
            for line in lines:
                link.on_line(line)


def fault(name: str, detail: str) -> StateMessage:
    """Make the message of a fault.

    Parameters
    ----------
    name : str
        Name in the fault table.
    detail : str
        One sentence: what, where and what to do.
    """
    return StateMessage(state="faulty", fault=name, detail=detail)


def report_rejected(verdict: Verdict, link: StationLink, *, opens_again: bool) -> None:
    """Report why frames are rejected; after REOPEN_AFTER_S raise CameraError so that the caller reopens the cameras.

    Parameters
    ----------
    verdict : Verdict
        Of a frame that does not count.
    link : StationLink
    opens_again : bool
        Whether reopening can help. False for recordings, which would start from their first frame each time.

    Raises
    ------
    CameraError
        Frames have been rejected for more than REOPEN_AFTER_S.
    """
    for name, detail in verdict.faults.items():
        if opens_again and verdict.lost_s > REOPEN_AFTER_S:
            raise CameraError(detail, name)
        link.send(fault(name, detail))
