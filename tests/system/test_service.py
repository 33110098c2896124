"""What a service manager hears, on a real notify socket; the unit as systemd itself reads it; setting up and down."""

import itertools
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from modbus_wire import Wire
from plc_view import look
from rehearsal import Rehearsal, rehearsing
from running import HOTGAUGE, free_port

from appliance.service import systemd as service
from appliance.service.install import FILES, PAGE_UNIT, UNIT, InstallError, install, remove

pytestmark = pytest.mark.waiting

REPOSITORY = Path(__file__).parents[2]


class Manager:
    """A service manager's end of a notify socket, and a gauge that it has started."""

    def __init__(self, folder: Path, port: int, more: str = "") -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(folder / "notify"))
        self.port = port
        self.config = folder / "hotgauge.toml"
        self.config.write_text(f"[plc]\nport = {port}\n{more or MILL}\n")
        self.process = subprocess.Popen(
            [HOTGAUGE, "run", "--config", self.config],
            env=os.environ | {"NOTIFY_SOCKET": str(folder / "notify")},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def hear(self, within_s: float) -> str:
        """Next message; empty when none comes in time."""
        self._socket.settimeout(within_s)
        try:
            return self._socket.recv(4096).decode()
        except TimeoutError:
            return ""

    def hear_until(self, wanted: str, within_s: float) -> str:
        until_s = time.monotonic() + within_s
        while time.monotonic() < until_s:
            if wanted in (heard := self.hear(1)):
                return heard
        raise AssertionError(f"{wanted} was not heard within {within_s} s")

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        self.process.stderr.close()
        self._socket.close()


MILL = '[sizing.camera]\nkind = "mill"\nprepared_frames = 2'


@pytest.fixture
def manager(tmp_path) -> Iterator[Manager]:
    manager = Manager(tmp_path, free_port())
    yield manager
    manager.end()


def test_ready_watchdog_and_stopping_are_told_at_their_moments(manager):
    assert manager.hear(20) == "READY=1"
    with Wire(manager.port) as wire:  # it answers at the moment of READY
        assert look(wire)["map_version"] == 5
    moments_s = []
    for _ in range(5):
        assert manager.hear(5).startswith("WATCHDOG=1")
        moments_s.append(time.monotonic())
    assert max(b - a for a, b in itertools.pairwise(moments_s)) < 2.5  # systemd waits 5 s
    manager.hear_until("STATUS=measuring", 20)
    stopped_s = time.monotonic()
    manager.process.send_signal(signal.SIGTERM)
    manager.hear_until("STOPPING=1", 3)
    assert manager.process.wait(10) == 0
    assert time.monotonic() - stopped_s < 5


def test_a_gauge_that_hangs_feeds_no_watchdog(manager):
    manager.hear_until("WATCHDOG=1", 20)
    manager.process.send_signal(signal.SIGSTOP)
    while manager.hear(1):  # what was on its way
        pass
    assert manager.hear(3) == ""
    manager.process.send_signal(signal.SIGCONT)
    manager.hear_until("WATCHDOG=1", 5)


def test_a_manager_that_does_not_listen_stops_nothing(manager):
    assert manager.hear(20) == "READY=1"
    with Wire(manager.port) as wire:
        beats = []
        for _ in range(20):  # more messages than such a socket holds
            time.sleep(0.5)
            beats.append(look(wire)["heartbeat"])
    assert all(b > a for a, b in itertools.pairwise(beats))


def test_a_service_serves_what_is_wrong_instead_of_refusing(tmp_path):
    lost = f'[sizing.camera]\nkind = "recording"\npath = "{tmp_path / "absent"}"'
    manager = Manager(tmp_path, free_port(), lost)
    try:
        assert manager.hear(20) == "READY=1"
        manager.hear_until("no value; faults: rig_unusable", 20)
        with Wire(manager.port) as wire:
            seen = look(wire)
        assert (seen["device_state"], seen["validity"], seen["diameter"]) == (4, 0, None)
    finally:
        manager.end()


def test_a_port_that_is_taken_is_no_ready_and_one_sentence(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        manager = Manager(tmp_path, taken.getsockname()[1])
        try:
            assert manager.process.wait(30) == 2
            assert "Address already in use; stop what uses it" in manager.process.stderr.read()
            assert manager.hear(0.1) == ""
        finally:
            manager.end()


def test_broken_settings_at_a_reload_are_told_and_the_old_ones_stay(manager):
    manager.hear_until("STATUS=measuring", 30)
    whole = manager.config.read_text()
    manager.config.write_text("[plc\n")
    manager.process.send_signal(signal.SIGHUP)
    manager.hear_until("settings_unusable", 5)
    manager.config.write_text(whole)
    manager.process.send_signal(signal.SIGHUP)
    manager.hear_until("STATUS=measuring", 5)


@pytest.fixture
def rehearsal(tmp_path, monkeypatch) -> Iterator[Rehearsal]:
    with rehearsing("fake_station", tmp_path, monkeypatch) as rehearsal:
        yield rehearsal


def test_only_a_port_that_answers_with_a_moving_heartbeat_is_proof(rehearsal, monkeypatch):
    proofs: list[str] = []
    rehearsal.on_proof = proofs.append
    rehearsal.start()
    with rehearsal.connect():
        time.sleep(2)
        assert len(proofs) >= 2
        monkeypatch.setattr(rehearsal.supervisor._server, "publish", lambda _: None)  # a cycle without its work
        time.sleep(1)
        before = len(proofs)
        time.sleep(2)
        assert len(proofs) == before


def test_without_a_manager_nothing_is_told_and_a_manager_that_is_gone_is_no_error(tmp_path, monkeypatch):
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    service.ServiceManager().ready()
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "gone"))
    service.ServiceManager().proof("measuring")


