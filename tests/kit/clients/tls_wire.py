"""A Modbus client of bytes that shows a certificate."""

import ssl
from pathlib import Path

from modbus_wire import Wire


def context(folder: Path, name: str | None, newest: ssl.TLSVersion = ssl.TLSVersion.TLSv1_3) -> ssl.SSLContext:
    """What a client of this name needs; None has no certificate."""
    context = ssl.create_default_context(cafile=folder / "authority.pem")
    context.maximum_version = newest
    if name:
        context.load_cert_chain(folder / f"client-{name}.pem", folder / f"client-{name}.key")
    return context


class TlsWire(Wire):
    """One connection by TLS."""

    def __init__(self, port, folder, name, *, source="127.0.0.1", newest=ssl.TLSVersion.TLSv1_3) -> None:
        super().__init__(port, source=source)
        with self.socket as plain:  # which is closed also when there is no handshake
            self.socket = context(folder, name, newest).wrap_socket(plain, server_hostname="127.0.0.1")
