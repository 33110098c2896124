"""What all station processes have in common: a link whose first line holds the settings, and an end with the link.

The supervisor runs `python -m appliance.NAME.station DESCRIPTOR`; the descriptor is a connected socket.
"""

import contextlib
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

LEAVE_TIME_S = 2.0
REOPEN_AFTER_S = 5.0  # cameras whose pictures have not counted for so long are opened again


class StationSettings(Protocol):
    """What every station's settings hold, whatever it measures."""

    @property
    def memory_max_mb(self) -> int:
        """Memory of the process, MB, above which it ends."""
        ...


SettingsT = TypeVar("SettingsT", bound=StationSettings)


def serve(
    settings_type: TypeAdapter[SettingsT], run: Callable[[SettingsT, StationLink, threading.Event], None]
) -> None:
    """Measure until the supervisor closes the link, or is gone.

    Parameters
    ----------
    settings_type : TypeAdapter
        Of the section that the first line of the link holds.
    run : callable
        Gets the settings, the link, and an event that is set when nobody listens any more.
    """
    connection = socket.socket(fileno=int(sys.argv[1]))
    with connection, connection.makefile("rb") as lines:
        settings = settings_type.validate_json(lines.readline())
        limit_process(settings.memory_max_mb)
        closed = threading.Event()
        threading.Thread(target=_wait_for_close, args=(connection, closed), daemon=True).start()
        try:
            run(settings, StationLink(connection), closed)
        except MemoryError:
            os._exit(EXIT_OUT_OF_MEMORY)  # tidying up needs memory too


def _wait_for_close(connection: socket.socket, closed: threading.Event) -> None:
    with contextlib.suppress(ConnectionError):  # reset: the supervisor died with messages that it had not read
        while connection.recv(1):
            pass
    closed.set()
    time.sleep(LEAVE_TIME_S)
    os._exit(1)  # still here: the loop hangs in a camera or in native code, and nobody listens any more


def fault(name: str, detail: str) -> StateMessage:
    """Message of a fault of the fault table."""
    return StateMessage(state="faulty", fault=name, detail=detail)


def tell_lost(verdict: Verdict, link: StationLink, *, opens_again: bool) -> None:
    """Tell what is wrong with pictures that do not count; cameras are opened again for it after a while."""
    for name, detail in verdict.faults.items():
        if opens_again and verdict.lost_s > REOPEN_AFTER_S:  # a recording would begin anew and never end
            raise CameraError(detail, name)
        link.send(fault(name, detail))
