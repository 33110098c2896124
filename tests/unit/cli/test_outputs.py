"""Outputs that would destroy what a command reads are refused, and so are names that promise another format."""

import os
import subprocess
import sys

import pytest

from appliance.cli import main as cli


@pytest.fixture
def recording(tmp_path):
    for side in ("left", "right"):
        (tmp_path / "rec" / side).mkdir(parents=True)
        (tmp_path / "rec" / side / "000000.jpg").write_bytes(b"a picture")
    (tmp_path / "rec" / "board.json").write_text("{}")
    (tmp_path / "rec" / "roi.json").write_text("{}")
    (tmp_path / "rig.json").write_text("a calibration")
    return tmp_path


@pytest.mark.parametrize(
    "words",
    [
        ["measure", "rec", "--rig", "rig.json", "--output", "rig.json"],
        ["measure", "rec", "--rig", "rig.json", "--output", "./rec/../rig.json"],
        ["calibrate", "rec", "--output", "rec/board.json"],
        ["calibrate", "rec", "--output", "rec/left/000000.jpg"],
        ["orient", "rec", "--references", "rec", "--output", "rec/roi.json"],
        ["fuse", "rec/left/000000.jpg", "rec/right/000000.jpg", "--rig", "rig.json", "--output", "rec/left/000000.jpg"],
    ],
)
def test_an_output_that_is_read_by_the_command_is_refused_and_untouched(recording, words, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    before = {file: file.read_bytes() for file in recording.rglob("*") if file.is_file()}
    assert cli.main(words) == 2
    assert "would be lost; give another file" in capsys.readouterr().err
    assert {file: file.read_bytes() for file in recording.rglob("*") if file.is_file()} == before


@pytest.mark.parametrize(
    "words",
    [
        ["measure", "rec", "--rig", "rig.json", "--output", "out.csv", "--plot", "rec/left"],
        ["measure", "rec", "--rig", "rig.json", "--output", "out.csv", "--plot", "rec"],
        ["orient", "rec/left", "--references", "rec", "--output", "out.csv", "--plot", "rec/left/../left"],
        ["orient", "rec/left", "--references", "rec", "--output", "out.csv", "--plot", "rec"],
        ["fuse", "rec/left/000000.jpg", "rec/right/000000.jpg", "--rig=rig.json", "--output=f.png", "--plot=rec/left"],
    ],
)
def test_plots_never_come_among_the_pictures_that_are_read(recording, words, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    before = {file: file.read_bytes() for file in recording.rglob("*") if file.is_file()}
    assert cli.main(words) == 2
    assert "holds pictures that this command reads; give another folder" in capsys.readouterr().err
    assert {file: file.read_bytes() for file in recording.rglob("*") if file.is_file()} == before


def test_a_file_where_a_folder_of_plots_is_wanted_is_called_one(recording, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    assert cli.main(["measure", "rec", "--rig", "rig.json", "--output", "out.csv", "--plot", "rig.json"]) == 2
    assert "--plot: rig.json is a file; give a folder" in capsys.readouterr().err


def test_the_plot_of_a_comparison_never_replaces_a_picture_of_the_recording(recording, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    (recording / "rec" / "left" / "000001.png").write_bytes(b"a picture")
    assert cli.main(["compare", "readings.jsonl", "rec", "--plot", "rec/left/000001.png"]) == 2
    assert "--plot: rec/left/000001.png is read by this command and would be lost" in capsys.readouterr().err
    assert (recording / "rec" / "left" / "000001.png").read_bytes() == b"a picture"


@pytest.mark.parametrize(
    "words",
    [
        ["measure", "rec", "--rig", "rig.json", "--output", "out.csv", "--plot", "plots"],
        ["measure", "rec/left", "--method", "conveyor", "--barrier-mm=500", "--output=out.csv", "--plot", "plots"],
        ["plan", "--sensor=640x512", "--pixel-um=10", "--focal-mm=25", "--distance-m=3", "--output=mounting.png"],
    ],
)
def test_a_plotting_library_that_is_missing_is_named_before_any_work(recording, words, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert cli.main(words) == 2
    assert "plots need Matplotlib, which is not installed; install it with: pip install" in capsys.readouterr().err
    assert not list(recording.glob("out.csv"))


def test_a_link_to_an_input_is_that_input(recording, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    os.link("rig.json", "readings.jsonl")
    assert cli.main(["measure", "rec", "--rig", "rig.json", "--output", "readings.jsonl"]) == 2
    assert "would be lost" in capsys.readouterr().err


def test_a_device_or_a_pipe_is_never_replaced_by_an_output(recording, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    os.mkfifo("out.csv")
    assert cli.main(["measure", "rec", "--rig", "rig.json", "--output", "out.csv"]) == 2
    assert "--output: out.csv is a device or a pipe; give the name of a file" in capsys.readouterr().err
    assert (recording / "out.csv").is_fifo()


@pytest.mark.parametrize("name", ["x.xlsx", "-", "readings.feather"])
def test_a_name_that_promises_another_format_is_refused(recording, name, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    assert cli.main(["measure", "rec", "--rig", "rig.json", f"--output={name}"]) == 2
    assert "end in .csv or .jsonl" in capsys.readouterr().err
    assert not (recording / name).exists()


def run(*words: str, stdout: int | None = subprocess.PIPE, **environment: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "appliance", *words],
        stdout=stdout,
        stderr=subprocess.PIPE,
        env=os.environ | environment,
        check=False,
        text=True,
        timeout=60,
    )


def test_a_full_disk_behind_standard_output_is_one_sentence():
    with open("/dev/full", "w") as full:  # noqa: PTH123  a descriptor is wanted
        done = run("registers", stdout=full.fileno())
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "hotgauge: the output cannot be written: No space left on device; make room, or write elsewhere"
    ]


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_standard_streams_are_no_trouble(closed, tmp_path):
    config = tmp_path / "gauge.toml"
    config.write_text("[plc]\nport = 5021\n")
    shell = f'exec "$0" -m appliance check-config "$1" {closed}'
    done = subprocess.run(
        ["sh", "-c", shell, sys.executable, str(config)], capture_output=True, check=False, text=True, timeout=60
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_a_terminal_without_utf8_gets_escapes_and_no_traceback():
    done = run("registers", PYTHONIOENCODING="ascii")
    assert done.returncode == 0
    assert r"\xb0C" in done.stdout


def test_a_recording_of_no_frames_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit):
        cli.main(["simulate", "--output", str(tmp_path / "rec"), "--frames", "0"])
    assert "--frames" in capsys.readouterr().err
    assert not (tmp_path / "rec").exists()


def test_settings_with_a_byte_order_mark_are_read(tmp_path, capsys):
    config = tmp_path / "gauge.toml"
    config.write_bytes(b"\xef\xbb\xbf[plc]\nport = 5021\n")
    assert cli.main(["check-config", str(config)]) == 0
    assert "plc.port = 5021" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words",
    [
        ["measure", "rec", "--rig", "rig.json", "--output", "absent/out.csv"],
        ["calibrate", "rec", "--output", "absent/rig.json"],
        ["calibrate", "rec", "--output", "."],
        ["orient", "rec/left", "--references", "rec", "--output", "absent/out.csv"],
        ["verify", "rec", "--rig", "rig.json", "--diameter", "250", "--output", "absent/page.pdf"],
        ["fuse", "rec/left/000000.jpg", "rec/right/000000.jpg", "--rig", "rig.json", "--output", "absent/out.png"],
        ["plan", "--sensor=64x64", "--pixel-um=20", "--focal-mm=25", "--distance-m=3", "--output", "absent/out.png"],
    ],
)
def test_an_output_that_cannot_be_written_is_named_before_any_work(recording, words, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    assert cli.main(words) == 2
    said = capsys.readouterr().err
    assert said.startswith("hotgauge: --output: ")
    assert "there is no folder absent; make it" in said or "is a folder; give the name of a file in it" in said


def test_a_certificate_never_replaces_the_rig_that_it_is_about(recording, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    (recording / "rig.html").write_text("a calibration under a strange name")
    words = ["verify", "rec", "--rig", "rig.html", "--diameter", "250", "--output", "rig.html"]
    assert cli.main(words) == 2
    assert "would be lost" in capsys.readouterr().err


def test_a_model_never_replaces_a_rig_by_its_record(recording, capsys, monkeypatch):
    monkeypatch.chdir(recording)
    assert cli.main(["train-edges", "--output", "rig.npz"]) == 2
    assert "rig.json: would be replaced" in capsys.readouterr().err
    assert (recording / "rig.json").read_text() == "a calibration"
