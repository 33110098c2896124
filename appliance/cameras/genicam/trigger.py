"""Fires cameras that wait for this computer: each by its own command, or all by one action command on their network."""

import contextlib
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterable

# ACTION_CMD of GigE Vision 2.0: key of commands, flags, command, length, number; device key, group key, group mask, and
# of a scheduled one the moment in ns by the cameras' clock
PACKET_HEAD, KEYS, MOMENT = struct.Struct(">BBHHH"), struct.Struct(">III"), struct.Struct(">Q")
PACKET_KEY, NO_FLAGS, SCHEDULED_FLAG, ACTION_COMMAND = 0x42, 0, 0x80, 0x0100
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

    def send(self, moment_ns: int | None = None) -> None:
        """Have all cameras expose; a network that is down shows by the pictures that do not come.

        Parameters
        ----------
        moment_ns : int, optional
            By the cameras' common clock; now unless given.
        """
        self._number = self._number % LAST_NUMBER + 1
        packet = action_packet(self._number, moment_ns)
        for sender in self._sockets:
            with contextlib.suppress(OSError):
                sender.sendto(packet, (ALL_ON_THE_NETWORK, CONTROL_PORT))

    def close(self) -> None:
        """Let go of the sockets."""
        for sender in self._sockets:
            sender.close()


def action_packet(number: int, moment_ns: int | None = None) -> bytes:
    """Bytes of an action command that wants no answer.

    Parameters
    ----------
    number : int
        Of the command, 1 to 65535.
    moment_ns : int, optional
        When the cameras shall expose, by their clock; when the command arrives unless given.
    """
    body = KEYS.pack(DEVICE_KEY, GROUP_KEY, GROUP_MASK) + (b"" if moment_ns is None else MOMENT.pack(moment_ns))
    flags = NO_FLAGS if moment_ns is None else SCHEDULED_FLAG
    return PACKET_HEAD.pack(PACKET_KEY, flags, ACTION_COMMAND, len(body), number) + body
