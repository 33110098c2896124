"""The loop of the sizing station in a thread, heard as the supervisor hears it."""

import socket
import threading

from pydantic import TypeAdapter

from appliance.processes.link import StationLink
from appliance.processes.message import StateMessage, StationMessage
from appliance.sizing import station as sizing
from appliance.sizing.message import MESSAGES
from appliance.sizing.settings import Sizing


class Station:
    """The loop of the measuring process in a thread, and the supervisor's end of its link."""

    def __init__(self, settings: dict) -> None:
        ours, self._theirs = socket.socketpair()
        ours.settimeout(60)  # the first of all compiles
        self._lines = ours.makefile("rb")
        ours.close()
        self.closed = threading.Event()
        sizing_settings = TypeAdapter(Sizing).validate_python(settings)
        arguments = sizing_settings, StationLink(self._theirs), self.closed
        self.thread = threading.Thread(target=sizing.run, args=arguments)
        self.thread.start()

    def hear(self) -> StationMessage:
        """The next message that says more than that code is being compiled."""
        while (message := self.hear_any()) == StateMessage(state="warming"):
            pass
        return message

    def hear_any(self) -> StationMessage:
        return MESSAGES.validate_json(self._lines.readline())

    def hear_until(self, kind: type[StationMessage]) -> StationMessage:
        for _ in range(50):
            if isinstance(message := self.hear(), kind):
                return message
        raise AssertionError(f"no {kind.__name__}; last: {message}")

    def end(self) -> None:
        self.closed.set()
        self.thread.join(5)
        assert not self.thread.is_alive()
        self._lines.close()
        self._theirs.close()
