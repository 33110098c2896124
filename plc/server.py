"""Modbus TCP server: framing and patience of connections, and the process image that is served.

Rules after the Modbus Messaging on TCP/IP guide V1.0b and, on the secure port, the MODBUS/TCP Security Protocol
Specification; the answers themselves are made in `plc.answers`.
"""

import asyncio
import contextlib
import errno
import functools
import os
import socket
import ssl
import struct
import time
from collections.abc import Mapping, Sequence
from typing import cast, get_args

from plc.answers import OnWrite, Tables
from plc.listener import Listener, bind_error, free_dead_peer, listen
from plc.process_image import ProcessImage
from plc.security.addresses import Network
from plc.security.identity import CertificateError, holder
from plc.security.places import left_behind, never_asked
from plc.security.refusals import Refusals
from plc.security.roles import Client, Role, WritePolicy, Writes
from plc.security.secure_port import SecurePort, handshake_in_words

HALF_REQUEST_S = 5.0  # a request that has begun must be whole by then
STALLED_S = 5.0  # a client must take its answers within this time
WRITE_BUFFER_BYTES = 16384  # answers kept for a slow reader before its requests wait
REQUESTS_PER_TURN = 64  # then the other connections have their turn
HANDSHAKE_S = 5.0  # within which a client must have shown its certificate
GOODBYE_S = 2.0  # within which it must have said that it is going

_HEADER = struct.Struct(">HHH")  # transaction, protocol, length of unit and request
_UNITS = frozenset({0, 1, 255})
_GATEWAY_TARGET_SILENT = 11


class _Connection(asyncio.Protocol):
    """Framing and patience of one client's connection."""

    def __init__(self, server: "ModbusServer", client: Client, secure: SecurePort | None = None) -> None:
        self._server = server
        self.client = client
        """Who asks; on the secure port a viewer until its certificate has been read."""
        self.secure = secure
        self._transport: asyncio.Transport | None = None
        self._socket: socket.socket | None = None
        self.opening: asyncio.Task[None] | None = None
        self._received = bytearray()
        self.asked_s: float | None = None
        """Monotonic time of its last whole request; who has sent none makes room for others when there are too many."""
        self._malformed = False
        self._write_full = False
        self._limit: asyncio.TimerHandle | None = None

    def open(self, connection: socket.socket) -> None:
        """Begin with a connection that has just been accepted."""
        self._socket = connection
        self.opening = asyncio.get_running_loop().create_task(self._open(connection))

    async def _open(self, connection: socket.socket) -> None:
        free_dead_peer(connection)
        limits = {"ssl_handshake_timeout": HANDSHAKE_S, "ssl_shutdown_timeout": GOODBYE_S} if self.secure else {}
        context = self.secure.context if self.secure else None
        try:
            loop = asyncio.get_running_loop()
            await loop.connect_accepted_socket(lambda: self, connection, ssl=context, **limits)
        except OSError as error:  # of the handshake: errors of TLS and time-outs are among them
            self._server.refuse(self.client.address, handshake_in_words(error))
        finally:
            if self._transport is None:
                connection.close()
                self._server.dismiss(self)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.Transport", transport)
        self._transport.set_write_buffer_limits(high=WRITE_BUFFER_BYTES)
        tls = cast("ssl.SSLObject | None", transport.get_extra_info("ssl_object"))
        if tls is None:
            return
        try:
            self.client = self._server.recognise(self.client.address, tls.getpeercert(binary_form=True) or b"")
        except CertificateError as error:
            self._server.refuse(self.client.address, str(error))
            self._transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  asyncio calls it so
        self._set_limit(None)
        self._server.dismiss(self)

    def data_received(self, data: bytes) -> None:
        self._received += data
        self._serve()

    def pause_writing(self) -> None:
        self._write_full = True
        if self._transport is not None:
            self._transport.pause_reading()
        self._set_limit(STALLED_S)

    def resume_writing(self) -> None:
        self._write_full = False
        self._set_limit(None)
        self._serve()

    def abort(self) -> None:
        """Close at once."""
        if self._transport is not None:
            self._transport.abort()
        elif self._socket is not None:  # still in its handshake, which fails now
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)

    def _serve(self) -> None:
        """Answer what has been received, some at a time, so that nobody waits for one busy client."""
        transport = self._transport
        if transport is None or transport.is_closing():
            return
        answers: list[bytes] = []
        while len(answers) < REQUESTS_PER_TURN and (frame := self._next_frame()):
            answers.append(self._server.answer(frame, self.client))
        if answers:
            self.asked_s = time.monotonic()
            self._set_limit(None)
            transport.write(b"".join(answers))
        if self._malformed:
            transport.close()
        elif not self._write_full:
            self._go_on(transport, len(answers))

    def _go_on(self, transport: asyncio.Transport, answered: int) -> None:
        if answered == REQUESTS_PER_TURN:
            transport.pause_reading()
            asyncio.get_running_loop().call_soon(self._serve)
            return
        transport.resume_reading()
        if self._received and self._limit is None:
            self._set_limit(HALF_REQUEST_S)

    def _next_frame(self) -> bytes | None:
        """Next whole request with its header; None when there is none."""
        if len(self._received) < _HEADER.size:
            return None
        _, protocol, length = _HEADER.unpack_from(self._received)
        if protocol != 0 or not 2 <= length <= 254:
            self._malformed = True
            return None
        end = _HEADER.size + length
        if len(self._received) < end:
            return None
        frame = bytes(self._received[:end])
        del self._received[:end]
        return frame

    def _set_limit(self, seconds: float | None) -> None:
        if self._limit is not None:
            self._limit.cancel()
            self._limit = None
        if seconds is not None:
            self._limit = asyncio.get_running_loop().call_later(seconds, self.abort)


