"""What a measuring process says to the supervisor: small messages, one JSON line each, no images.

The supervisor may read any number of them late and the process may die in the middle of one; neither may
stop the other. So the process never waits on the link (what cannot be sent is dropped and counted), and the
supervisor uses the newest.
"""

import socket
from typing import Annotated

from pydantic import Field, TypeAdapter

from appliance.ingot.message import IngotMessage
from appliance.processes.message import StateMessage
from appliance.sizing.message import ReadingMessage

Message = StateMessage | ReadingMessage | IngotMessage
_MESSAGE: TypeAdapter[Message] = TypeAdapter(Annotated[Message, Field(discriminator="kind")])


def parse(line: bytes) -> Message:
    """Message of one line; raises ValueError when the line is not one."""
    return _MESSAGE.validate_json(line)


class StationLink:
    """The measuring process's end of the link.

    Parameters
    ----------
    connection : socket.socket
        Connected stream socket; its receiving side stays untouched.
    """

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._unsent = b""
        self.dropped = 0
        """Messages that could not be sent because the supervisor did not read."""

    def send(self, message: Message) -> None:
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
            return  # full, or the supervisor is gone: who watches the link ends this process then
        self._unsent = self._unsent[sent:]
