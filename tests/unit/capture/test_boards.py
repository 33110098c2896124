"""`hotgauge capture boards` and `registration` before the simulated mill's cameras: the folder calibrates them."""

import json

import numpy as np
import pytest

from appliance.cameras.recording.picture_file import read_picture
from appliance.cameras.simulated import boards
from appliance.capture.boards import poses
from appliance.cli.main import main
from appliance.simulation.true_rig import default_rig
from vision.calibration.rig import Rig

HELD_S = 0.1
BOARD = ["--squares", "8x5", "--mm", "50", "--u-mm", "0.01"]
HEIGHTS = ["--low-mm", "0", "--high-mm", "200", "--height-u-mm", "0.1"]


@pytest.fixture
def mill(tmp_path, monkeypatch):
    """Words of a settings file for what the mill's cameras see."""
    monkeypatch.setattr(boards, "HOLD_S", HELD_S)
    monkeypatch.setattr(poses, "COVERED_LEAST", 0.1)  # fewer poses are enough: drawing takes half a second each
    monkeypatch.setattr(poses, "TILT_LEAST_DEG", 10.0)

    def config(shows):
        path = tmp_path / f"{shows}.toml"
        path.write_text(f'[sizing.camera]\nkind = "mill"\nshows = "{shows}"\nrate_hz = 20.0\n')
        return ["--config", str(path)]

    return config


def test_a_captured_folder_calibrates_to_the_true_rig(mill, tmp_path, capsys):
    folder = tmp_path / "rig"
    words = ["--output", str(folder)]
    assert main(["capture", "boards", *words, *BOARD, "--poses", "7", "--within", "45", *mill("boards")]) == 0
    said = capsys.readouterr().out
    assert "pose 00: edges " in said
    assert f"{folder}: 7 poses, missing: nothing" in said
    assert main(["capture", "registration", *words, *HEIGHTS, "--height", "low", *mill("low")]) == 0
    assert main(["capture", "registration", *words, "--height", "high", *mill("high")]) == 0
    assert json.loads((folder / "board.json").read_text())["squares"] == [8, 5]
    output = tmp_path / "rig.json"
    assert main(["calibrate", str(folder), "--output", str(output)]) == 0
    rig, true_rig = Rig.from_json(output.read_text()), default_rig()
    assert rig.has_world
    for camera, true_camera, column in ((rig.left, true_rig.left, 0), (rig.right, true_rig.right, 15)):
        u_px = float(np.sqrt(rig.covariance[column, column]))
        assert abs(camera.K[0, 0] - true_camera.K[0, 0]) < 4 * u_px


def test_a_pose_is_stored_once_and_a_folder_is_taken_up_again(mill, tmp_path, capsys):
    folder = tmp_path / "rig"
    words = ["capture", "boards", "--output", str(folder), "--within", "5"]
    assert main([*words, *BOARD, *mill("low")]) == 2  # one pose, since the board does not move
    assert "1 poses within 5 s, and a calibration needs 6" in capsys.readouterr().err
    assert [path.name for path in (folder / "calibration").iterdir()] in (
        ["left_00.png", "right_00.png"], ["right_00.png", "left_00.png"],
    )  # fmt: skip
    assert main([*words, *mill("high")]) == 2
    assert ": 1 poses, 15 are wanted" in capsys.readouterr().out  # what it held
    assert (folder / "calibration" / "left_01.png").is_file()
    assert read_picture(folder / "calibration" / "left_01.png").size == (800, 600)


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
