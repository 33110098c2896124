"""Reads the heartbeat of a gauge, as a PLC would; without an answer the watchdog restarts the gauge."""

import asyncio
import socket
import struct
from collections.abc import Callable

from plc.registers import REGISTERS

ANSWER_TIMEOUT_S = 2.0  # chosen
_HEARTBEAT = next(row.address for row in REGISTERS if row.name == "heartbeat")
_REQUEST = struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, _HEARTBEAT, 1)
_ANSWER = struct.Struct(">HHHBBBH")


class SelfCheck:
    """One connection to a Modbus server, opened when it is needed and kept.

    Parameters
    ----------
    connect : callable
        Gives a socket that is connected, or raises OSError.
    """

    def __init__(self, connect: Callable[[], socket.socket]) -> None:
        self._connect = connect
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    async def heartbeat(self) -> int | None:
        """Read the heartbeat that the server serves; None without a correct answer within ANSWER_TIMEOUT_S."""
        try:
            async with asyncio.timeout(ANSWER_TIMEOUT_S):
                return await self._ask()
        except (OSError, EOFError, TimeoutError):
            self.close()
            return None

    async def _ask(self) -> int | None:
        if self._streams is None:
            self._streams = await asyncio.open_connection(sock=self._connect())
        reader, writer = self._streams
        writer.write(_REQUEST)
        *head, _, heartbeat = _ANSWER.unpack(await reader.readexactly(_ANSWER.size))
        return heartbeat if head == [1, 0, 5, 1, 4] else None

    def close(self) -> None:
        """Close the connection."""
        if self._streams is not None:
            self._streams[1].close()
            self._streams = None
