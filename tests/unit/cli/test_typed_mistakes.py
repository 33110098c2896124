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
    ("gauge-study a\nb", "a\\nb: No such file"),
    ("gauge-study other.json", "has no column bar; it needs the columns bar, condition, diameter_mm"),
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "rig" / "calibration").mkdir(parents=True)
    (tmp_path / "rig" / "board.json").write_text(json.dumps({"squares": [8, 5], "square_mm": 50}))
    (tmp_path / "other.json").write_text('{"a":\n1}\n')
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
    assert not [file for file in folder.iterdir() if file.name not in {"rig", "other.json"}]
