"""Modbus/TCP Security: certificates, roles, renewal, and clients that have no right."""

import asyncio
import random
import socket
import ssl
import struct
import time
from pathlib import Path

import pytest
from cryptography import x509
from modbus_wire import (
    LIVE,
    Wire,
    eventually,
    exception,
    frame,
    read,
    served,
    write_and_read,
    write_coils,
    write_registers,
)
from pymodbus.client import ModbusTlsClient
from tls_wire import TlsWire, context

from plc.process_image import encode
from plc.security import secure_port
from plc.security.addresses import Network
from plc.security.certificates import Authority
from plc.security.identity import CertificateError, Identity, TlsFiles
from plc.security.roles import Role
from plc.security.secure_port import SecurePort
from plc.server import ModbusServer

COMMANDS = [struct.pack(">BHH", 5, 32, 0xFF00), write_coils(32, True, True)]
SETTINGS = [struct.pack(">BHH", 6, 200, 26550), write_registers(200, 26550, 40), write_and_read(0, 1, 200, 26500)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """An authority with a server and clients of every role, and another one."""
    folder = tmp_path_factory.mktemp("certificates")
    authority, stranger = Authority.make(), Authority.make()
    authority.save(folder)
    authority.server(folder, ["localhost", "127.0.0.1"])
    for role in Role:
        authority.client(folder, role, role)
    authority.client(folder, "expired", Role.ENGINEER, days=-0.01)
    stranger.client(folder, "stranger", Role.ENGINEER)
    return folder


def files(folder: Path) -> TlsFiles:
    return TlsFiles(folder / "server.pem", folder / "server.key", folder / "authority.pem")


@pytest.fixture
def server(folder, written):
    server = ModbusServer(
        "127.0.0.1", 0, writes="tls", secure=SecurePort(0, files(folder)), connections_max=8, on_write=written
    )
    server.publish(encode(LIVE))
    with served(server):
        yield server


def is_refused(server, folder, name, **options) -> bool:
    """Whether a client gets no answer; with TLS 1.3 it learns that only when it reads."""
    try:
        with TlsWire(server._secure.port, folder, name, **options) as wire:
            wire.ask(read(4, 0, 1))
    except (OSError, ConnectionError):
        return True
    return False


def logged(caplog) -> list[str]:
    return [record.getMessage() for record in caplog.records if record.name == "hotgauge.clients"]


@pytest.mark.parametrize("newest", [ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3])
def test_an_engineer_reads_and_writes_everything(server, folder, written, newest):
    with TlsWire(server._secure.port, folder, "engineer", newest=newest) as wire:
        assert wire.ask(read(4, 0, 120))[2:] == encode(LIVE).words
        assert all(wire.ask(request)[0] == request[0] for request in COMMANDS + SETTINGS)
    assert {name for change in written for name in change} == {
        "acknowledge", "hold", "target_diameter", "tolerance_plus",
    }  # fmt: skip


def test_an_operator_commands_and_cannot_set(server, folder, written, caplog):
    with TlsWire(server._secure.port, folder, "operator") as wire:
        assert [wire.ask(request) for request in SETTINGS] == [exception(one[0], 1) for one in SETTINGS]
        assert written == []
        assert all(wire.ask(request)[0] == request[0] for request in COMMANDS)
    assert written == [{"acknowledge": True}, {"hold": True}]
    assert any("role is operator" in line for line in logged(caplog))


def test_a_viewer_reads_and_every_write_answers_1_and_is_logged_once_for_each_function(server, folder, written, caplog):
    for _ in range(3):
        with TlsWire(server._secure.port, folder, "viewer") as wire:
            assert wire.ask(read(3, 0, 120))[2:] == encode(LIVE).words
            for request in COMMANDS + SETTINGS:
                assert wire.ask(request) == exception(request[0], 1)
    assert written == []
    assert len(logged(caplog)) == 5


def test_a_certificate_without_a_known_role_is_a_viewer(server, folder, written):
    Authority.load(folder).client(folder, "boss", "boss")
    with TlsWire(server._secure.port, folder, "boss") as wire:
        assert wire.ask(read(4, 0, 1))[0] == 4
        assert wire.ask(write_coils(32, True)) == exception(15, 1)
    assert written == []


@pytest.mark.parametrize(
    ("name", "cause"),
    [(None, "peer did not return a certificate"), ("stranger", "does not hold"), ("expired", "has expired")],
)
def test_a_client_without_a_valid_certificate_gets_nothing_and_is_counted_and_logged_once(
    server, folder, caplog, name, cause
):
    for _ in range(4):
        assert is_refused(server, folder, name)
    assert eventually(lambda: server.refused == 4 and server.connections == 0)
    (line,) = logged(caplog)
    assert "127.0.0.1" in line
    assert cause in line


def test_plain_modbus_and_old_tls_get_nothing_from_the_secure_port(server, folder):
    with Wire(server._secure.port, timeout_s=7) as wire:
        wire.send(frame(write_registers(200, 26550)))
        assert wire.closed_by_server()
    old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
    old.set_ciphers("ALL:@SECLEVEL=0")
    with pytest.warns(DeprecationWarning, match="TLSv1_1"):
        old.minimum_version = old.maximum_version = ssl.TLSVersion.TLSv1_1
    with (
        socket.create_connection(("127.0.0.1", server._secure.port), timeout=5) as plain,
        pytest.raises(OSError, match=r"."),
    ):
        old.wrap_socket(plain)


def test_an_address_that_is_not_listed_may_not_write_with_the_best_certificate(folder, written, caplog):
    secure = SecurePort(0, files(folder))
    listed = [Network.parse("127.0.0.5")]
    server = ModbusServer("127.0.0.1", 0, writes="tls", writers=listed, secure=secure, on_write=written)
    with served(server):
        with TlsWire(server._secure.port, folder, "engineer", source="127.0.0.6") as wire:
            assert wire.ask(write_registers(200, 26550)) == exception(16, 1)
        assert written == []
        with TlsWire(server._secure.port, folder, "engineer", source="127.0.0.5") as wire:
            assert wire.ask(write_registers(200, 26550))[0] == 16
    assert len([line for line in logged(caplog) if "not in plc.writers" in line]) == 1


def test_the_plain_port_can_be_off(folder, written):
    server = ModbusServer("127.0.0.1", None, writes="tls", secure=SecurePort(0, files(folder)), on_write=written)
    with served(server) as loop:
        assert server.port == 0
        with TlsWire(server._secure.port, folder, "engineer") as wire:
            assert wire.ask(read(4, 0, 1))[0] == 4

        async def connect() -> socket.socket:
            return server.connect()

        with asyncio.run_coroutine_threadsafe(connect(), loop).result(5) as own:
            own.settimeout(5)
            own.sendall(frame(read(4, 1, 1)) + frame(write_registers(200, 26550)))
            assert own.recv(11)[7:] == bytes((4, 2, 0, 5))
            assert own.recv(64)[7:] == exception(16, 1)


def test_the_plain_port_stays_read_only_beside_the_secure_one(server, written):
    with Wire(server.port) as wire:
        assert wire.ask(write_registers(200, 26550)) == exception(16, 1)
        assert wire.ask(read(4, 0, 120))[2:] == encode(LIVE).words


def test_pymodbus_with_a_certificate_reads_and_writes(server, folder, written):
    engineer = context(folder, "engineer")
    engineer.check_hostname = False  # it never says which host it means
    with ModbusTlsClient("127.0.0.1", port=server._secure.port, sslctx=engineer, retries=0) as client:
        block = client.read_input_registers(0, count=120)
        assert struct.pack(">120H", *block.registers) == encode(LIVE).words
        assert not client.write_registers(200, [26550, 40, 30]).isError()
        assert not client.write_coil(33, True).isError()
    assert written == [{"target_diameter": 26550, "tolerance_plus": 40, "tolerance_minus": 30}, {"hold": True}]


def test_half_open_handshakes_lock_nobody_out(server, folder):
    silent = [Wire(server._secure.port) for _ in range(20)]
    with TlsWire(server._secure.port, folder, "engineer") as wire:
        assert wire.ask(read(4, 0, 1))[0] == 4
    for wire in silent:
        wire.socket.close()
    assert eventually(lambda: server.connections == 0)


def test_certificates_are_renewed_without_a_restart_and_connections_live_on(tmp_path, written, monkeypatch):
    monkeypatch.setattr(secure_port, "RENEWAL_PERIOD_S", 0.1)
    authority = Authority.make()
    authority.save(tmp_path)
    authority.server(tmp_path, ["127.0.0.1"], days=3)
    authority.client(tmp_path, "plc", Role.ENGINEER)
    secure = SecurePort(0, files(tmp_path))
    server = ModbusServer("127.0.0.1", None, writes="tls", secure=secure, on_write=written)
    with served(server), TlsWire(server._secure.port, tmp_path, "plc") as before:
        assert "expires on" in secure.due()
        (tmp_path / "server.pem").write_text("half a certificate")
        assert eventually(lambda: "plc.tls.certificate" in secure.trouble)
        assert before.ask(read(4, 0, 1))[0] == 4
        authority.server(tmp_path, ["127.0.0.1"])
        assert eventually(lambda: not secure.trouble and not secure.due())
        with TlsWire(server._secure.port, tmp_path, "plc") as after:
            assert after.ask(write_registers(200, 26550))[0] == 16
        assert before.ask(read(4, 0, 1))[0] == 4
        other = Authority.make()
        other.save(tmp_path)
        other.server(tmp_path, ["127.0.0.1"])
        assert eventually(lambda: server.connections == 0)  # nobody stays whom the new authority does not know
        assert is_refused(server, tmp_path, "plc")


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (lambda folder: (folder / "server.key").unlink(), "plc.tls.key"),
        (lambda folder: (folder / "server.pem").write_text("x"), "plc.tls.certificate"),
        (lambda folder: (folder / "authority.pem").unlink(), "plc.tls.authority"),
        (lambda folder: (folder / "client-plc.key").replace(folder / "server.key"), "plc.tls.key"),
    ],
)
def test_files_that_cannot_be_used_are_named_by_their_setting(tmp_path, spoil, named):
    authority = Authority.make()
    authority.save(tmp_path)
    authority.server(tmp_path, ["127.0.0.1"])
    authority.client(tmp_path, "plc", Role.ENGINEER)
    spoil(tmp_path)
    with pytest.raises(CertificateError, match=named):
        Identity.load(files(tmp_path))


