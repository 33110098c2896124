"""The board's corners in mm, and the boards that are refused."""

import json

import numpy as np
import pytest

from vision.calibration.checkerboard import Board

VALUES = {
    "squares": [8, 5],
    "square_mm": 50.0,
    "square_u_mm": 0.01,
    "low_mm": 0.0,
    "high_mm": 200.0,
    "height_u_mm": 0.1,
    "response": "gamma 2.2",
}


def test_corners_run_along_the_long_side_from_minus_x_plus_y_about_the_centre():
    corners = Board.from_json(json.dumps(VALUES)).corners_mm
    assert corners.shape == (28, 3)
    assert corners[0].tolist() == [-150.0, 75.0, 0.0]
    assert corners[6].tolist() == [150.0, 75.0, 0.0]
    assert corners[7].tolist() == [-150.0, 25.0, 0.0]
    assert corners[27].tolist() == [150.0, -75.0, 0.0]
    assert np.array_equal(corners.mean(axis=0), np.zeros(3))


@pytest.mark.parametrize(
    ("squares", "hidden"), [([8, 5], (0,)), ([9, 6], (0,)), ([9, 7], (0, 2)), ([8, 8], (0, 2)), ([7, 7], (0, 1, 2, 3))]
)
def test_turns_that_colours_do_not_show_follow_from_the_squares(squares, hidden):
    board = Board.from_json(json.dumps(VALUES | {"squares": squares}))
    assert board.hidden_turns == hidden
    column, row = np.meshgrid(range(squares[0]), range(squares[1]))
    colours = (column + row) % 2
    same = [turn for turn in board.grid_turns if np.array_equal(np.rot90(colours, turn), colours)]
    assert tuple(same) == hidden


@pytest.mark.parametrize("key", ["squares", "square_mm"])
def test_a_missing_key_is_named(key):
    with pytest.raises(ValueError, match=f"^{key}: missing"):
        Board.from_json(json.dumps({name: value for name, value in VALUES.items() if name != key}))


def test_a_response_that_nobody_knows_may_be_left_out():
    untold = {name: value for name, value in VALUES.items() if name != "response"}
    assert Board.from_json(json.dumps(untold)).response is None


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("squares", [3, 3]),
        ("squares", [101, 8]),
        ("low_mm", None),
        ("squares", [8]),
        ("squares", [8, 2]),
        ("squares", "8x5"),
        ("square_mm", 0.0),
        ("square_mm", "50"),
        ("square_u_mm", -0.01),
        ("height_u_mm", None),
        ("high_mm", 0.0),
        ("response", "log"),
    ],
)
def test_a_wrong_value_is_refused_with_its_key(key, value):
    with pytest.raises(ValueError, match=f"^{key}: "):
        Board.from_json(json.dumps(VALUES | {key: value}))
