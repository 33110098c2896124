"""Modbus TCP server: framing and patience of connections, and the process image that is served.

Rules after the Modbus Messaging on TCP/IP guide V1.0b; the answers themselves are made in `plc.answers`.
"""

import asyncio
import socket
import struct
from collections.abc import Mapping
from typing import Literal, cast

from plc.answers import OnWrite, Tables
from plc.process_image import ProcessImage

HALF_REQUEST_S = 5.0  # a request that has begun must be whole by then
STALLED_S = 5.0  # a client must take its answers within this time
WRITE_BUFFER_BYTES = 16384  # answers kept for a slow reader before its requests wait
REQUESTS_PER_TURN = 64  # then the other connections have their turn

Writes = Literal["none", "tls", "all"]

_HEADER = struct.Struct(">HHH")  # transaction, protocol, length of unit and request
_UNITS = frozenset({0, 1, 255})
_GATEWAY_TARGET_SILENT = 11


class _Connection(asyncio.Protocol):
    """Framing and patience of one client's connection."""

    def __init__(self, server: "ModbusServer") -> None:
        self._server = server
        self._received = bytearray()
        self.has_asked = False
        """Whether it has sent a whole request; who has not makes room for others when there are too many."""
        self._malformed = False
        self._write_full = False
        self._limit: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.Transport", transport)
        if not self._server.admit(self):
            self._transport.abort()
            return
        self._transport.set_write_buffer_limits(high=WRITE_BUFFER_BYTES)
        _free_dead_peer(transport.get_extra_info("socket"))

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  asyncio calls it so
        self._set_limit(None)
        self._server.dismiss(self)

    def data_received(self, data: bytes) -> None:
        self._received += data
        self._serve()

    def pause_writing(self) -> None:
        self._write_full = True
        self._transport.pause_reading()
        self._set_limit(STALLED_S)

    def resume_writing(self) -> None:
        self._write_full = False
        self._set_limit(None)
        self._serve()

    def abort(self) -> None:
        self._transport.abort()

    def _serve(self) -> None:
        """Answer what has been received, some at a time, so that nobody waits for one busy client."""
        if self._transport.is_closing():
            return
        answers: list[bytes] = []
        while len(answers) < REQUESTS_PER_TURN and (frame := self._next_frame()):
            answers.append(self._server.answer(frame))
        if answers:
            self.has_asked = True
            self._set_limit(None)
            self._transport.write(b"".join(answers))
        if self._malformed:
            self._transport.close()
        elif not self._write_full:
            self._go_on(len(answers))

    def _go_on(self, answered: int) -> None:
        if answered == REQUESTS_PER_TURN:
            self._transport.pause_reading()
            asyncio.get_running_loop().call_soon(self._serve)
            return
        self._transport.resume_reading()
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
            self._limit = asyncio.get_running_loop().call_later(seconds, self._transport.abort)


def _free_dead_peer(connection: socket.socket) -> None:
    """Let the kernel give up a peer that has vanished, within 25 s; one that is only silent stays."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, 10)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, 5)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPCNT, 3)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, 20_000)


class ModbusServer:
    """Modbus TCP server of one register map.

    Parameters
    ----------
    host : str
        Address to bind to.
    port : int
        TCP port; 0 takes a free one.
    writes : {"none", "tls", "all"}
        Who may write: nobody, clients with TLS (none, on this plain port), everybody.
    connections_max : int
        Clients served at once. One more takes the place of the oldest that has not sent a whole request yet, so
        that half-open connections lock nobody out; if all have, it is closed at once.
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

    Raises
    ------
    ValueError
        A parameter is out of bounds.
    """

    def __init__(
        self,
        host: str,
        port: int,
        *,
        writes: Writes = "none",
        connections_max: int = 64,
        on_write: OnWrite | None = None,
    ) -> None:
        if not 0 <= port <= 65535:
            raise ValueError(f"port: {port} is not within 0 to 65535")
        if writes not in {"none", "tls", "all"}:
            raise ValueError(f'writes: {writes!r} is not "none", "tls" or "all"')
        if connections_max < 1:
            raise ValueError(f"connections_max: {connections_max} is below 1")
        self.requests = 0
        self.exceptions = 0
        self._host = host
        self._port = port
        self._connections_max = connections_max
        self._tables = Tables(writable=writes == "all", on_write=on_write)
        self._connections: dict[_Connection, None] = {}  # in the order in which they came
        self._listener: asyncio.Server | None = None

    @property
    def port(self) -> int:
        """TCP port, the real one once the server has started."""
        return self._port

    @property
    def connections(self) -> int:
        """Number of clients connected."""
        return len(self._connections)

    async def start(self) -> None:
        """Listen; until the first `publish`, everything reads as no value.

        Raises
        ------
        OSError
            The address cannot be bound, for instance because the port is taken.
        """
        loop = asyncio.get_running_loop()
        self._listener = await loop.create_server(lambda: _Connection(self), self._host, self._port)
        self._port = self._listener.sockets[0].getsockname()[1]

    async def stop(self) -> None:
        """Close the port and all connections."""
        if self._listener is None:
            return
        self._listener.close()
        for connection in tuple(self._connections):
            connection.abort()
        await self._listener.wait_closed()
        self._listener = None

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

    def answer(self, frame: bytes) -> bytes:
        """Answer to one whole request, both with header and unit."""
        self.requests += 1
        unit, request = frame[6], frame[7:]
        silent = bytes((request[0] | 0x80, _GATEWAY_TARGET_SILENT))
        answer = self._tables.answer(request) if unit in _UNITS else silent
        if answer[0] & 0x80:
            self.exceptions += 1
        return frame[:4] + struct.pack(">HB", len(answer) + 1, unit) + answer

    def admit(self, connection: _Connection) -> bool:
        """Count a new connection in, unless there are too many that are in use."""
        if len(self._connections) >= self._connections_max and not self._make_room():
            return False
        self._connections[connection] = None
        return True

    def _make_room(self) -> bool:
        for connection in self._connections:
            if not connection.has_asked:
                connection.abort()
                self.dismiss(connection)
                return True
        return False

    def dismiss(self, connection: _Connection) -> None:
        """Count a connection out."""
        self._connections.pop(connection, None)
