"""Listening sockets of the server, and accepting that outlives floods of connections and a lack of descriptors."""

import asyncio
import contextlib
import errno
import os
import resource
import socket
from collections.abc import Callable

from plc.security.addresses import EVERY

BACKLOG = 1024  # connections that wait to be accepted: a burst of 200 within 5 ms must not cost the next one a second
ACCEPTS_PER_TURN = 64  # then those who are connected have their turn
RESERVED_DESCRIPTORS = 24  # for two measuring processes that start, and files that are written
PAUSE_S = 0.1
_NOT_OF_THIS_COMPUTER = {errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT}

OnConnection = Callable[[socket.socket, str], None]


def listen(host: str, port: int) -> list[socket.socket]:
    """Bind to every address that a host setting means; may wait for a name server.

    Parameters
    ----------
    host : str
        Address or name; `::` means every address, IPv4 and IPv6.
    port : int
        0 takes a free one, the same for every address.

    Returns
    -------
    list of socket

    Raises
    ------
    OSError
        An address cannot be bound, or none of them is of this computer; `socket.gaierror` if the name is unknown.
    """
    sockets: list[socket.socket] = []
    missing: OSError | None = None
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    for family, _, _, _, address in dict.fromkeys(found):
        try:
            sockets.append(_bind(family, (address[0], port, *address[2:]), dual=host == EVERY))
        except OSError as error:
            if error.errno not in _NOT_OF_THIS_COMPUTER:
                _close(sockets)
                raise
            missing = error
        else:
            port = sockets[0].getsockname()[1]
    if missing is not None and not sockets:
        raise missing
    return sockets


def _bind(family: int, address: tuple[object, ...], *, dual: bool) -> socket.socket:
    bound = socket.socket(family, socket.SOCK_STREAM)
    try:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if family == socket.AF_INET6:
            bound.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, not dual)
        bound.bind(address)
        bound.listen(BACKLOG)
        bound.setblocking(False)
    except OSError:
        bound.close()
        raise
    return bound


def _close(sockets: list[socket.socket]) -> None:
    for bound in sockets:
        bound.close()


class BindError(OSError):
    """A port cannot be had.

    Attributes
    ----------
    sentence : str
        Which setting, why and what to do, for the person who set it.
    """

    sentence = ""


def bind_error(error: OSError, host: str, port: int, setting: str) -> BindError:
    """Say what is wrong with the host or the port.

    Parameters
    ----------
    error : OSError
        What `listen` has raised.
    host : str
    port : int
    setting : str
        Setting that says the port.
    """
    why, remedy = os.strerror(error.errno or 0), f"set {setting}"
    if isinstance(error, socket.gaierror):
        why, remedy = "no host of this name is known", "set plc.host to an address of this computer"
    elif error.errno in _NOT_OF_THIS_COMPUTER:
        why, remedy = "this computer does not have this address", "set plc.host to one that it has, or to ::"
    elif error.errno == errno.EADDRINUSE:
        remedy = f"stop what uses it or set {setting}"
    elif error.errno == errno.EACCES:
        remedy = f"ports below 1024 need a right that the installed service has; set {setting}"
    place = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    found = BindError(error.errno, f"error while attempting to bind on {place}: {why.lower()}")
    found.sentence = f"cannot serve on {place}: {why}; {remedy}"
    return found


class Listener:
    """Accepts connections on sockets that listen.

    When descriptors run out, asyncio's own accepting writes an error for each of a thousand tries, and takes those
    that a measuring process needs to start. Here some are kept back, and who finds none left is closed at once.

    Parameters
    ----------
    sockets : list of socket
    on_connection : callable
        Gets each connection and the address of its client.
    on_starved : callable
        Gets the address of each client that is closed because descriptors are short.
    """

    def __init__(
        self, sockets: list[socket.socket], on_connection: OnConnection, on_starved: Callable[[str], None]
    ) -> None:
        self._sockets = sockets
        self._on_connection = on_connection
        self._on_starved = on_starved
        self._loop = asyncio.get_running_loop()
        self._spare: int | None = None
        self._keep_spare()
        for bound in sockets:
            self._loop.add_reader(bound, self._accept, bound)

    @property
    def port(self) -> int:
        """TCP port."""
        return self._sockets[0].getsockname()[1]

    def close(self) -> None:
        """Stop listening; connections stay."""
        for bound in self._sockets:
            self._loop.remove_reader(bound)
        _close(self._sockets)
        if self._spare is not None:
            os.close(self._spare)
            self._spare = None

    def _accept(self, bound: socket.socket) -> None:
        self._keep_spare()
        for _ in range(ACCEPTS_PER_TURN):
            try:
                connection, address = bound.accept()
            except (BlockingIOError, InterruptedError):
                return
            except ConnectionError:  # the client has gone while it waited
                continue
            except OSError:
                self._turn_away(bound)
                return
            self._receive(connection, str(address[0]))

    def _receive(self, connection: socket.socket, address: str) -> None:
        if descriptors_left() < RESERVED_DESCRIPTORS:
            connection.close()
            self._on_starved(address)
            return
        connection.setblocking(False)
        self._on_connection(connection, address)

    def _keep_spare(self) -> None:
        """Keep one descriptor, so that a client can be accepted, and closed, when there is no other."""
        if self._spare is None:
            with contextlib.suppress(OSError):
                self._spare = os.open(os.devnull, os.O_RDONLY)

    def _turn_away(self, bound: socket.socket) -> None:
        if self._spare is not None:
            os.close(self._spare)
            self._spare = None
        try:
            connection, address = bound.accept()
        except (BlockingIOError, ConnectionError):
            return
        except OSError:  # not even one: those who wait go on waiting
            self._loop.remove_reader(bound)
            self._loop.call_later(PAUSE_S, self._go_on, bound)
            return
        connection.close()
        self._keep_spare()
        self._on_starved(str(address[0]))

    def _go_on(self, bound: socket.socket) -> None:
        if bound.fileno() >= 0:
            self._loop.add_reader(bound, self._accept, bound)


def descriptors_left() -> int:
    """Descriptors that this process may still open."""
    most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        return most - len(os.listdir("/proc/self/fd"))  # noqa: PTH208  names only, for every connection
    except OSError:
        return 0


def free_dead_peer(connection: socket.socket) -> None:
    """Let the kernel give up a peer that has vanished, within 25 s; one that is only silent stays."""
    if connection.family == socket.AF_UNIX:
        return
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, 10)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, 5)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPCNT, 3)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, 20_000)
