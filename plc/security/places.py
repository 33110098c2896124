"""Which connection gives way to a newcomer when all places are taken."""

from collections import Counter
from collections.abc import Collection
from typing import Protocol, TypeVar

from plc.security.roles import Client

# chosen: a client with so many connections, one of them silent for so long while all places are taken, leaks them
LEAK_PLACES, LEAK_SILENT_S = 8, 60.0


class Placed(Protocol):
    """A connection that has a place."""

    client: Client
    asked_s: float | None
    """Monotonic time of its last whole request; None before the first."""


PlacedT = TypeVar("PlacedT", bound=Placed)


def never_asked(connections: Collection[PlacedT]) -> PlacedT | None:
    """Oldest connection that has not asked yet, of the address that has most of them."""
    idle = [connection for connection in connections if connection.asked_s is None]
    addresses = Counter(connection.client.address for connection in idle)
    return max(idle, key=lambda connection: addresses[connection.client.address], default=None)


def left_behind(connections: Collection[PlacedT], now_s: float) -> PlacedT | None:
    """Longest silent connection of an address that leaks them: one with LEAK_PLACES or more, LEAK_SILENT_S silent.

    Parameters
    ----------
    connections : collection of Placed
        All of them have asked before; in the order in which they came.
    now_s : float
        Monotonic time.
    """
    places = Counter(connection.client.address for connection in connections)
    leaking = [connection for connection in connections if places[connection.client.address] >= LEAK_PLACES]
    oldest = min(leaking, key=lambda connection: connection.asked_s or 0.0, default=None)
    return oldest if oldest is not None and now_s - (oldest.asked_s or 0.0) >= LEAK_SILENT_S else None
