"""The PLC's server as the settings want it, and what is wrong with its certificate."""

from appliance.diagnostics.faults import Faults
from appliance.supervisor.settings import PlcSettings
from plc.answers import OnWrite
from plc.security.addresses import Network
from plc.security.secure_port import SecurePort
from plc.server import ModbusServer


def make_server(settings: PlcSettings, on_write: OnWrite) -> ModbusServer:
    """The server of the settings, not started.

    Parameters
    ----------
    settings : PlcSettings
    on_write : callable
        Gets what the PLC writes, by name.
    """
    files = settings.tls.files
    return ModbusServer(
        settings.host,
        settings.port if settings.plain else None,
        writes=settings.writes,
        writers=[Network.parse(text) for text in settings.writers],
        secure=None if files is None else SecurePort(settings.tls.port, files),
        connections_max=settings.connections_max,
        on_write=on_write,
    )


def report_certificate(server: ModbusServer, faults: Faults) -> None:
    """Report a certificate that ends soon or cannot be used.

    Parameters
    ----------
    server : ModbusServer
    faults : Faults
    """
    if server.secure is None:
        return
    for name, detail in (("certificate_unusable", server.secure.trouble), ("certificate_due", server.secure.due())):
        faults.report(name, active=bool(detail), detail=detail)
