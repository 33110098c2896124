"""Fires cameras that wait for this computer: each by its own command, or all by one action command on their network."""

import contextlib
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterable

# ACTION_CMD of GigE Vision 2.0: key of commands, flags, command, length, number; device key, group key, group mask
ACTION_PACKET = struct.Struct(">BBHHHIII")
PACKET_KEY, NO_FLAGS, ACTION_COMMAND, ACTION_LENGTH = 0x42, 0, 0x0100, 12
CONTROL_PORT = 3956
ALL_ON_THE_NETWORK = "255.255.255.255"
DEVICE_KEY, GROUP_KEY, GROUP_MASK = 0x486F7467, 1, 1  # chosen: what the cameras are told to listen for
LAST_NUMBER = 65535

SOFTWARE, ACTION = "Software", "Action1"  # names of trigger sources (GenICam SFNC 2.7, TriggerSource)


class Firing:
    """Calls `fire` at a rate from a thread, until it is closed.

    Parameters
    ----------
    fire : callable
    rate_hz : float
    """

    def __init__(self, fire: Callable[[], None], rate_hz: float) -> None:
        self._fire = fire
        self._period_s = 1 / rate_hz
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._closed.set()
        self._thread.join()

    def _run(self) -> None:
        due_s = time.monotonic()
        while not self._closed.wait(max(0.0, due_s - time.monotonic())):
            self._fire()
            # a period that was missed is left out: cameras cannot be fired later than they are
            due_s = max(due_s + self._period_s, time.monotonic())


class ActionCommand:
    """Action commands to all cameras on the networks of some network cards.

    Parameters
    ----------
    cards : iterable of str
        Addresses of this computer, on the cards that the cameras are connected to.
    """

    def __init__(self, cards: Iterable[str]) -> None:
        self._sockets: list[socket.socket] = []
        self._number = 0
        for card in sorted(set(cards)):
            sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
            sender.bind((card, 0))  # a broadcast leaves through the card that has the sender's address (ip(7))
            self._sockets.append(sender)

    def send(self) -> None:
        """Have all cameras expose now; a network that is down is told by the pictures that do not come."""
        self._number = self._number % LAST_NUMBER + 1
        for sender in self._sockets:
            with contextlib.suppress(OSError):
                sender.sendto(action_packet(self._number), (ALL_ON_THE_NETWORK, CONTROL_PORT))

    def close(self) -> None:
        """Let go of the sockets."""
        for sender in self._sockets:
            sender.close()


def action_packet(number: int) -> bytes:
    """Bytes of an action command that wants no answer.

    Parameters
    ----------
    number : int
        Of the command, 1 to 65535.
    """
    return ACTION_PACKET.pack(
        PACKET_KEY, NO_FLAGS, ACTION_COMMAND, ACTION_LENGTH, number, DEVICE_KEY, GROUP_KEY, GROUP_MASK
    )