def test_keys_can_be_read_by_their_owner_only(folder):
    assert {file.stat().st_mode & 0o777 for file in folder.glob("*.key")} == {0o600}


def test_ten_thousand_random_writes_without_right_over_all_ports_and_roles_change_nothing(server, folder, written):
    chance = random.Random(20261129)
    viewer, operator = (TlsWire(server._secure.port, folder, name) for name in ("viewer", "operator"))
    plain = Wire(server.port)
    begun_s = time.monotonic()
    for _ in range(10_000):
        wire = chance.choice([viewer, operator, plain])
        body = bytearray(chance.choice(SETTINGS if wire is operator else COMMANDS + SETTINGS))
        for _ in range(chance.randrange(4)):
            body[chance.randrange(1, len(body))] = chance.randrange(256)
        wire.send(frame(bytes(body), unit=chance.choice([0, 1, 255])))
        assert wire.receive_frame()[7] & 0x80
    assert time.monotonic() - begun_s < 60
    assert written == []
    assert plain.ask(read(3, 200, 8))[2:] == bytes(16)
    assert plain.ask(read(1, 32, 2)) == bytes((1, 1, 0))
    for wire in (viewer, operator, plain):
        wire.socket.close()


def test_a_certificate_is_looked_at_with_every_connection_also_of_a_session_that_goes_on(server, folder):
    """TLS 1.2 resumes a session by a ticket without a look at the certificate: no ticket is given."""
    asking = context(folder, "viewer", ssl.TLSVersion.TLSv1_2)

    def connect(session=None) -> ssl.SSLSocket:
        plain = socket.create_connection(("127.0.0.1", server._secure.port), timeout=5)
        return asking.wrap_socket(plain, server_hostname="127.0.0.1", session=session)

    with connect() as first:
        session = first.session
    assert not session.has_ticket
    with connect(session) as second:
        assert second.version() == "TLSv1.2"
        assert not second.session_reused


def test_extensions_that_limit_the_authority_are_critical(folder):
    """RFC 5280, 4.2.1.3 and 4.2.1.9: a program that does not know them must refuse the certificate."""
    authority = x509.load_pem_x509_certificate((folder / "authority.pem").read_bytes())
    for kind in (x509.BasicConstraints, x509.KeyUsage):
        assert authority.extensions.get_extension_for_class(kind).critical
