"""What strangers type, and the one sentence that helps them on."""

import io
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from appliance.cli import main as cli

MISTAKES = [
    ("verify bar --rig rig.json --diameter 250mm", "--diameter: '250mm' is no number of millimetres"),
    ("run gauge.toml", "settings are given as --config gauge.toml"),
    ("simulate --output s --frames 1.5", "--frames: '1.5' is no whole number from 1"),
    ("simulate --output s --frames 99999999999999999999", "is no whole number from 1"),
    ("simulate --output s --scene fog", "--scene: 'fog' is not a condition"),
    ("simulate --output s --scene clean --effect fog", "--effect: 'fog' is not an effect"),
    ("poll 127.0.0.1 --interval 0", "--interval: '0' is no number of seconds from 0.01"),
    ("poll 127.0.0.1 --interval nan", "--interval: 'nan' is no number of seconds"),
    ("poll no-such-host.invalid", "no host of this name is known here"),
    ("poll 127.0.0.1 --port 99999", "--port: 99999 is not within 1 to 65535"),
    ("poll 127.0.0.1 --port x", "--port: no whole number: 'x'"),
    ("calibrate rig/calibration --output r.json", "give the folder above it, rig"),
    ("calibrate rig --output r.json --region 5 x", "--region: no number: 'x'"),
    ("measure rec --rig other.json --output o.csv", "no usable rig file: format_version: missing"),
    ("plan --sensor 2448,2048 --pixel-um 3 --focal-mm 25 --distance-m 3", "'2448,2048' is no sensor; give it as 2448x"),
    ("plan --sensor 640x512 --pixel-um 3,45 --focal-mm 25 --distance-m 3", "--pixel-um: '3,45' is no number above 0"),
    (
        "plan --sensor 640x512 --pixel-um 3 --focal-mm 25 --distance-m 3 --region 5 -5",
        "--region: from 5 to -5 is no region; give the smaller number first",
    ),
    ("measure rec other.json --output o.csv", "measure knows no other.json; options begin with dashes"),
    ("measure Stange 1 --rig r --output o.csv", "a name with blanks stands in quotes; see `hotgauge measure --help`"),
    ("measure rec --rig rig --output o.csv", "rig: cannot be read (Is a directory); give a file, not a folder"),
    ("measure rec --rig other.json --output .csv", ".csv is a suffix without a name"),
    ("measure rec --rig other.json --output o.csv --ovality 0,4", "'0,4' is no number of millimetres from 0"),
    ("measure rec --rig other.json --output o.csv --ovality 0,4", "decimals have a point: 0.4"),
    ("orient rig --references other.json --output o.csv", "other.json: is a file; give the folder with top.png"),
    (
        "orient rig --references rig --output o.csv --use 3",
        "there is no pair 3; learned are none, 0 is the commissioned",
    ),
    (
        "orient rig --references rig --output o.csv",
        "rig/top.png: cannot be read (No such file or directory); check its name",
    ),
    ("fuse rig rig --rig other.json --output f.png", "other.json: no usable rig file"),
    ("check-config --config gauge.toml", "give the file alone: hotgauge check-config FILE"),
    ("check-config latin.toml", "latin.toml: not a text in UTF-8; save it in that encoding"),
    ("check-config comma.toml", "(at line 2, column 16); decimals have a point: 250.5"),
    ("check-config rig", "rig: Is a directory; give a file, not a folder"),
    (
        "verify rig --rig none.json --diameter 250",
        "none.json: cannot be read (No such file or directory); make it with",
    ),
    ("gauge-study study.csv", "study.csv: its cells are parted by semicolons; save it with commas"),
    ("calibrate rig --output r.json --squares 8x5", "expected 2 arguments, with a blank between them"),
    ("calibrate other.json --output r.json", "other.json: is a file; give the rig folder, with pictures of the board"),
    ("certificates --output keys --client hmi --role admin", "(choose from 'viewer', 'operator', 'engineer')"),
    ("page-user anna --role boss", "(choose from 'viewer', 'operator', 'engineer')"),
    ("reproduce --output report --recordings rig", "rig: holds no recordings of ingots, ingot_line or ingot_line_b"),
    ("registers csv", "registers knows no csv; options begin with dashes"),
    ("gauge-study a\nb", "a\\nb: No such file"),
    ("gauge-study other.json", "has no column bar; it needs the columns bar, condition, diameter_mm"),
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "rig" / "calibration").mkdir(parents=True)
    (tmp_path / "rig" / "board.json").write_text(json.dumps({"squares": [8, 5], "square_mm": 50}))
    (tmp_path / "other.json").write_text('{"a":\n1}\n')
    (tmp_path / "latin.toml").write_bytes("# Straße\n".encode("latin-1"))
    (tmp_path / "comma.toml").write_text("[sizing.set_points]\ntarget_mm = 250,5\n")
    (tmp_path / "study.csv").write_text("bar;condition;diameter_mm\n1;1;100,1\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("words", "helps"), MISTAKES, ids=[words for words, _ in MISTAKES])
def test_a_mistake_is_answered_by_a_sentence_that_helps(folder, words, helps, capsys):
    try:
        code = cli.main(words.split(" "))
    except SystemExit as left:
        code = left.code
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert helps in err
    assert {file.name for file in folder.iterdir()} == {"rig", "other.json", "latin.toml", "comma.toml", "study.csv"}


KEPT_FROM_US = [
    "check-config kept.toml",
    "gauge-study kept.toml",
    "measure rec --rig kept.toml --output o.csv",
    "verify rec --rig kept.toml --diameter 250",
    "compare kept.toml rec",
    "compare rows.jsonl kept.toml",
]


@pytest.mark.parametrize("words", KEPT_FROM_US)
def test_a_file_that_this_user_may_not_read_is_called_so(folder, words, capsys, monkeypatch):
    refuse_to_open("kept.toml", monkeypatch)
    (folder / "rows.jsonl").write_text('{"frame": 0, "diameter_mm": 1.0}')
    assert cli.main(words.split(" ")) == 2
    assert re.search(
        r"kept\.toml: (cannot be read \()?Permission denied\)?; let this user read it\n", capsys.readouterr().err
    )


def refuse_to_open(name: str, monkeypatch) -> None:
    """Refuse a file to this process as the system does to a user without the right, whoever runs the tests."""
    real = io.open

    def opened(file, *rest, **more):
        if Path(str(file)).name == name:
            raise PermissionError(13, "Permission denied", str(file))
        return real(file, *rest, **more)

    monkeypatch.setattr(io, "open", opened)


def test_a_folder_that_has_gone_is_named_as_the_cause(tmp_path):
    (tmp_path / "gone").mkdir()
    shell = 'cd "$1" && rmdir "$1" && exec "$0" -m appliance measure rec --rig rig.json --output out.csv'
    words = ["sh", "-c", shell, sys.executable, str(tmp_path / "gone")]
    done = subprocess.run(words, capture_output=True, check=False, text=True, timeout=60)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "no longer there" in done.stderr