@pytest.fixture
def staged(tmp_path) -> Path:
    list(install(tmp_path))
    return tmp_path


@pytest.mark.parametrize("unit", [UNIT, PAGE_UNIT], ids=["gauge", "page"])
def test_systemd_has_nothing_to_say_about_the_unit(staged, unit):
    said = subprocess.run(["systemd-analyze", "verify", staged / unit], capture_output=True, text=True, check=False)
    assert said.stdout + said.stderr == ""
    assert said.returncode == 0


@pytest.mark.parametrize(("unit", "most"), [(UNIT, 1.8), (PAGE_UNIT, 1.6)], ids=["gauge", "page"])
def test_the_unit_is_exposed_as_little_as_promised(staged, unit, most):
    """Of 10, as systemd-analyze counts; 0.2 of it is setpriority, which it counts as all of @resources."""
    words = ["systemd-analyze", "security", "--offline=true", "--no-pager", staged / unit]
    said = subprocess.run(words, capture_output=True, text=True, check=False).stdout
    assert float(re.search(r"Overall exposure level.*: ([\d.]+)", said)[1]) <= most


def test_a_job_of_the_page_that_needs_too_much_memory_ends_alone_and_the_cache_can_be_written(staged):
    setting = re.compile(r"^(\w+)=(.*)$", re.MULTILINE)
    page, gauge = (dict(setting.findall((staged / unit).read_text())) for unit in (PAGE_UNIT, UNIT))
    assert (page["OOMPolicy"], page["Restart"]) == ("continue", "always")
    assert {"MemoryMax", "TasksMax"} <= page.keys()
    for folder in ("StateDirectory", "CacheDirectory"):
        assert page[folder] == gauge[folder]


def test_the_unit_starts_this_interpreter_and_leaves_compiled_code_possible(staged):
    unit = (staged / UNIT).read_text()
    assert f'ExecStart="{sys.executable}" -P -m appliance run --config /etc/hotgauge/hotgauge.toml\n' in unit
    assert not re.search("^MemoryDenyWriteExecute", unit, re.MULTILINE)
    assert "@" not in re.sub(r"@[a-z]+-?[a-z]*", "", unit)


def test_what_install_wrote_goes_again_and_what_people_wrote_stays(tmp_path):
    first = list(install(tmp_path))
    assert {tmp_path / file.target for file in FILES} <= {Path(line.removeprefix("wrote ")) for line in first}
    list(remove(tmp_path))
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    list(install(tmp_path))
    config = tmp_path / "etc/hotgauge/hotgauge.toml"
    config.write_text("# ours\n" + config.read_text())
    assert f"kept {config}" in list(install(tmp_path))
    assert any(str(config) in line for line in remove(tmp_path))
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [config]


