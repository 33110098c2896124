"""Commissioning: what was done stays done, and nothing is applied that was not verified and confirmed."""

import json
import os
import sys
import threading
import time
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import pytest
from page_client import Gauge, client_of, log_in

from appliance.files import reload_request
from appliance.files.reload_request import STATE_VARIABLE, was_asked_for_reload
from appliance.files.runtime_folder import RUNTIME_VARIABLE
from appliance.page import commissioning
from appliance.page.commissioning import CANDIDATE, LOG_FILE, Commissioning, CommissioningError
from appliance.sizing.adjustment import Adjustment
from plc.security.roles import Role

DECIDED = {"expanded_mm": 0.03, "date": "2026-11-28", "reason": "master 120.00", "who": "A. Smith"}


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


class RunningGauge:
    """Looks for requests as a gauge does, a hundred times a second."""

    def __init__(self) -> None:
        self.reloads = 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._ended.wait(0.01):
            self.reloads += was_asked_for_reload()

    def stop(self) -> None:
        self._ended.set()
        self._thread.join()


@pytest.fixture(autouse=True)
def gauge(tmp_path, monkeypatch) -> Iterator[RunningGauge]:
    """The page's own folders, as systemd gives them: the state directory is writable, the gauge's runtime is not."""
    (tmp_path / "state").mkdir()
    monkeypatch.setenv(STATE_VARIABLE, str(tmp_path / "state"))
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "absent"))
    monkeypatch.setattr(reload_request, "HEARD_WITHIN_S", 1.0)
    gauge = RunningGauge()
    yield gauge
    gauge.stop()


@pytest.fixture
def work(tmp_path) -> Commissioning:
    (tmp_path / "boards" / "monday" / "calibration").mkdir(parents=True)
    (tmp_path / "boards" / "master").mkdir()
    (tmp_path / "rig.json").write_text("old rig")
    return Commissioning(tmp_path / "boards", tmp_path / "rig.json", None, lambda _: "")


def done(work: Commissioning) -> None:
    until_s = time.monotonic() + 5
    while work.running and time.monotonic() < until_s:
        time.sleep(0.01)
    assert work.running is None


def test_a_calibration_is_verified_confirmed_and_logged_and_the_old_one_kept(work, commands, gauge):
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
    assert gauge.reloads == 1
    (row,) = work.log()
    assert (row["who"], row["folder"], row["kept"]) == ("berta", "monday", str(kept))
    assert len(row["sha256"]) == 64


def test_it_goes_on_after_a_restart_of_the_page(work, commands):
    work.calibrate("monday", "anna")
    done(work)
    again = Commissioning(work.folder, work.rig, None, lambda _: "")
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


def test_what_is_not_calibrated_cannot_be_verified(work, commands):
    with pytest.raises(CommissioningError, match="monday: not calibrated; calibrate first"):
        work.verify("monday", "anna", "master", 120.0, 0.0)
    commands.codes["calibrate"] = 1
    work.calibrate("monday", "anna")
    done(work)
    with pytest.raises(CommissioningError, match="monday: not calibrated; calibrate first"):
        work.verify("monday", "anna", "master", 120.0, 0.0)
    assert [words[0] for words in commands.said] == ["calibrate"]


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


def verified(work: Commissioning) -> Path:
    work.calibrate("monday", "anna")
    done(work)
    work.verify("monday", "anna", "master", 120.0, 0.0)
    done(work)
    return work.folder / "monday" / CANDIDATE


@pytest.mark.parametrize("unheard", ["no folder", "not writable", "nobody looks"])
def test_a_gauge_that_cannot_be_asked_to_read_the_new_calibration_is_told_to_the_engineer(
    work, commands, gauge, monkeypatch, unheard
):
    verified(work)
    state = Path(os.environ[STATE_VARIABLE])
    if unheard == "no folder":
        monkeypatch.delenv(STATE_VARIABLE)
        monkeypatch.delenv(RUNTIME_VARIABLE)
    elif unheard == "not writable":
        state.rmdir()
    else:
        gauge.stop()
    with pytest.raises(CommissioningError, match=r"could not be asked to read it .* systemctl reload hotgauge"):
        work.confirm("monday", "berta")
    assert work.rig.read_text() == "rig 1"
    assert [row["who"] for row in work.log()] == ["berta"]
    assert not list(state.glob("*"))


