"""The server that the settings make, and the faults of its certificate."""

import asyncio
from pathlib import Path

import pytest

from appliance.diagnostics.faults import Faults
from appliance.settings.file import SettingsError
from appliance.supervisor.plc_server import make_server, report_certificate
from appliance.supervisor.settings import PlcSettings, TlsSettings, load
from plc.security.certificates import Authority


def secured(folder: Path, **others) -> PlcSettings:
    files = {"certificate": folder / "server.pem", "key": folder / "server.key", "authority": folder / "authority.pem"}
    return PlcSettings(tls=TlsSettings(**files), **others)


def faults_of(folder: Path) -> frozenset[str]:
    server = make_server(secured(folder), print)
    asyncio.run(server.secure.load())
    faults = Faults()
    report_certificate(server, faults)
    return faults.active


@pytest.mark.parametrize(("days", "expected"), [(31, set()), (29, {"certificate_due"}), (-1, {"certificate_due"})])
def test_a_certificate_that_ends_within_thirty_days_is_a_fault(tmp_path, days, expected):
    authority = Authority.make()
    authority.save(tmp_path)
    authority.server(tmp_path, ["gauge"], days=days)
    assert faults_of(tmp_path) == expected


def test_files_that_cannot_be_used_are_a_fault(tmp_path):
    assert faults_of(tmp_path) == {"certificate_unusable"}


def test_without_a_secure_port_there_is_nothing_to_report():
    faults = Faults()
    report_certificate(make_server(PlcSettings(), print), faults)
    assert faults.active == frozenset()


TLS = '[plc.tls]\ncertificate = "s.pem"\nkey = "s.key"\nauthority = "a.pem"\n'


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ('[plc]\nhost = ""\n', "plc.host: '' is no address"),
        ('[plc]\nhost = "10.0.0"\n', "plc.host: '10.0.0' is no address"),
        ('[plc]\nwriters = ["10.0.0.5", "10.1.2.3/16"]\n', "plc.writers: '10.1.2.3/16' names"),
        ('[plc]\nwrites = "tls"\n', "plc.tls"),
        ("[plc]\nplain = false\n", "plc.tls"),
        ('[plc.tls]\nkey = "s.key"\n', "plc.tls: certificate, key and authority belong together"),
        (f"[plc]\nport = 802\n{TLS}", "plc.tls: port 802"),
    ],
)
def test_what_cannot_be_is_named_by_its_setting_with_what_to_do(tmp_path, text, named):
    file = tmp_path / "hotgauge.toml"
    file.write_text(text)
    with pytest.raises(SettingsError, match=r"give|set") as refused:
        load(file)
    assert named in str(refused.value)


def test_files_of_certificates_start_from_the_settings_file(tmp_path):
    file = tmp_path / "hotgauge.toml"
    file.write_text(f'[plc]\nwrites = "tls"\nhost = "::"\nwriters = ["fd00::/8"]\n{TLS}')
    plc = load(file).plc
    assert plc.tls.files.certificate == tmp_path / "s.pem"
    assert plc.writers == ["fd00::/8"]
