"""Reads the heartbeat from the gauge's own port, as a PLC would; without an answer the watchdog restarts the gauge."""

import asyncio
import struct

from plc.registers import REGISTERS

ANSWER_TIMEOUT_S = 2.0  # chosen
_HEARTBEAT = next(row.address for row in REGISTERS if row.name == "heartbeat")
_REQUEST = struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, _HEARTBEAT, 1)
_ANSWER = struct.Struct(">HHHBBBH")
_LOOPBACKS = {"0.0.0.0": "127.0.0.1", "::": "::1", "": "127.0.0.1"}  # noqa: S104  keys are what the server binds to


class SelfCheck:
    """One connection to the gauge's own Modbus server, opened at the first request and kept.

    Parameters
    ----------
    host : str
        Address that the server is bound to.
    port : int
    """

    def __init__(self, host: str, port: int) -> None:
        self._host = _LOOPBACKS.get(host, host)
        self._port = port
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    async def heartbeat(self) -> int | None:
        """Read the heartbeat that the port serves; None without a correct answer within ANSWER_TIMEOUT_S."""
        try:
            async with asyncio.timeout(ANSWER_TIMEOUT_S):
                return await self._ask()
        except (OSError, EOFError, TimeoutError):
            self.close()
            return None

    async def _ask(self) -> int | None:
        if self._streams is None:
            self._streams = await asyncio.open_connection(self._host, self._port)
        reader, writer = self._streams
        writer.write(_REQUEST)
        *head, _, heartbeat = _ANSWER.unpack(await reader.readexactly(_ANSWER.size))
        return heartbeat if head == [1, 0, 5, 1, 4] else None

    def close(self) -> None:
        """Close the connection."""
        if self._streams is not None:
            self._streams[1].close()
            self._streams = None
