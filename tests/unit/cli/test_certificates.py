"""The command that makes certificates, read with openssl."""

import ipaddress
import subprocess

import pytest

from appliance.cli.main import main


def openssl(*words) -> str:
    return subprocess.run(["openssl", *words], capture_output=True, text=True, check=True, timeout=20).stdout


def test_one_command_makes_authority_server_and_client_that_openssl_verifies(tmp_path, capsys):
    folder = tmp_path / "keys"
    words = ["certificates", "--output", str(folder), "--host", "10.0.0.7", "--client", "plc1", "--role", "engineer"]
    assert main(words) == 0
    assert {file.name for file in folder.iterdir()} == {
        "authority.pem", "authority.key", "server.pem", "server.key", "client-plc1.pem", "client-plc1.key",
    }  # fmt: skip
    for name, purpose in (("server", "sslserver"), ("client-plc1", "sslclient")):
        command = (
            "verify",
            "-x509_strict",
            "-purpose",
            purpose,
            "-CAfile",
            folder / "authority.pem",
            folder / f"{name}.pem",
        )
        assert openssl(*command).strip().endswith("OK")
    names = openssl("x509", "-in", folder / "server.pem", "-noout", "-ext", "subjectAltName")
    assert "IP Address:10.0.0.7" in names
    assert ipaddress.ip_address("127.0.0.1").compressed in names
    parsed = openssl("asn1parse", "-in", folder / "client-plc1.pem")
    place = parsed.index("1.3.6.1.4.1.50316.802.1")
    assert bytes((0x0C, 8)).hex().upper() + b"engineer".hex().upper() in parsed[place : place + 200]
    assert "[plc.tls]" in capsys.readouterr().out


def test_a_second_client_keeps_authority_and_server_and_a_call_without_one_renews_the_server(tmp_path):
    assert main(["certificates", "--output", str(tmp_path)]) == 0
    first = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert main(["certificates", "--output", str(tmp_path), "--client", "hmi", "--role", "viewer"]) == 0
    assert first.items() <= {file.name: file.read_bytes() for file in tmp_path.iterdir()}.items()
    assert main(["certificates", "--output", str(tmp_path)]) == 0
    assert (tmp_path / "authority.pem").read_bytes() == first["authority.pem"]
    assert (tmp_path / "server.pem").read_bytes() != first["server.pem"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--client", "plc1"], "--role"),
        (["--role", "viewer"], "--client"),
        (["--client", "../x", "--role", "viewer"], "--client"),
        (["--host", "a b"], "--host"),
    ],
)
def test_what_cannot_be_is_one_sentence(tmp_path, capsys, words, sentence):
    assert main(["certificates", "--output", str(tmp_path), *words]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1


def test_an_authority_without_its_key_is_told(tmp_path, capsys):
    main(["certificates", "--output", str(tmp_path)])
    (tmp_path / "authority.key").unlink()
    assert main(["certificates", "--output", str(tmp_path), "--client", "a", "--role", "viewer"]) == 2
    assert "authority.key" in capsys.readouterr().err
