"""A Modbus server that everybody may write to, and a connection to it."""

from collections.abc import Iterator

import pytest
from modbus_wire import LIVE, Wire, served

from plc.process_image import encode
from plc.security.roles import Client
from plc.server import ModbusServer


class Writes(list):
    """Every call of `on_write`; raises when it is told to."""

    broken = False

    def __init__(self) -> None:
        super().__init__()
        self.clients: list[Client] = []

    def __call__(self, changed: dict[str, int | bool], client: Client) -> None:
        if self.broken:
            raise OSError("disk full")
        self.append(dict(changed))
        self.clients.append(client)


@pytest.fixture
def written() -> Writes:
    return Writes()


@pytest.fixture
def server(written: Writes) -> Iterator[ModbusServer]:
    """A server that everybody may write to, with one published image."""
    server = ModbusServer("127.0.0.1", 0, writes="all", connections_max=8, on_write=written)
    server.publish(encode(LIVE))
    with served(server):
        yield server


@pytest.fixture
def wire(server: ModbusServer) -> Iterator[Wire]:
    with Wire(server.port) as wire:
        yield wire