class ModbusServer:
    """Modbus TCP server of one register map.

    Parameters
    ----------
    host : str
        Name or address to bind to; `::` means every address, IPv4 and IPv6.
    port : int or None
        TCP port of plain Modbus; 0 takes a free one, None serves none.
    writes : {"none", "tls", "all"}
        Who may write: nobody, clients with a certificate as their role permits, everybody.
    writers : sequence of Network
        Addresses that may write, on both ports; without any, every address. They also have the first right to a place.
    secure : SecurePort, optional
        Modbus/TCP Security on a port of its own.
    connections_max : int
        Clients served at once. One more takes the place of the oldest that has not sent a whole request yet, of
        the address that has most of these, so that half-open connections lock nobody out; a writer that of the oldest
        which is none; then that of one that its client has left behind (`plc.security.places`), so that a client which
        never closes locks nobody out either; otherwise it is closed at once.
    on_write : callable, optional
        Called in the event loop with what a write changes, by name: set points as the numbers in their words,
        commands as levels. An equal write does not call it. If it raises, nothing is written and the client
        gets exception 4.

    Attributes
    ----------
    requests : int
        Requests answered since the start.
    exceptions : int
        Those of them that were refused.
    refused : int
        Clients turned away since the start.

    Raises
    ------
    ValueError
        A parameter is out of bounds.
    """

    def __init__(
        self,
        host: str,
        port: int | None,
        *,
        writes: Writes = "none",
        writers: Sequence[Network] = (),
        secure: SecurePort | None = None,
        connections_max: int = 64,
        on_write: OnWrite | None = None,
    ) -> None:
        if port is not None and not 0 <= port <= 65535:
            raise ValueError(f"port: {port} is not within 0 to 65535")
        if port is None and secure is None:
            raise ValueError("port: None serves nobody without a secure port")
        if writes not in get_args(Writes):
            raise ValueError(f'writes: {writes!r} is not "none", "tls" or "all"')
        if connections_max < 1:
            raise ValueError(f"connections_max: {connections_max} is below 1")
        self.requests = 0
        self.exceptions = 0
        self.refused = 0
        self._host = host
        self._port = port
        self._secure = secure
        self._connections_max = connections_max
        self._policy = WritePolicy(writes, frozenset(writers))
        self._refusals = Refusals()
        self._tables = Tables(on_write=on_write, refusals=self._refusals)
        self._connections: dict[_Connection, None] = {}  # in the order in which they came
        self._listeners: list[Listener] = []
        self._renewal: asyncio.Task[None] | None = None

    @property
    def port(self) -> int:
        """TCP port of plain Modbus, the real one once the server has started; 0 if it is not served."""
        return self._port or 0

    @property
    def secure(self) -> SecurePort | None:
        """The secure port, if there is one."""
        return self._secure

    @property
    def connections(self) -> int:
        """Number of clients connected."""
        return len(self._connections)

    async def start(self) -> None:
        """Listen; until the first `publish`, everything reads as no value.

        Raises
        ------
        BindError
            An address cannot be bound, for instance because the port is taken; the message names the setting.
        """
        if self._secure is not None:
            await self._secure.load()
        try:
            if self._port is not None:
                self._port = await self._listen(self._port, None)
            if self._secure is not None:
                self._secure.port = await self._listen(self._secure.port, self._secure)
                self._renewal = asyncio.create_task(self._secure.keep(self._drop_secure))
        except OSError:
            await self.stop()
            raise

    async def _listen(self, port: int, secure: SecurePort | None) -> int:
        try:
            sockets = await asyncio.to_thread(listen, self._host, port)
        except OSError as error:
            raise bind_error(error, self._host, port, "plc.tls.port" if secure else "plc.port") from error
        listener = Listener(sockets, functools.partial(self._welcome, secure), self._turn_away)
        self._listeners.append(listener)
        return listener.port

    async def stop(self) -> None:
        """Close the ports and all connections."""
        if self._renewal is not None:
            self._renewal.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._renewal
            self._renewal = None
        for listener in self._listeners:
            listener.close()
        self._listeners.clear()
        opening = [connection.opening for connection in self._connections if connection.opening is not None]
        for connection in tuple(self._connections):
            connection.abort()
        await asyncio.gather(*opening)
        await asyncio.sleep(0)  # in which their transports end

    def publish(self, image: ProcessImage) -> None:
        """Serve this image from the next request on; may be called from any thread."""
        self._tables.image = image

    def restore(self, written: Mapping[str, int | bool]) -> None:
        """Serve what the PLC had written before a restart as if it had just been written.

        Parameters
        ----------
        written : mapping of str to int or bool
            As `on_write` got it, by name; what is missing is 0. Call it after the first `publish`, whose word
            order counts, and before `start`.
        """
        self._tables.restore(written)

    def connect(self) -> socket.socket:
        """A connection of our own, which needs no port and takes nobody's place; it may only read.

        Returns
        -------
        socket
            The client's end.

        Raises
        ------
        OSError
            There are no descriptors.
        """
        ours, theirs = socket.socketpair()
        ours.setblocking(False)
        _Connection(self, Client("the gauge itself", Role.VIEWER, limit="it may only read")).open(ours)
        return theirs

    def answer(self, frame: bytes, client: Client) -> bytes:
        """Answer to one whole request of a client, both with header and unit."""
        self.requests += 1
        unit, request = frame[6], frame[7:]
        silent = bytes((request[0] | 0x80, _GATEWAY_TARGET_SILENT))
        answer = self._tables.answer(request, client) if unit in _UNITS else silent
        if answer[0] & 0x80:
            self.exceptions += 1
        return frame[:4] + struct.pack(">HB", len(answer) + 1, unit) + answer

    def recognise(self, address: str, certificate: bytes) -> Client:
        """Client by the certificate that it has shown; raises `CertificateError`."""
        return self._policy.with_certificate(address, *holder(certificate))

    def refuse(self, address: str, why: str) -> None:
        """Count a client that has been turned away, and log it once."""
        self.refused += 1
        self._refusals.tell(address, why)

    def _welcome(self, secure: SecurePort | None, connection: socket.socket, address: str) -> None:
        if len(self._connections) >= self._connections_max and not self._make_room(address):
            connection.close()
            self.refuse(address, f"all {self._connections_max} places are taken (plc.connections_max)")
            return
        if secure is not None and secure.context is None:
            connection.close()
            self.refuse(address, "the gauge's own certificate cannot be used")
            return
        client = Client(address, Role.VIEWER) if secure else self._policy.on_plain_port(address)
        new = _Connection(self, client, secure)
        self._connections[new] = None
        new.open(connection)

    def _turn_away(self, address: str) -> None:
        why = os.strerror(errno.EMFILE).lower()
        self.refuse(address, f"{why}; raise the limit of descriptors (LimitNOFILE) or lower plc.connections_max")

    def _make_room(self, address: str) -> bool:
        leaving = never_asked(self._connections)
        if leaving is None and self._policy.lists(address):
            others = (c for c in self._connections if not self._policy.lists(c.client.address))
            leaving = next(others, None)
        if leaving is None:
            leaving = left_behind(self._connections, time.monotonic())
        if leaving is not None:
            leaving.abort()
            self.dismiss(leaving)
        return leaving is not None

    def _drop_secure(self) -> None:
        """End connections whose certificates were signed by an authority that is not trusted any more."""
        for connection in tuple(self._connections):
            if connection.secure:
                connection.abort()

    def dismiss(self, connection: _Connection) -> None:
        """Count a connection out."""
        self._connections.pop(connection, None)
