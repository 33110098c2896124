"""What a rig folder holds, by names as people and cameras give them."""

import json

import pytest

from appliance.sizing.stereo.rig_folder import find_pictures, read_board
from vision.calibration.acceptance import CalibrationError

BOARD = {"squares": [8, 5], "square_mm": 50.0}


@pytest.fixture
def folder(tmp_path):
    for name in ("calibration", "registration"):
        (tmp_path / name).mkdir()
    return tmp_path


def put(folder, *names):
    for name in names:
        (folder / name).touch()


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("left_7.jpg", "right_07.jpg"),
        ("left07.png", "right07.png"),
        ("LEFT-007.PNG", "Right 7.jpeg"),
        ("left_1700000000123.jpg", "right_1700000000123.jpg"),
    ],
)
def test_side_and_number_make_a_pair_however_they_are_written(folder, left, right):
    put(folder / "calibration", left, right)
    found = find_pictures(folder)
    ((pose, sides),) = found.poses.items()
    assert int(pose) in {7, 1_700_000_000_123}
    assert {side: path.name for side, path in sides.items()} == {"left": left, "right": right}
    assert found.notes == ()


def test_poses_are_in_the_order_of_their_numbers(folder):
    put(folder / "calibration", *(f"{side}_{number}.png" for side in ("left", "right") for number in (10, 9, 100)))
    assert list(find_pictures(folder).poses) == ["09", "10", "100"]


def test_pictures_may_lie_in_the_folder_itself(tmp_path):
    put(tmp_path, "left01.jpg", "right01.jpg")
    assert list(find_pictures(tmp_path).poses) == ["01"]


def test_a_picture_without_its_partner_and_one_with_another_name_are_said(folder):
    put(
        folder / "calibration",
        "left_00.png",
        "right_00.png",
        "left_01.png",
        "IMG_2041.jpg",
        "._left_00.png",
        "notes.txt",
    )
    put(folder / "registration", "Left_Low.png")
    found = find_pictures(folder)
    assert set(found.poses["low"]) == {"left"}
    alone, unused = found.notes
    assert alone.startswith("left_01.png, Left_Low.png: no picture of the other camera")
    assert unused.startswith("IMG_2041.jpg: not used")


def test_of_many_pictures_that_are_not_used_the_first_ones_are_named_and_the_others_counted(folder):
    put(folder / "calibration", "left_00.png", "right_00.png", *(f"IMG_{number}.jpg" for number in range(7)))
    (unused,) = find_pictures(folder).notes
    assert unused.startswith("IMG_0.jpg, IMG_1.jpg, IMG_2.jpg, IMG_3.jpg, 3 more: not used")


def test_a_side_without_any_picture_is_named(folder):
    put(folder / "calibration", "left_00.png", "left_01.png")
    with pytest.raises(CalibrationError, match="no pictures right_00"):
        find_pictures(folder)


def test_two_pictures_of_one_pose_and_side_are_named(folder):
    put(folder / "calibration", "left_7.png", "left_07.png", "right_7.png")
    with pytest.raises(CalibrationError, match=r"a second left picture of pose 07"):
        find_pictures(folder)


def test_options_alone_describe_a_board(tmp_path):
    assert read_board(tmp_path / "board.json", BOARD).squares == (8, 5)
    with pytest.raises(CalibrationError, match="no such file; describe the board in it, or give --squares"):
        read_board(tmp_path / "board.json", {"square_mm": 50.0})


def test_what_is_left_out_is_assumed_and_said(tmp_path):
    (tmp_path / "board.json").write_bytes(b"\xef\xbb\xbf" + json.dumps({**BOARD, "squares": [5, 8]}).encode())
    board = read_board(tmp_path / "board.json", {})
    assert board.squares == (8, 5)
    assert board.square_u_mm == pytest.approx(0.15)  # 0.3 % of an unmeasured print
    assert board.low_mm is None
    assert [(one.text.partition(" ")[0], one.of_world) for one in board.assumptions] == [
        ("square_u_mm", False),
        ("height_u_mm", True),
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"squares": [8, 5], "sqare_mm": 50}', "sqare_mm: unknown; did you mean square_mm"),
        ('{"squares": [1000000000, 5], "square_mm": 50}', "squares: two whole numbers"),
        ('{"squares": [800, 5], "square_mm": 50}', "squares: 4 x 3 to 100 x 100"),
        ('{"squares": [8, 5], "square_mm": 1' + "0" * 400 + "}", "401 digits"),
        ('{"squares": [8, 5], "square_mm": 1' + "0" * 6000 + "}", "digits"),
        ('{"squares": [8, 5], "square_mm": Infinity}', "Infinity is no number"),
        ('{"squares": [8, 5], "square_mm": 50, "low_mm": null}', "low_mm: a finite number"),
        ("[" * 100_000, "not a readable JSON object"),
        ("[1, 2]", "not a readable JSON object"),
    ],
)
def test_a_board_that_cannot_be_is_one_sentence_with_its_key(tmp_path, text, said):
    (tmp_path / "board.json").write_text(text)
    with pytest.raises(CalibrationError, match=r"board\.json") as caught:
        read_board(tmp_path / "board.json", {})
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
