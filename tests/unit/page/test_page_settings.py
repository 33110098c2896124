"""Settings of the page, and where it finds the gauge."""

from pathlib import Path

import pytest

from appliance.cli import main as cli
from appliance.cli.gauge.page import place_of
from appliance.command_options import CommandError
from appliance.page.access.users import Users
from appliance.settings.file import SettingsError
from appliance.supervisor.settings import load
from plc.security.roles import Role


def settings(folder: Path, text: str):
    file = folder / "hotgauge.toml"
    file.write_text(text)
    return load(file)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('host = "10.0.0.20"', "sends passwords over the network"),
        ('host = "0.0.0.0"', "sends passwords over the network"),
        ('certificate = "a.pem"', "belong together"),
        ('gauge_key = "a.key"', "belong together"),
        ("login_max_h = 0", "login_max_h"),
    ],
)
def test_settings_that_are_unsafe_or_not_whole_are_refused(tmp_path, text, said):
    with pytest.raises(SettingsError, match=said):
        settings(tmp_path, f"[page]\n{text}\n")


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost"])
def test_loopback_needs_no_certificate(tmp_path, host):
    assert settings(tmp_path, f'[page]\nhost = "{host}"\n').page.host == host


def test_the_page_finds_the_gauge_of_its_settings(tmp_path):
    plain = place_of(settings(tmp_path, '[plc]\nhost = "0.0.0.0"\nport = 502\nword_order = "little"\n'))
    assert (plain.host, plain.port, plain.word_order, plain.tls) == ("127.0.0.1", 502, "little", None)
    tls = '[plc]\nhost = "10.0.0.5"\n[plc.tls]\ncertificate = "s.pem"\nkey = "s.key"\nauthority = "a.pem"\n'
    secure = place_of(settings(tmp_path, tls + '[page]\ngauge_certificate = "c.pem"\ngauge_key = "c.key"\n'))
    assert (secure.host, secure.port) == ("10.0.0.5", 802)
    assert [file.name for file in secure.tls] == ["c.pem", "c.key", "a.pem"]


def test_a_gauge_that_cannot_be_read_is_told(tmp_path):
    with pytest.raises(CommandError, match="no secure port"):
        place_of(settings(tmp_path, '[page]\ngauge_certificate = "c.pem"\ngauge_key = "c.key"\n'))
    tls = '[plc]\nplain = false\n[plc.tls]\ncertificate = "s.pem"\nkey = "s.key"\nauthority = "a.pem"\n'
    with pytest.raises(CommandError, match="only its secure port"):
        place_of(settings(tmp_path, tls))


def test_a_user_is_added_and_taken_out_by_the_command(tmp_path, monkeypatch, capsys):
    config = tmp_path / "hotgauge.toml"
    config.write_text('[page]\nusers = "users.json"\n')
    read_from = tmp_path / "password"
    read_from.write_text("a good password\n")
    with read_from.open() as pipe:
        monkeypatch.setattr("sys.stdin", pipe)
        assert cli.main(["page-user", "anna", "--role", "operator", "--config", str(config)]) == 0
    users = Users(tmp_path / "users.json")
    assert users.check("anna", "a good password").role is Role.OPERATOR
    assert "a good password" not in capsys.readouterr().out
    assert cli.main(["page-user", "anna", "--remove", "--config", str(config)]) == 0
    assert users.all() == []
    assert cli.main(["page-user", "anna", "--remove", "--config", str(config)]) == 2
    assert "none of this name" in capsys.readouterr().err
