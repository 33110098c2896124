"""Which connection gives way when all places are taken."""

from dataclasses import dataclass

from plc.security.places import LEAK_PLACES, LEAK_SILENT_S, left_behind
from plc.security.roles import Client, Role


@dataclass
class Connection:
    client: Client
    asked_s: float | None


def connections(address: str, *asked_s: float) -> list[Connection]:
    return [Connection(Client(address, Role.VIEWER), moment_s) for moment_s in asked_s]


def test_an_address_that_leaks_gives_way_although_another_has_more_and_uses_them():
    busy = connections("10.0.0.1", *[100.0] * (LEAK_PLACES + 2))
    leaking = connections("10.0.0.2", 30.0, 20.0, *[100.0] * (LEAK_PLACES - 2))
    assert left_behind([*busy, *leaking], 100.0) is leaking[1]


def test_an_address_with_few_connections_keeps_them_however_silent():
    few = connections("10.0.0.1", *[0.0] * (LEAK_PLACES - 1))
    busy = connections("10.0.0.2", *[100.0] * LEAK_PLACES)
    assert left_behind([*few, *busy], 100.0) is None


def test_nobody_gives_way_before_the_silence_is_long_enough():
    all_of_one = connections("10.0.0.1", *[100.0] * LEAK_PLACES)
    assert left_behind(all_of_one, 100.0 + LEAK_SILENT_S - 0.1) is None
    assert left_behind(all_of_one, 100.0 + LEAK_SILENT_S) is not None
    assert left_behind([], 100.0) is None