def test_a_log_that_cannot_be_written_leaves_the_gauge_asked_and_is_told(work, commands, gauge):
    verified(work)
    (work.folder / LOG_FILE).mkdir()
    with pytest.raises(CommissioningError, match=r"commissioning\.jsonl: Is a directory; .* not noted"):
        work.confirm("monday", "berta")
    assert gauge.reloads == 1


@pytest.mark.parametrize(
    "after", [lambda _: Adjustment(), lambda new: Adjustment(added_mm=0.1, **DECIDED, calibration_sha256=new)]
)
def test_a_known_error_of_the_calibration_from_before_is_taken_out_first(work, commands, after):
    verified(work)
    old, new = (sha256(content).hexdigest() for content in (b"old rig", b"rig 1"))
    in_the_file = [Adjustment(added_mm=-0.12, **DECIDED, calibration_sha256=old)]

    def refusal(digest: str) -> str:
        return in_the_file[-1].refusal(digest)

    again = Commissioning(work.folder, work.rig, None, refusal)
    with pytest.raises(CommissioningError, match=r"sizing.adjustment.added_mm is -0\.12, .* set it to 0"):
        again.confirm("monday", "berta")
    assert work.rig.read_text() == "old rig"
    in_the_file.append(after(new))
    again.confirm("monday", "berta")
    assert work.rig.read_text() == "rig 1"


def test_a_candidate_that_is_exchanged_while_it_is_verified_has_not_passed(work, commands):
    work.calibrate("monday", "anna")
    done(work)
    commands.goes_on.clear()
    work.verify("monday", "anna", "master", 120.0, 0.0)
    while len(commands.said) < 2:
        time.sleep(0.01)
    (work.folder / "monday" / CANDIDATE).write_text("another")
    commands.goes_on.set()
    done(work)
    assert "changed while it was verified" in work.steps("monday")["verified"].report
    with pytest.raises(CommissioningError, match="not verified"):
        work.confirm("monday", "anna")


def test_a_candidate_that_is_exchanged_before_it_is_read_is_not_confirmed(work, commands, monkeypatch):
    candidate = verified(work)
    steps = work.steps("monday")
    monkeypatch.setattr(work, "steps", lambda _: steps)
    candidate.write_text("another")
    with pytest.raises(CommissioningError, match="not the one that was verified"):
        work.confirm("monday", "anna")
    assert work.rig.read_text() == "old rig"


def test_nothing_is_confirmed_while_a_step_is_being_worked_on(work, commands):
    verified(work)
    commands.goes_on.clear()
    work.verify("monday", "anna", "master", 120.0, 0.0)
    with pytest.raises(CommissioningError, match="still being worked on"):
        work.confirm("monday", "anna")
    commands.goes_on.set()
    done(work)


def test_a_torn_line_of_the_log_hides_no_other(work, commands):
    verified(work)
    work.confirm("monday", "anna")
    with (work.folder / LOG_FILE).open("ab") as file:
        file.write('{"when": "2026-11-29", "who": "J\u00f6'.encode()[:-1])
    assert [row["who"] for row in work.log()] == ["anna"]
    work.confirm("monday", "berta")
    assert [row["who"] for row in work.log()] == ["berta", "anna"]


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
    assert "--region" not in commands.said.pop()
    region = {"first": "-100", "last": "abc"}
    assert "no length" in engineer.post("/commission/calibrate", data=form | region).text
    assert engineer.post("/commission/calibrate", data=form | region | {"last": "150,5"}).status_code == 303
    done(gauge.commissioning)
    assert commands.said[0][-3:] == ["--region", "-100", "150.5"]
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


def test_a_step_that_the_kernel_ends_says_so(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "killed"))
    (tmp_path / "killed").write_text("#!/bin/sh\nkill -9 $$\n")
    (tmp_path / "killed").chmod(0o700)
    code, report = commissioning._run(["calibrate"])
    assert code != 0
    assert "signal 9" in report
    assert "fewer or smaller pictures" in report