def test_the_settings_that_install_writes_are_good(staged):
    asked = subprocess.run(
        [HOTGAUGE, "check-config", staged / "etc/hotgauge/hotgauge.toml"], capture_output=True, text=True, check=False
    )
    assert asked.returncode == 0, asked.stderr
    assert "plc.port = 502" in asked.stdout


def test_install_refuses_in_one_sentence_what_it_cannot_do(tmp_path):
    (tmp_path / "etc").write_text("a file")
    said = subprocess.run([HOTGAUGE, "install", "--root", tmp_path], capture_output=True, text=True, check=False)
    assert said.returncode == 2
    assert said.stderr.count("\n") == 1
    assert "etc/" in said.stderr


def doctor(*words: str | Path) -> tuple[int, dict[str, str]]:
    asked = subprocess.run([HOTGAUGE, "doctor", *words], capture_output=True, text=True, check=False, timeout=60)
    assert asked.stderr == ""
    return asked.returncode, {line.split()[1]: line.split()[0] for line in asked.stdout.splitlines()}


def test_the_doctor_finds_a_gauge_that_can_run_well(tmp_path):
    config = tmp_path / "hotgauge.toml"
    config.write_text(f'[plc]\nport = {free_port()}\nwrites = "all"\nstate_directory = "state"\n{MILL}\n')
    code, verdicts = doctor("--config", config)
    assert code == 0
    assert {name for name, verdict in verdicts.items() if verdict == "good"} >= {
        "settings",
        "cameras",
        "disk",
        "memory",
    }


def test_the_doctor_names_what_is_wrong(tmp_path):
    (tmp_path / "state").write_text("a file")
    config = tmp_path / "hotgauge.toml"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        config.write_text(
            f'[plc]\nport = {taken.getsockname()[1]}\nwrites = "all"\nstate_directory = "state"\n[sizing]\n'
            f'rig = "absent.json"\nmemory_max_mb = 65536\n[sizing.camera]\nkind = "recording"\npath = "absent"\n'
        )
        code, verdicts = doctor("--config", config)
    assert code == 1
    assert {name for name, verdict in verdicts.items() if verdict == "BAD"} >= {"rig", "cameras", "port", "disk"}
    config.write_text("[plc]\nprot = 1\n")
    assert doctor("--config", config) == (1, {"settings": "BAD"})


def test_a_gauge_that_runs_is_no_trouble_for_the_doctor(manager):
    manager.hear_until("STATUS=measuring", 30)
    _, verdicts = doctor("--config", manager.config)
    assert verdicts["port"] == "good"


@pytest.mark.parametrize("name", ["hot gauge", "50% steel"])
def test_an_interpreter_in_a_folder_of_any_name_is_started(tmp_path, monkeypatch, name):
    interpreter = tmp_path / name / "python"
    interpreter.parent.mkdir()
    interpreter.symlink_to(sys.executable)
    monkeypatch.setattr(sys, "executable", str(interpreter))
    list(install(tmp_path))
    said = subprocess.run(["systemd-analyze", "verify", tmp_path / UNIT], capture_output=True, text=True, check=False)
    assert said.stdout + said.stderr == ""


@pytest.mark.parametrize("name", ['a "quoted" one', "back\\slash", "mill's"])
def test_an_interpreter_that_systemd_would_not_start_is_refused(tmp_path, monkeypatch, name):
    monkeypatch.setattr(sys, "executable", str(tmp_path / name / "python"))
    with pytest.raises(InstallError, match="systemd starts no program with"):
        list(install(tmp_path))
    assert not (tmp_path / UNIT).exists()


def test_settings_in_another_encoding_are_kept_and_no_trouble_of_removing(tmp_path):
    list(install(tmp_path))
    config = tmp_path / "etc/hotgauge/hotgauge.toml"
    config.write_bytes("# Walzstraße\n".encode("latin-1"))
    assert any(str(config) in line for line in remove(tmp_path))
    assert config.exists()
