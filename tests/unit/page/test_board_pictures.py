"""Board pictures through the page: one program at a time, its words as they come, an end when it is asked for."""

import sys
import time

import pytest
from page_client import Gauge, client_of, log_in

from appliance.page.board_pictures import LINES_KEPT, BoardPictures, BoardPicturesError
from plc.security.roles import Role

PYTHON = sys.executable  # which the tests replace

# says what it was asked for and how it goes on, until it is stopped as by Ctrl-C
PROGRAM = """
import sys, time
try:
    print("asked for", *sys.argv[3:], flush=True)
    print("0 of 15 poses; left: blurred, edges 6.1 px wide: focus, and hold the board still", flush=True)
    time.sleep(30)
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


@pytest.fixture(autouse=True)
def program(monkeypatch, tmp_path):
    file = tmp_path / "hotgauge"
    file.write_text(f"#!{PYTHON}\n{PROGRAM}")
    file.chmod(0o700)
    monkeypatch.setattr(sys, "executable", str(file))
    return file


def wait(wanted) -> None:
    until_s = time.monotonic() + 20
    while not wanted():
        assert time.monotonic() < until_s
        time.sleep(0.01)


def test_an_engineer_reads_the_judgement_as_it_comes_and_stops_it_and_nobody_else(tmp_path):
    gauge = Gauge(tmp_path)
    pictures = gauge.commissioning.board_pictures
    form = {"folder": "monday", "what": "boards", "squares": "8x5", "square": "49,8"}
    operator = log_in(client_of(gauge), Role.OPERATOR)
    assert operator.post("/commission/capture", data=form | {"token": operator.token}).status_code == 403
    assert operator.get("/live/commission").status_code == 403
    engineer = log_in(client_of(gauge), Role.ENGINEER)
    form["token"] = engineer.token
    assert engineer.post("/commission/capture", data=form | {"token": "x"}).status_code == 403
    assert not pictures.running
    assert engineer.post("/commission/capture", data=form).status_code == 303
    wait(lambda: len(pictures.lines) == 2)
    text = engineer.get("/live/commission").text
    assert f"capture boards --output {tmp_path}/commissioning/monday --squares 8x5 --mm 49.8" in text
    assert "blurred, edges 6.1 px wide" in text
    assert "stop that first" in engineer.post("/commission/capture", data=form).text

    assert engineer.post("/commission/stop", data=form).status_code == 303
    wait(lambda: not pictures.running)
    wait(lambda: pictures.lines[-1] == "stopped")
    assert "Go on with monday" in engineer.get("/live/commission").text


@pytest.mark.parametrize("name", ["", "..", "a/b", "/etc", "-x", "a b", "x" * 41])
def test_a_folder_has_a_name_and_is_never_a_path(tmp_path, name):
    with pytest.raises(BoardPicturesError, match="no name of a folder"):
        BoardPictures(tmp_path, None).begin(name, "boards", "8x5", 50.0)


@pytest.mark.parametrize(("what", "squares"), [("boards", "8"), ("boards", "8x5 --config /etc/x"), ("middle", "8x5")])
def test_a_board_that_is_none_is_refused(tmp_path, what, squares):
    with pytest.raises(BoardPicturesError, match="give its squares"):
        BoardPictures(tmp_path, None).begin("monday", what, squares, 50.0)


def test_the_registration_board_is_taken_at_its_height_from_the_cameras_of_the_settings(tmp_path):
    pictures = BoardPictures(tmp_path, tmp_path / "hotgauge.toml")
    pictures.begin("monday", "high", "", 200.0)
    wait(lambda: pictures.lines)
    pictures.stop()
    wait(lambda: pictures.lines[-1] == "stopped")
    assert pictures.lines[0].endswith(
        f"capture registration --output {tmp_path}/monday --height high --high-mm 200 --config {tmp_path}/hotgauge.toml"
    )


def test_of_many_lines_the_last_are_kept(program, tmp_path):
    program.write_text(f"#!{PYTHON}\nfor number in range(100): print('line', number)\n")
    pictures = BoardPictures(tmp_path, None)
    pictures.begin("monday", "boards", "8x5", 50.0)
    wait(lambda: not pictures.running and pictures.lines[-1:] == ["line 99"])
    assert len(pictures.lines) == LINES_KEPT


def test_the_page_says_what_the_line_still_needs(tmp_path):
    gauge = Gauge(tmp_path)
    engineer = log_in(client_of(gauge), Role.ENGINEER)
    text = engineer.get("/commission").text
    assert "No calibration in use yet" in text
    assert "ingot.references is not set" in text
    assert "nothing yet" in text
    (tmp_path / "rig.json").write_text('{"region_y_mm": [-250.0, 180.5]}')
    text = engineer.get("/commission").text
    assert "-250 to 180.5 mm" in text
    assert "123.456" in text
    assert "305419896" in text
    assert text.count("not set") == 4  # target, both tolerances, references
