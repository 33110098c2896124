"""What strangers type, and the one sentence that helps them on."""

import json

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
    ("measure rec --rig rig --output o.csv", "rig: cannot be read (Is a directory); give the rig file"),
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
        "rig/top.png: cannot be read (No such file or directory); check its",
    ),
    ("fuse rig rig --rig other.json --output f.png", "other.json: no usable rig file"),
    ("check-config --config gauge.toml", "give the file alone: hotgauge check-config FILE"),
    ("check-config latin.toml", "latin.toml: not a text in UTF-8; save it in that encoding"),
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
    assert {file.name for file in folder.iterdir()} == {"rig", "other.json", "latin.toml", "study.csv"}
