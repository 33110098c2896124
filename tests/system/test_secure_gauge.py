"""The whole gauge with certificates that its own command has made."""

import pytest
from modbus_wire import Wire, exception, read, write_coils, write_registers
from plc_view import has_value, wait_for
from running import free_port, running_with_log
from tls_wire import TlsWire

from appliance.cli.main import main


@pytest.fixture
def certificates(tmp_path):
    folder = tmp_path / "certificates"
    for name, role in (("plc", "engineer"), ("hmi", "operator"), ("scada", "viewer")):
        assert main(["certificates", "--output", str(folder), "--client", name, "--role", role]) == 0
    return folder


@pytest.mark.parametrize("plain", ["true", "false"])
def test_writes_by_tls_work_by_role_and_are_logged(tmp_path, certificates, plain):
    port, secure = free_port(), free_port()
    config = tmp_path / "gauge.toml"
    config.write_text(
        f'[plc]\nport = {port}\nplain = {plain}\nwrites = "tls"\n[plc.tls]\nport = {secure}\n'
        'certificate = "certificates/server.pem"\nkey = "certificates/server.key"\n'
        'authority = "certificates/authority.pem"\n'
    )
    log = tmp_path / "log"
    said = port if plain == "true" else secure
    with running_with_log("run", "--config", config, port=said, log=log), TlsWire(secure, certificates, "plc") as plc:
        wait_for(plc, has_value, 60)
        assert plc.ask(write_registers(200, 26550, 40, 30))[0] == 16
        assert wait_for(plc, lambda seen: seen["deviation"] is not None, 30)["decision"] in {1, 2, 3}
        with TlsWire(secure, certificates, "hmi") as hmi, TlsWire(secure, certificates, "scada") as scada:
            assert hmi.ask(write_registers(200, 20000)) == exception(16, 1)
            assert hmi.ask(write_coils(33, True))[0] == 15
            assert scada.ask(write_coils(33, False)) == exception(15, 1)
            assert wait_for(scada, lambda seen: seen["device_state"] == 3 and not seen["validity"], 5)
        if plain == "true":
            with Wire(port) as other:
                assert other.ask(write_registers(200, 20000)) == exception(16, 1)
                assert other.ask(read(3, 200, 1))[2:] == (26550).to_bytes(2, "big")
        else:
            with pytest.raises(ConnectionRefusedError):
                Wire(port)
    lines = log.read_text()
    assert "written by 127.0.0.1 (engineer, certificate plc): target_diameter 0.00 mm -> 265.50 mm" in lines
    assert "written by 127.0.0.1 (operator, certificate hmi): hold 0 -> 1" in lines
    assert lines.count("its certificate's role is viewer") == 1
