"""A Modbus TCP client of bytes and a server in a thread, for tests that look at every byte."""

import asyncio
import contextlib
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator

from plc.server import ModbusServer

LIVE = {
    "sequence": 77,
    "heartbeat": 5,
    "validity": 1,
    "diameter": 265.53,
    "deviation": -0.25,
    "timestamp": 1_790_000_000_123,
    "alarm_word": 0b1001_0010,
    "measurement_valid": True,
    "running": True,
}


class Wire:
    """One TCP connection that sends and receives exactly the bytes it is told to."""

    def __init__(self, port: int, *, timeout_s: float = 5.0, source: str = "127.0.0.1") -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=timeout_s, source_address=(source, 0))
        self._transaction = 0

    def __enter__(self) -> "Wire":
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def send(self, data: bytes) -> None:
        self.socket.sendall(data)

    def receive(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            part = self.socket.recv(size - len(data))
            if not part:
                raise ConnectionError(f"closed after {data.hex()}")
            data += part
        return data

    def receive_frame(self) -> bytes:
        header = self.receive(6)
        return header + self.receive(struct.unpack(">H", header[4:])[0])

    def ask(self, request: bytes, *, unit: int = 1) -> bytes:
        """Send one request, function code first; return the answer without its header."""
        self._transaction = self._transaction + 1 & 0xFFFF
        self.send(frame(request, transaction=self._transaction, unit=unit))
        answer = self.receive_frame()
        assert answer[:4] == struct.pack(">HH", self._transaction, 0)
        assert answer[6] == unit
        return answer[7:]

    def drained(self) -> bool:
        """Throw away what has arrived; whether the connection is still open."""
        timeout_s = self.socket.gettimeout()
        self.socket.setblocking(False)
        try:
            while self.socket.recv(65536):
                pass
        except BlockingIOError:
            return True
        except ConnectionError:
            return False
        finally:
            self.socket.settimeout(timeout_s)
        return False

    def closed_by_server(self) -> bool:
        """Wait for the end of the connection; False when it is still open at the time-out."""
        try:
            while self.socket.recv(65536):
                pass
        except TimeoutError:
            return False
        except ConnectionError:
            return True
        return True


def frame(request: bytes, *, transaction: int = 1, unit: int = 1) -> bytes:
    return struct.pack(">HHHB", transaction, 0, len(request) + 1, unit) + request


def read(function: int, start: int, count: int) -> bytes:
    return struct.pack(">BHH", function, start, count)


def write_registers(start: int, *words: int) -> bytes:
    size = len(words)
    return struct.pack(f">BHHB{size}H", 16, start, size, 2 * size, *words)


def write_coils(start: int, *levels: bool) -> bytes:
    size = -(-len(levels) // 8)
    bits = sum(level << place for place, level in enumerate(levels))
    return struct.pack(">BHHB", 15, start, len(levels), size) + bits.to_bytes(size, "little")


def write_and_read(read_start: int, read_count: int, write_start: int, *words: int) -> bytes:
    size = len(words)
    return struct.pack(f">BHHHHB{size}H", 23, read_start, read_count, write_start, size, 2 * size, *words)


def exception(function: int, code: int) -> bytes:
    return bytes((function | 0x80, code))


def eventually(holds: Callable[[], bool], within_s: float = 3.0) -> bool:
    until = time.monotonic() + within_s
    while not holds() and time.monotonic() < until:
        time.sleep(0.01)
    return holds()


@contextlib.contextmanager
def served(server: ModbusServer) -> Iterator[asyncio.AbstractEventLoop]:
    """Run a server in an event loop of its own thread."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    try:
        asyncio.run_coroutine_threadsafe(server.start(), loop).result(5)
        yield loop
    finally:
        asyncio.run_coroutine_threadsafe(server.stop(), loop).result(5)
        loop.call_soon_threadsafe(loop.stop)
        thread.join(5)
        loop.close()
