"""A person with a button before the gauge: reads and acknowledges, plain and by TLS, as far as it may."""

import pytest
from modbus_wire import LIVE, served

from plc.client import WriteRefusedError, press
from plc.poll import Place, PollError, connect, scan
from plc.process_image import encode
from plc.security.certificates import Authority
from plc.security.identity import TlsFiles
from plc.security.roles import Role
from plc.security.secure_port import SecurePort
from plc.server import ModbusServer


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("certificates")
    authority = Authority.make()
    authority.save(folder)
    authority.server(folder, ["127.0.0.1"])
    for role in Role:
        authority.client(folder, role, role)
    return folder


@pytest.fixture
def secure_server(folder, written):
    files = TlsFiles(folder / "server.pem", folder / "server.key", folder / "authority.pem")
    server = ModbusServer("127.0.0.1", 0, writes="tls", secure=SecurePort(0, files), on_write=written)
    server.publish(encode(LIVE))
    with served(server):
        yield server


def place(server, folder, name) -> Place:
    files = TlsFiles(folder / f"client-{name}.pem", folder / f"client-{name}.key", folder / "authority.pem")
    return Place("127.0.0.1", server._secure.port, tls=files)


def test_the_same_is_read_plain_and_by_tls(secure_server, folder):
    seen = []
    for where in (Place("127.0.0.1", secure_server.port), place(secure_server, folder, Role.VIEWER)):
        client = connect(where)
        seen.append(scan(client, str(where), "big"))
        client.close()
    assert seen[0].words == seen[1].words
    assert seen[0].values["diameter"] == pytest.approx(LIVE["diameter"], abs=1e-4)


def test_a_button_is_pressed_and_let_go(secure_server, folder, written):
    press(place(secure_server, folder, Role.OPERATOR), "acknowledge")
    assert written == [{"acknowledge": True}, {"acknowledge": False}]


def test_who_may_not_write_is_told_so_and_changes_nothing(secure_server, folder, written):
    for where in (Place("127.0.0.1", secure_server.port), place(secure_server, folder, Role.VIEWER)):
        with pytest.raises(WriteRefusedError, match=r"exception 1; check plc\.writes"):
            press(where, "acknowledge")
    assert written == []


def test_certificates_that_do_not_fit_or_are_missing_are_one_sentence(secure_server, folder, tmp_path):
    stranger = Authority.make()
    stranger.save(tmp_path)
    stranger.client(tmp_path, "stranger", Role.OPERATOR)
    whole = place(secure_server, folder, Role.OPERATOR)
    for files in (
        whole.tls._replace(authority=tmp_path / "authority.pem"),  # a gauge that is not ours
        whole.tls._replace(certificate=folder / "nowhere.pem"),
    ):
        with pytest.raises(PollError, match="and the certificates"):
            press(Place("127.0.0.1", whole.port, tls=files), "acknowledge")
