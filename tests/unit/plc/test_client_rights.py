"""Addresses, roles and the logs of clients."""

import asyncio
import logging
from datetime import UTC, datetime, timedelta

import pytest

from plc.security.addresses import EVERY_IPV4, Network, check_host, served_in_words
from plc.security.certificates import Authority
from plc.security.identity import TlsFiles
from plc.security.refusals import REMEMBERED, REPEATED_AFTER_S, Refusals, WriteLog
from plc.security.roles import Client, Role, WritePolicy
from plc.security.secure_port import SecurePort


class Clock:
    now_s = 100_000.0  # a day after the start, later than any time that is waited for

    def __call__(self) -> float:
        return self.now_s


@pytest.mark.parametrize(
    ("text", "inside", "outside"),
    [
        ("10.0.0.5", "10.0.0.5", "10.0.0.6"),
        ("10.1.0.0/16", "10.1.255.1", "10.2.0.1"),
        ("10.1.0.0/16", "::ffff:10.1.2.3", "::ffff:10.2.2.3"),
        ("fd00::/8", "fd12::1%eth0", "fe80::1"),
    ],
)
def test_a_network_has_its_addresses(text, inside, outside):
    network = Network.parse(text)
    assert network.has(inside)
    assert not network.has(outside)


@pytest.mark.parametrize(("text", "advice"), [("10.1.2.3/16", "10.1.0.0/16"), ("plc", "10.0.0.5"), ("", "10.0.0.5")])
def test_what_is_no_network_is_told_with_what_to_give(text, advice):
    with pytest.raises(ValueError, match=advice):
        Network.parse(text)


@pytest.mark.parametrize("text", ["127.0.0.1", "::", "::1", EVERY_IPV4, "gauge", "gauge.mill.example", "a-1"])
def test_names_and_addresses_can_be_bound(text):
    assert check_host(text) == text


@pytest.mark.parametrize(
    "text", ["", " ", "10.0.0", "10.0.0.256", "1.2.3.4:502", "a..b", "-a", "a b", "x" * 64, ":::", "[::1]"]
)
def test_what_is_neither_name_nor_address_is_refused(text):
    with pytest.raises(ValueError, match="give an address of this computer"):
        check_host(text)


def test_what_a_host_serves_is_said():
    assert "IPv4 and IPv6" in served_in_words("::")
    assert "every IPv4" in served_in_words(EVERY_IPV4)
    assert "only" in served_in_words("127.0.0.1")


NETWORKS = frozenset({Network.parse("10.0.0.0/8")})


@pytest.mark.parametrize("writers", [frozenset(), NETWORKS])
@pytest.mark.parametrize("address", ["10.0.0.5", "11.0.0.5"])
@pytest.mark.parametrize("writes", ["none", "tls", "all"])
@pytest.mark.parametrize("role", [None, *Role])
def test_nobody_has_more_rights_than_port_address_and_role_each_give(writers, address, writes, role):
    policy = WritePolicy(writes, writers)
    listed = not writers or address.startswith("10.")
    plain = policy.on_plain_port(address)
    assert (plain.role == Role.ENGINEER) == (writes == "all" and listed)
    secure = policy.with_certificate(address, "plc1", role)
    expected = role if role and listed and writes != "none" else Role.VIEWER
    assert secure.role == expected
    for client in (plain, secure):
        assert client.limit or client.role == Role.ENGINEER


def test_roles_are_bound_to_functions():
    assert {role: Client("a", role).functions & {5, 6, 15, 16, 23} for role in Role} == {
        Role.VIEWER: set(),
        Role.OPERATOR: {5, 15},
        Role.ENGINEER: {5, 6, 15, 16, 23},
    }


def test_a_refusal_is_logged_once_an_hour_for_each_cause_and_address(caplog):
    clock = Clock()
    refusals = Refusals(clock)
    for _ in range(100):
        refusals.tell("10.0.0.1", "no right")
        refusals.tell("10.0.0.1", "no place")
        refusals.tell("10.0.0.2", "no right")
    assert len(caplog.records) == 3
    clock.now_s += REPEATED_AFTER_S
    refusals.tell("10.0.0.1", "no right")
    assert len(caplog.records) == 4


def test_a_client_of_many_addresses_fills_neither_log_nor_memory(caplog):
    refusals = Refusals(Clock())
    for number in range(100_000):
        refusals.tell(f"fd00::{number:x}", "no right")
    assert len(caplog.records) == REMEMBERED + 1
    assert len(refusals._told_s) == REMEMBERED


def test_writes_that_were_too_many_to_log_are_counted_in_the_next_line(caplog):
    caplog.set_level(logging.INFO)
    clock = Clock()
    log = WriteLog(clock)
    for number in range(250):
        log.tell("plc", f"x {number}")
    assert len(caplog.records) == 200
    clock.now_s += 10
    log.tell("plc", "x 1 -> 2")
    assert "50 writes before it" in caplog.records[-1].getMessage()


def test_a_certificate_is_due_thirty_days_ahead(tmp_path):
    authority = Authority.make(days=400)
    authority.save(tmp_path)
    authority.server(tmp_path, ["a"], days=365)
    port = SecurePort(802, TlsFiles(tmp_path / "server.pem", tmp_path / "server.key", tmp_path / "authority.pem"))
    asyncio.run(port.load())
    now = datetime.now(UTC)
    assert port.due(now + timedelta(days=334)) == ""
    assert "expires on" in port.due(now + timedelta(days=336))
    assert "has expired" in port.due(now + timedelta(days=366))
