"""A Modbus TCP server with one range in its input registers, of sockets: it answers, refuses or stays silent."""

import contextlib
import socket
import struct
import threading


class RangeRegister:
    """Serves until it is closed; `words` are the registers from `address`, `answers` False keeps silent."""

    def __init__(self, address: int, words: list[int], port: int = 0) -> None:
        self.address, self.words, self.answers = address, words, True
        self.asked: list[bytes] = []
        self._listener = socket.create_server(("127.0.0.1", port))
        self.port = self._listener.getsockname()[1]
        self._open: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def __enter__(self) -> "RangeRegister":
        return self

    def __exit__(self, *_: object) -> None:
        for one in (self._listener, *self._open):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                self._open.append(client)
                threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while len(request := client.recv(12)) == 12:
                self.asked.append(request)
                if self.answers:
                    client.sendall(self._answer(request))

    def _answer(self, request: bytes) -> bytes:
        transaction, _, _, unit, function, address, count = struct.unpack(">HHHBBHH", request)
        if (function, address, count) == (4, self.address, len(self.words)):
            body = struct.pack(f">BB{count}H", function, 2 * count, *self.words)
        else:
            body = struct.pack(">BB", function | 0x80, 2)
        return struct.pack(">HHHB", transaction, 0, len(body) + 1, unit) + body
