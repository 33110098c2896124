"""Addresses that the gauge is bound to, and addresses that may write."""

import ipaddress
import re
from dataclasses import dataclass
from typing import Self

_IpNetwork = ipaddress.IPv4Network | ipaddress.IPv6Network
_IpAddress = ipaddress.IPv4Address | ipaddress.IPv6Address
_LABEL = re.compile(r"(?!-)[A-Za-z0-9_-]{1,63}(?<!-)")
EVERY_IPV4 = "0.0.0.0"  # noqa: S104  named, not bound
EVERY = "::"


@dataclass(frozen=True, slots=True)
class Network:
    """One address, or a network of addresses.

    Attributes
    ----------
    network : IPv4Network or IPv6Network
    """

    network: _IpNetwork

    @classmethod
    def parse(cls, text: str) -> Self:
        """Address or network in words, as `10.0.0.5`, `10.1.0.0/16` or `fd00::/8`.

        Raises
        ------
        ValueError
            It is neither; the message says what to give.
        """
        try:
            return cls(ipaddress.ip_network(text))
        except ValueError:
            pass
        try:
            near = ipaddress.ip_network(text, strict=False)
        except ValueError:
            raise ValueError(f"{text!r} is no IP address and no network; give one as 10.0.0.5 or 10.1.0.0/16") from None
        raise ValueError(f"{text!r} names a host and a network at once; give {near} or {text.partition('/')[0]}")

    def has(self, address: str) -> bool:
        """Whether the address of a client lies within."""
        return plain(ipaddress.ip_address(address.partition("%")[0])) in self.network


def plain(address: _IpAddress) -> _IpAddress:
    """IPv4 address of a client that has come through an IPv6 socket, or the address as it is."""
    return getattr(address, "ipv4_mapped", None) or address


def check_host(text: str) -> str:
    """Check what the server shall bind to; names are not looked up.

    Parameters
    ----------
    text : str
        Name of a host, or an address.

    Returns
    -------
    str
        The same.

    Raises
    ------
    ValueError
        It is empty, or neither a name nor an address; the message says what to give.
    """
    try:
        ipaddress.ip_address(text)
    except ValueError:
        labels = text.removesuffix(".").split(".")
        if len(text) > 253 or not all(map(_LABEL.fullmatch, labels)) or labels[-1].isdigit():
            advice = (
                f"give an address of this computer, its name, {EVERY_IPV4} (every IPv4 address) or :: (every address)"
            )
            raise ValueError(f"{text!r} is no address and no name of a host; {advice}") from None
    return text


def served_in_words(host: str) -> str:
    """What a host setting serves, for people.

    Parameters
    ----------
    host : str
        As checked by `check_host`.
    """
    if host == EVERY:
        return "every address of this computer, IPv4 and IPv6"
    if host == EVERY_IPV4:
        return "every IPv4 address of this computer"
    try:
        loopback = ipaddress.ip_address(host).is_loopback
    except ValueError:
        return f"the addresses of {host}"
    return "this computer only" if loopback else f"the network of {host}"
