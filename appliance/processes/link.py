"""The measuring process's end of the link to the supervisor: small messages, one JSON line each, no images.

The supervisor may read any number of them late and the process may die in the middle of one; neither may
stop the other. So the process never waits on the link (what cannot be sent is dropped and counted), and the
supervisor uses the newest.
"""

import socket

from appliance.processes.message import StationMessage


class StationLink:
    """The measuring process's end of the link.

    Parameters
    ----------
    connection : socket.socket
        Connected stream socket; its receiving side stays untouched.

    Attributes
    ----------
    dropped : int
        Messages that could not be sent because the supervisor did not read.
    """

    def __init__(self, connection: socket.socket) -> None:
        self.dropped = 0
        self._connection = connection
        self._unsent = b""

    def send(self, message: StationMessage) -> None:
        """Send a message now or drop it; never waits, never raises when the other side is gone."""
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
            return  # full, or the supervisor is gone: the thread that watches the link then ends this process
        self._unsent = self._unsent[sent:]
