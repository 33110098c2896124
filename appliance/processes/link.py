"""The measuring process's end of the link to the supervisor: one JSON line for each message, no images.

Sending never waits. A message that does not fit into the socket's buffer is dropped and counted, so a supervisor that
reads late never delays a measurement; the supervisor uses the newest message.
"""

import socket
import threading
from collections.abc import Callable

from appliance.processes.message import StationMessage


class StationLink:
    """The measuring process's end of the link.

    Parameters
    ----------
    connection : socket.socket
        Connected stream socket; nothing is read from it here.

    Attributes
    ----------
    dropped : int
        Messages that could not be sent because the supervisor did not read.
    on_line : callable
        Called, in another thread, with each line that the supervisor sends after the settings; ignored unless set.
    """

    def __init__(self, connection: socket.socket) -> None:
        self.dropped = 0
        self.on_line: Callable[[bytes], None] = _ignore
        self._connection = connection
        self._one_at_a_time = threading.Lock()  # `warming` is sent from a thread of its own
        self._unsent = b""

    def send(self, message: StationMessage) -> None:
        """Send a message now or drop it; never waits, never raises when the other side is gone."""
        with self._one_at_a_time:
            self._flush()
            if self._unsent:
                self.dropped += 1
                return
            self._unsent = message.model_dump_json().encode() + b"\n"
            self._flush()

    def _flush(self) -> None:
        if not self._unsent:
            return
        try:
            sent = self._connection.send(self._unsent, socket.MSG_DONTWAIT | socket.MSG_NOSIGNAL)
        except OSError:
            return  # the buffer is full, or the supervisor is gone (`station_process` then ends this process)
        self._unsent = self._unsent[sent:]


def _ignore(_: bytes) -> None:
    """Do nothing that is asked for."""
