"""Commissioning: what was done stays done, and nothing is applied that was not verified and confirmed."""

import json
import threading
import time

import pytest
from page_client import Gauge, client_of, log_in

from appliance.files.runtime_folder import RUNTIME_VARIABLE, was_asked_for_reload
from appliance.page import commissioning
from appliance.page.commissioning import CANDIDATE, Commissioning, CommissioningError
from plc.security.roles import Role


class Commands:
    """The commands of `hotgauge`, as quick as a test wants them."""

    def __init__(self) -> None:
        self.said: list[list[str]] = []
        self.codes = {"calibrate": 0, "verify": 0}
        self.goes_on = threading.Event()
        self.goes_on.set()

    def __call__(self, words) -> tuple[int, str]:
        self.said.append([str(word) for word in words])
        self.goes_on.wait(10)
        if words[0] == "calibrate":
            words[3].write_text(f"rig {len(self.said)}")
        return self.codes[words[0]], f"report of {words[0]}"


@pytest.fixture
def commands(monkeypatch) -> Commands:
    commands = Commands()
    monkeypatch.setattr(commissioning, "_run", commands)
    return commands


@pytest.fixture
def work(tmp_path) -> Commissioning:
    (tmp_path / "boards" / "monday" / "calibration").mkdir(parents=True)
    (tmp_path / "boards" / "master").mkdir()
    (tmp_path / "rig.json").write_text("old rig")
    return Commissioning(tmp_path / "boards", tmp_path / "rig.json", None)


def done(work: Commissioning) -> None:
    until_s = time.monotonic() + 5
    while work.running and time.monotonic() < until_s:
        time.sleep(0.01)
    assert work.running is None


def test_a_calibration_is_verified_confirmed_and_logged_and_the_old_one_kept(work, commands, tmp_path, monkeypatch):
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path))
    work.calibrate("monday", "anna")
    done(work)
    work.verify("monday", "anna", "master", 120.05, 0.02)
    done(work)
    assert commands.said[1][:4] == [
        "verify",
        str(work.folder / "master"),
        "--rig",
        str(work.folder / "monday" / CANDIDATE),
    ]
    assert commands.said[1][-4:] == ["--diameter", "120.05", "--u", "0.02"]
    assert work.rig.read_text() == "old rig"
    kept = work.confirm("monday", "berta")
    assert (work.rig.read_text(), kept.read_text()) == ("rig 1", "old rig")
    assert was_asked_for_reload()
    assert not was_asked_for_reload()
    (row,) = work.log()
    assert (row["who"], row["folder"], row["kept"]) == ("berta", "monday", str(kept))
    assert len(row["sha256"]) == 64


def test_it_goes_on_after_a_restart_of_the_page(work, commands):
    work.calibrate("monday", "anna")
    done(work)
    again = Commissioning(work.folder, work.rig, None)
    assert again.steps("monday")["calibrated"].who == "anna"
    again.verify("monday", "anna", "master", 120.0, 0.0)
    done(again)
    assert again.steps("monday")["verified"].ok


@pytest.mark.parametrize("fails", ["calibrate", "verify"])
def test_what_has_not_passed_cannot_be_confirmed(work, commands, fails):
    commands.codes[fails] = 1
    work.calibrate("monday", "anna")
    done(work)
    if fails == "verify":
        work.verify("monday", "anna", "master", 120.0, 0.0)
        done(work)
    assert "report" in work.steps("monday")[{"calibrate": "calibrated", "verify": "verified"}[fails]].report
    with pytest.raises(CommissioningError, match="not verified"):
        work.confirm("monday", "anna")
    assert work.rig.read_text() == "old rig"


def test_a_new_calibration_or_another_file_makes_the_verification_void(work, commands):
    for change in (
        lambda: work.calibrate("monday", "anna"),
        lambda: (work.folder / "monday" / CANDIDATE).write_text("x"),
    ):
        work.calibrate("monday", "anna")
        done(work)
        work.verify("monday", "anna", "master", 120.0, 0.0)
        done(work)
        change()
        done(work)
        with pytest.raises(CommissioningError, match="not verified"):
            work.confirm("monday", "anna")


def test_one_step_at_a_time(work, commands):
    commands.goes_on.clear()
    work.calibrate("monday", "anna")
    with pytest.raises(CommissioningError, match="still being worked on"):
        work.calibrate("monday", "anna")
    commands.goes_on.set()
    done(work)


@pytest.mark.parametrize("name", ["..", "../boards/monday", "monday/", "/etc", "", "master", "link"])
def test_a_name_is_one_of_the_list_and_never_a_path(work, commands, name):
    (work.folder / "link").symlink_to(work.folder / "monday")
    with pytest.raises(CommissioningError, match="no such folder"):
        work.calibrate(name, "anna")
    assert commands.said == []


def test_an_engineer_works_through_the_page_and_nobody_else(tmp_path, commands):
    gauge = Gauge(tmp_path)
    (tmp_path / "commissioning" / "monday" / "calibration").mkdir(parents=True)
    operator = log_in(client_of(gauge), Role.OPERATOR)
    assert operator.get("/commission").status_code == 403
    form = {"token": operator.token, "folder": "monday"}
    assert operator.post("/commission/calibrate", data=form).status_code == 403
    engineer = log_in(client_of(gauge), Role.ENGINEER)
    form = {"token": engineer.token, "folder": "monday"}
    assert engineer.post("/commission/calibrate", data=form).status_code == 303
    done(gauge.commissioning)
    text = engineer.get("/commission").text
    assert "report of calibrate" in text
    assert "engineer, 20" in text
    answer = engineer.post("/commission/confirm", data=form)
    assert answer.status_code == 409
    assert "not verified" in answer.text
    answer = engineer.post("/commission/verify", data=form | {"recording": "..", "diameter": "120", "expanded": "0"})
    assert "no such folder" in answer.text
    answer = engineer.post("/commission/verify", data=form | {"recording": "x", "diameter": "nan"})
    assert "no length" in answer.text
    assert len(commands.said) == 1


def test_a_broken_state_file_is_nothing_done(work):
    (work.folder / "monday" / "commissioning.json").write_text(json.dumps({"calibrated": {}})[:-1])
    assert work.steps("monday") == {}
