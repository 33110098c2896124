"""A Modbus server that everybody may write to, a connection to it, and a server with certificates beside."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from modbus_wire import LIVE, Wire, served

from plc.process_image import encode
from plc.security.certificates import Authority
from plc.security.identity import TlsFiles
from plc.security.roles import Client, Role
from plc.security.secure_port import SecurePort
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


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files of a private authority, of the server, and of a client of each role, named by it."""
    folder = tmp_path_factory.mktemp("certificates")
    authority = Authority.make()
    authority.save(folder)
    authority.server(folder, ["127.0.0.1"])
    for role in Role:
        authority.client(folder, role, role)
    return folder


@pytest.fixture
def secure_server(folder: Path, written: Writes) -> Iterator[ModbusServer]:
    """A server with a plain port that nobody may write to and a secure one, with one published image."""
    files = TlsFiles(folder / "server.pem", folder / "server.key", folder / "authority.pem")
    server = ModbusServer("127.0.0.1", 0, writes="tls", secure=SecurePort(0, files), on_write=written)
    server.publish(encode(LIVE))
    with served(server):
        yield server
