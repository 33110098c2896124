"""Planted troubles, each named by `doctor`, and by `check-config` if they keep `run` from starting."""

import contextlib
import hashlib
import shutil
import socket
import sqlite3
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from running import free_port

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.cli.main import main
from appliance.history import database
from appliance.service import checks
from appliance.service.checks import FOR_GOOD_WORK, FOR_THE_START
from appliance.simulation.write_recording import write_ingots
from appliance.sizing.stereo.rig_file import save_rig
from appliance.supervisor.settings import load
from plc.security.certificates import Authority


class Planted:
    """A good installation in a folder, and its settings file; a trouble changes either."""

    def __init__(self, folder: Path, line: Path) -> None:
        self.folder = folder
        shutil.copytree(line, folder, dirs_exist_ok=True)
        self.port = free_port()
        self.metrics_port = free_port()
        self.more = ""

    @property
    def config(self) -> Path:
        file = self.folder / "hotgauge.toml"
        file.write_text(
            f"""
[plc]
port = {self.port}
writes = "all"
state_directory = "state"
[sizing]
rig = "rig.json"
black_box.directory = "boxes"
[sizing.camera]
kind = "recording"
path = "recording"
[ingot]
references = "ingots"
[ingot.camera]
kind = "recording"
path = "ingots/seq01"
[history]
directory = "history"
[metrics]
port = {self.metrics_port}
{self.more}
""",
            encoding="utf-8",
        )
        return file

    def bad(self) -> dict[str, str]:
        settings = load(self.config)
        found = [check(settings) for check in (*FOR_THE_START, *FOR_GOOD_WORK)]
        return {check.name: check.text for check in found if check.verdict == "BAD"}


@pytest.fixture(scope="module")
def line(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("line")
    save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), folder / "rig.json")
    for side in ("left", "right"):
        (folder / "recording" / side).mkdir(parents=True)
    write_ingots(folder / "ingots", "clean", 1, 2)
    picture = next((folder / "ingots/seq01").glob("*.jpg"))
    for side in ("left", "right"):
        shutil.copy(picture, folder / "recording" / side / "000000.jpg")
    return folder


@pytest.fixture
def planted(tmp_path, line) -> Planted:
    return Planted(tmp_path, line)


def test_a_good_installation_has_no_trouble_and_check_config_says_so(planted, capsys):
    assert planted.bad() == {}
    assert main(["check-config", str(planted.config)]) == 0
    assert ": good;" in capsys.readouterr().out


def test_a_rig_whose_bars_may_be_of_any_shape_gets_a_note_until_the_ovality_is_set(planted):
    sizing = load(planted.config).sizing
    unset = sizing.check_scale()
    assert (unset.verdict, "sizing.ovality_mm is not set" in unset.text) == ("note", True)
    assert sizing.model_copy(update={"ovality_mm": 0.4}).check_scale().verdict == "good"


def rig_broken(planted: Planted) -> None:
    (planted.folder / "rig.json").write_text("{}")


def recording_away(planted: Planted) -> None:
    shutil.rmtree(planted.folder / "recording/right")


def ingot_recording_away(planted: Planted) -> None:
    shutil.rmtree(planted.folder / "ingots/seq01")


def reference_away(planted: Planted) -> None:
    (planted.folder / "ingots/bottom.png").unlink()


def state_is_a_file(planted: Planted) -> None:
    (planted.folder / "state").write_text("a file")


def history_is_newer(planted: Planted) -> None:
    (planted.folder / "history").mkdir()
    with contextlib.closing(sqlite3.connect(planted.folder / "history" / database.FILE_NAME)) as connection:
        connection.execute("PRAGMA user_version = 99")


def history_is_rubbish(planted: Planted) -> None:
    (planted.folder / "history").mkdir()
    (planted.folder / "history" / database.FILE_NAME).write_bytes(b"rubbish " * 1000)


def boxes_are_a_file(planted: Planted) -> None:
    (planted.folder / "boxes").write_text("a file")


def certificates_broken(planted: Planted) -> None:
    for name in ("server.pem", "server.key", "authority.pem"):
        (planted.folder / name).write_text("no certificate")
    planted.more = '[plc.tls]\ncertificate = "server.pem"\nkey = "server.key"\nauthority = "authority.pem"\n'


