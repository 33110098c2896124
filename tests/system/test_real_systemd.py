"""A real systemd starts the installed service, loses it to a kill and to a hang, and gets it back."""

import json
import time
from collections.abc import Iterator

import pytest
from container import Container, container, wait_until, why_impossible
from modbus_wire import Wire, write_coils
from plc_view import has_value, look
from running import free_port

from plc.registers import REGISTERS

pytestmark = pytest.mark.waiting

STARTED_S = 150
PICTURES = "/var/lib/hotgauge/pictures"
PICTURE_NICENESS = 10
KEEP_PICTURES = next(row.address for row in REGISTERS if row.name == "keep_pictures")


@pytest.fixture(scope="module")
def port() -> int:
    return free_port()


@pytest.fixture(scope="module")
def booted(tmp_path_factory, port) -> Iterator[Container]:
    if reason := why_impossible():
        pytest.skip(f"no container on this computer: {reason}")
    with container(tmp_path_factory.mktemp("container")) as booted:
        config = booted.root / "etc/hotgauge/hotgauge.toml"
        config.parent.mkdir()
        config.write_text(
            f'[plc]\nport = {port}\nwrites = "all"\n[sizing.camera]\nkind = "mill"\nprepared_frames = 4\n'
            f'[sizing.black_box]\ndirectory = "{PICTURES}"\n'
        )
        said = booted.run("/opt/hotgauge/bin/python", "-m", "appliance", "install", timeout_s=STARTED_S)
        assert "compiled what measuring needs into /var/cache/hotgauge" in said
        assert "kept /etc/hotgauge/hotgauge.toml" in said
        wait_until(lambda: measures(port), STARTED_S)
        yield booted


def measures(port: int) -> bool:
    try:
        with Wire(port) as wire:
            return has_value(look(wire))
    except OSError:
        return False


def answers(port: int) -> bool:
    try:
        with Wire(port) as wire:
            return look(wire)["heartbeat"] is not None
    except OSError:
        return False


def journal(booted: Container, *matches: str) -> list[dict]:
    lines = booted.run("journalctl", "--unit", "hotgauge", "--output", "json", *matches, check=False).splitlines()
    return [json.loads(line) for line in lines]


def test_the_service_is_active_because_its_port_answers(booted, port):
    assert booted.shows("ActiveState") == "active"
    assert booted.shows("Type") == "notify"
    wait_until(lambda: booted.shows("StatusText").startswith("measuring"), 5)
    pid = booted.shows("MainPID")
    user = booted.run("ps", "-o", "user=", "-p", pid).strip()
    assert user == "hotgauge"
    assert (booted.root / "var/lib/hotgauge").is_dir()
    assert "NRestarts=0" in booted.run("systemctl", "show", "hotgauge", "--property", "NRestarts")


def test_a_killed_service_is_back(booted, port):
    before = booted.shows("MainPID")
    killed_s = time.monotonic()
    booted.run("kill", "-KILL", before)
    wait_until(lambda: booted.shows("MainPID") not in {before, "0"} and answers(port), 10)
    answered_s = time.monotonic() - killed_s
    wait_until(lambda: measures(port), 15)
    print(f"killed: answers after {answered_s:.1f} s, measures after {time.monotonic() - killed_s:.1f} s")


def test_a_service_that_hangs_is_ended_by_the_watchdog_and_is_back(booted, port):
    before = booted.shows("MainPID")
    hung_s = time.monotonic()
    booted.run("kill", "-STOP", before)
    wait_until(lambda: booted.shows("MainPID") not in {before, "0"} and answers(port), 20)
    answered_s = time.monotonic() - hung_s
    wait_until(lambda: measures(port), 15)
    print(f"hung: answers after {answered_s:.1f} s, measures after {time.monotonic() - hung_s:.1f} s")
    assert any("Watchdog timeout" in line["MESSAGE"] for line in journal(booted))


def test_a_killed_measuring_process_is_told_to_the_journal_with_its_fields_once_each_way(booted, port):
    main = booted.shows("MainPID")
    station = booted.run("pgrep", "-P", main).split()[0]
    assert booted.run("cat", f"/proc/{station}/oom_score_adj").strip() == "500"
    booted.run("kill", "-KILL", station)
    wait_until(lambda: len(journal(booted, "HOTGAUGE_FAULT=401")) == 2, 20)
    came, went = journal(booted, "HOTGAUGE_FAULT=401")
    assert came["HOTGAUGE_FAULT_NAME"] == "station_restarting"
    assert came["HOTGAUGE_STATION"] == "sizing"
    assert came["HOTGAUGE_PRODUCT"] == "0"
    assert came["PRIORITY"] == "3"
    assert "signal 9" in came["MESSAGE"]
    assert went["PRIORITY"] == "6"
    assert booted.shows("MainPID") == main
    wait_until(lambda: measures(port), 15)


def test_the_installed_service_keeps_pictures_in_a_thread_of_low_priority(booted, port):
    wait_until(lambda: measures(port), 15)
    with Wire(port) as wire:
        wire.ask(write_coils(KEEP_PICTURES, True))
    kept = booted.root / PICTURES.removeprefix("/")
    wait_until(lambda: list(kept.glob("2*-sizing-request/readings.jsonl")), 60)
    station = booted.run("pgrep", "-P", booted.shows("MainPID")).split()[0]
    assert str(PICTURE_NICENESS) in booted.run("ps", "-L", "-o", "ni=", "-p", station).split()


def test_broken_settings_at_a_reload_leave_the_service_as_it_is(booted, port):
    config = booted.root / "etc/hotgauge/hotgauge.toml"
    whole = config.read_text()
    main = booted.shows("MainPID")
    config.write_text(whole + "\n[sizzling]\n")
    booted.run("systemctl", "reload", "hotgauge")
    wait_until(lambda: "settings_unusable" in booted.shows("StatusText"), 5)
    config.write_text(whole)
    booted.run("systemctl", "reload", "hotgauge")
    wait_until(lambda: "settings_unusable" not in booted.shows("StatusText"), 5)
    assert booted.shows("MainPID") == main


def test_it_stops_in_time_and_without_a_trace_of_trouble(booted, port):
    begun_s = time.monotonic()
    booted.run("systemctl", "stop", "hotgauge")
    assert time.monotonic() - begun_s < 6
    assert booted.shows("Result") == "success"
    assert booted.shows("ExecMainStatus") == "0"
    booted.run("systemctl", "start", "hotgauge")
    assert answers(port)  # it has said that it is ready


def test_it_is_taken_down_cleanly(booted, port):
    said = booted.run("/opt/hotgauge/bin/python", "-m", "appliance", "install", "--remove")
    assert "kept /etc/hotgauge/hotgauge.toml" in said
    assert not answers(port)
    assert booted.run("systemctl", "is-enabled", "hotgauge", check=False).strip() != "enabled"
    left = booted.run("find", "/etc", "/var/cache", "/run/systemd", "-name", "*hotgauge*", "-not", "-path", "*/units/*")
    assert set(left.split()) <= {"/etc/hotgauge", "/etc/hotgauge/hotgauge.toml"}
