"""A person with a button before the gauge: reads and acknowledges, plain and by TLS, as far as it may."""

import pytest
from modbus_wire import LIVE

from appliance.cli.main import main
from plc.client import WriteRefusedError, press
from plc.poll import Place, PollError, connect, scan
from plc.security.certificates import Authority
from plc.security.identity import TlsFiles
from plc.security.roles import Role


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


def test_a_poll_without_a_certificate_of_the_gauges_authority_is_one_sentence(secure_server, folder, tmp_path, capsys):
    port = secure_server._secure.port
    assert main(["poll", "127.0.0.1", "--port", str(port), "--count", "1"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"127.0.0.1:{port}: connection lost; check that the gauge runs, that the port is the plain one" in said
    assert "Modbus Error" not in said
    stranger = Authority.make()
    stranger.client(tmp_path, "stranger", Role.OPERATOR)
    files = TlsFiles(tmp_path / "client-stranger.pem", tmp_path / "client-stranger.key", folder / "authority.pem")
    with pytest.raises(PollError, match=r"connection lost; .*, or the certificate$"):
        press(Place("127.0.0.1", port, tls=files), "acknowledge")