def mqtt_authority_away(planted: Planted) -> None:
    planted.more = '[mqtt]\nhost = "10.0.0.9"\nauthority = "absent.pem"\n'


FILES: dict[Callable[[Planted], None], tuple[str, str]] = {
    rig_broken: ("rig", "rig.json"),
    recording_away: ("recordings", "sizing.camera"),
    ingot_recording_away: ("recordings", "ingot.camera"),
    reference_away: ("references", "bottom.png"),
    state_is_a_file: ("disk", "state"),
    history_is_newer: ("history", "newer version"),
    history_is_rubbish: ("history", "not a database"),
    boxes_are_a_file: ("blackbox", "boxes"),
    certificates_broken: ("tls", "server.pem"),
    mqtt_authority_away: ("delivery", "absent.pem"),
}


@pytest.mark.parametrize("plant", FILES, ids=lambda plant: plant.__name__)
def test_a_planted_trouble_is_named_and_no_other(planted, plant, capsys):
    plant(planted)
    name, said = FILES[plant]
    bad = planted.bad()
    assert bad.keys() == {name}
    assert said in bad[name]
    refuses = name in {"rig", "recordings", "references", "tls"}  # without the others `run` starts, with a fault
    assert main(["check-config", str(planted.config)]) == (2 if refuses else 0)
    assert (said in capsys.readouterr().err) == refuses


def test_a_known_error_of_another_calibration_is_named(planted, capsys):
    digest = "5e" * 32
    known = 'expanded_mm = 0.03\ndate = "2026-11-28"\nreason = "master 250.00"\nwho = "A. Smith"\n'
    planted.more = f'[sizing.adjustment]\nadded_mm = -0.12\n{known}calibration_sha256 = "{digest}"\n'
    assert planted.bad().keys() == {"rig"}
    assert main(["check-config", str(planted.config)]) == 2
    assert "sizing.adjustment.added_mm is -0.12" in capsys.readouterr().err
    planted.more = planted.more.replace(digest, hashlib.sha256((planted.folder / "rig.json").read_bytes()).hexdigest())
    assert not planted.bad()


def test_a_certificate_that_ends_soon_is_a_note_and_stops_nothing(planted):
    authority = Authority.make()
    authority.save(planted.folder)
    authority.server(planted.folder, ["127.0.0.1"], days=20)
    planted.more = '[plc.tls]\ncertificate = "server.pem"\nkey = "server.key"\nauthority = "authority.pem"\n'
    assert not planted.bad()
    said = checks.secure_port(load(planted.config))
    assert (said.verdict, "expires on" in said.text) == ("note", True)
    assert main(["check-config", str(planted.config)]) == 0


@pytest.mark.parametrize("name", ["port", "delivery"])
def test_a_port_that_another_program_has_is_named(planted, name):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]
        if name == "port":
            planted.port = number
        else:
            planted.metrics_port = number
        bad = planted.bad()
    assert bad.keys() == {name}
    assert str(number) in bad[name]


def test_too_little_memory_for_both_stations_is_named(planted, monkeypatch):
    monkeypatch.setattr(checks.os, "sysconf", lambda name: 4096 if name == "SC_PAGE_SIZE" else (3000 << 20) // 4096)
    assert planted.bad().keys() == {"memory"}


def test_a_clock_that_was_never_set_is_named(planted, monkeypatch):
    monkeypatch.setattr(checks.time, "gmtime", lambda: time.struct_time((1970, 1, 1, 0, 0, 0, 3, 1, 0)))
    assert "1970" in planted.bad()["clock"]


def test_a_library_of_a_wrong_version_or_none_is_named(planted, monkeypatch):
    wanted = ["numpy<2.6,>=1.0", "pydantic<2.0,>=1.0", "absent-library>=1", "ruff<0.1; extra == 'dev'"]
    monkeypatch.setattr(checks.importlib.metadata, "requires", lambda _: wanted)
    text = planted.bad()["versions"]
    assert "pydantic" in text
    assert "absent-library is missing" in text
    assert "numpy" not in text
    assert "ruff" not in text
