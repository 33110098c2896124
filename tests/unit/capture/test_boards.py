"""`hotgauge capture boards` and `registration` before the simulated mill's cameras.

That a folder calibrates its cameras is tried with cameras on a network: `test_captured_boards`.
"""

import json

import pytest

from appliance.cameras.recording.picture_file import read_picture
from appliance.cameras.simulated import boards
from appliance.capture.boards import judged_pairs, poses
from appliance.cli.main import main

HELD_S = 0.1
BOARD = ["--squares", "8x5", "--mm", "50", "--u-mm", "0.01"]
HEIGHTS = ["--low-mm", "0", "--high-mm", "200", "--height-u-mm", "0.1"]


@pytest.fixture
def mill(tmp_path, monkeypatch):
    """Words of a settings file for what the mill's cameras see."""
    monkeypatch.setattr(boards, "HOLD_S", HELD_S)
    monkeypatch.setattr(judged_pairs, "STILL_TIME_S", 0.0)
    monkeypatch.setattr(poses, "COVERED_LEAST", 0.1)  # fewer poses are enough: drawing takes half a second each
    monkeypatch.setattr(poses, "TILT_LEAST_DEG", 10.0)

    def config(shows):
        path = tmp_path / f"{shows}.toml"
        path.write_text(f'[sizing.camera]\nkind = "mill"\nshows = "{shows}"\nrate_hz = 20.0\n')
        return ["--config", str(path)]

    return config


def test_poses_are_stored_until_they_are_enough_and_a_folder_is_taken_up_again(mill, tmp_path, capsys):
    folder = tmp_path / "rig"
    words = ["capture", "boards", "--output", str(folder), "--within", "40", *mill("boards")]
    assert main([*words, *BOARD, "--poses", "2"]) == 0
    said = capsys.readouterr().out
    assert "pose 00: edges " in said
    assert "missing: nothing" in said
    pictures = sorted(path.name for path in (folder / "calibration").iterdir())
    assert pictures[:2] == ["left_00.png", "left_01.png"]
    assert len(pictures) == 2 * said.count("\npose ")
    assert read_picture(folder / "calibration" / "left_01.png").size == (800, 600)
    assert json.loads((folder / "board.json").read_text()) == {
        "squares": [8, 5],
        "square_mm": 50.0,
        "square_u_mm": 0.01,
    }
    assert main([*words, "--poses", "2"]) == 0  # the same poses come again: they are there already, and enough
    assert f"{len(pictures) // 2} of 2 poses" in capsys.readouterr().out


def test_a_board_that_does_not_move_is_one_pose_and_that_is_too_few(mill, tmp_path, capsys):
    words = ["capture", "boards", "--output", str(tmp_path / "rig"), "--within", "4", *BOARD, *mill("low")]
    assert main(words) == 2
    assert "1 of the 6 poses that a calibration needs were stored within 4 s" in capsys.readouterr().err


def test_a_board_that_lies_where_it_lay_is_not_the_other_height(mill, tmp_path, capsys, monkeypatch):
    words = ["capture", "registration", "--output", str(tmp_path / "rig"), *BOARD, *HEIGHTS, *mill("low")]
    assert main([*words, "--height", "low"]) == 0
    monkeypatch.setattr("appliance.capture.boards.take.REGISTRATION_TIME_S", 3.0)
    assert main([*words, "--height", "high"]) == 2
    assert "it lies where it lay for the low one" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "squares and square_mm are not known; give --squares 8x5 --mm 50, as printed"),
        (["--squares", "8x5", "--mm", "-1"], "square_mm: a number above zero is needed"),
        (["--squares", "2x2", "--mm", "50"], "squares: "),
    ],
)
def test_a_board_that_nobody_describes_is_one_sentence(words, said, mill, tmp_path, capsys):
    assert main(["capture", "boards", "--output", str(tmp_path / "rig"), *words, *mill("boards")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line


def test_another_board_is_not_mixed_into_a_folder(mill, tmp_path, capsys):
    (tmp_path / "board.json").write_text('{"squares": [8, 5], "square_mm": 50}')
    words = ["capture", "boards", "--output", str(tmp_path), "--squares", "9x6", *mill("boards")]
    assert main(words) == 2
    assert "squares is [8, 5] there, and [9, 6] now; give a new folder" in capsys.readouterr().err


def test_a_registration_board_of_unknown_height_is_not_taken(mill, tmp_path, capsys):
    words = ["capture", "registration", "--output", str(tmp_path / "rig"), *BOARD, "--low-mm", "0", *mill("high")]
    assert main([*words, "--height", "high"]) == 2
    assert "high_mm is not known; give --high-mm, its face above the rollers in mm" in capsys.readouterr().err


def test_a_pose_counts_once_the_board_has_been_still_for_half_a_second(mill, tmp_path, capsys, monkeypatch):
    """Poses that are held for two pictures, a tenth of a second: two streams may show them at different moments."""
    monkeypatch.setattr(judged_pairs, "STILL_TIME_S", 0.5)
    words = ["capture", "boards", "--output", str(tmp_path / "rig"), "--within", "4", *BOARD, *mill("boards")]
    assert main(words) == 2
    assert "0 of the 6 poses" in capsys.readouterr().err
