"""Roles of clients, and what each may write.

A role is bound to the functions of Modbus that it may use. The names and the place of a role in a certificate are
those of the MODBUS/TCP Security Protocol Specification (Modbus Organization, 2018, sections 8.3 and 8.4).
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

from plc.security.addresses import Network

Writes = Literal["none", "tls", "all"]

READING = frozenset({1, 2, 3, 4, 43})
COMMANDING = frozenset({5, 15})
SETTING = frozenset({6, 16, 23})
WRITING = COMMANDING | SETTING


class Role(StrEnum):
    """What a client is to the gauge."""

    VIEWER = "viewer"
    OPERATOR = "operator"
    ENGINEER = "engineer"


PERMITTED: dict[Role, frozenset[int]] = {
    Role.VIEWER: READING,
    Role.OPERATOR: READING | COMMANDING,
    Role.ENGINEER: READING | COMMANDING | SETTING,
}
"""Functions of Modbus that each role may use: everybody reads, operators write commands, engineers set points too."""


@dataclass(frozen=True, slots=True)
class Client:
    """Who sends requests over one connection.

    Attributes
    ----------
    address : str
        IP address.
    role : Role
        What it may write at most.
    certificate : str
        Common name in its certificate; empty on the plain port.
    limit : str
        Why it may not write more, for the log; empty for engineers.
    """

    address: str
    role: Role
    certificate: str = ""
    limit: str = ""

    @property
    def functions(self) -> frozenset[int]:
        """Functions of Modbus that it may use."""
        return PERMITTED[self.role]

    def __str__(self) -> str:
        named = f", certificate {self.certificate}" if self.certificate else ""
        return f"{self.address} ({self.role}{named})"


@dataclass(frozen=True, slots=True)
class WritePolicy:
    """Who may write: by port, by address, by certificate.

    Attributes
    ----------
    writes : {"none", "tls", "all"}
        Nobody, clients with a certificate as their role permits, or also everybody on the plain port.
    writers : frozenset of Network
        Addresses that may write, on both ports; empty for every address.
    """

    writes: Writes
    writers: frozenset[Network]

    def on_plain_port(self, address: str) -> Client:
        """Client that has connected without a certificate."""
        if self.writes != "all":
            return Client(address, Role.VIEWER, limit=f'plc.writes is "{self.writes}"')
        return self._by_address(Client(address, Role.ENGINEER))

    def with_certificate(self, address: str, name: str, role: Role | None) -> Client:
        """Client that has shown a certificate.

        Parameters
        ----------
        address : str
        name : str
            Common name in the certificate.
        role : Role or None
            Role in the certificate; None for none, or one that is not known: such a client is a viewer.
        """
        if self.writes == "none":
            return Client(address, Role.VIEWER, name, limit='plc.writes is "none"')
        if role is None:
            return Client(address, Role.VIEWER, name, limit="its certificate has no role that is known here")
        limit = "" if role == Role.ENGINEER else f"its certificate's role is {role}"
        return self._by_address(Client(address, role, name, limit))

    def lists(self, address: str) -> bool:
        """Whether an address is one of `writers`."""
        return any(network.has(address) for network in self.writers)

    def _by_address(self, client: Client) -> Client:
        if not self.writers or self.lists(client.address):
            return client
        return Client(client.address, Role.VIEWER, client.certificate, limit="its address is not in plc.writers")
