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


def test_half_a_turn_shows_only_on_a_board_with_one_even_and_one_odd_side():
    def shows(*squares):
        return Board.from_json(json.dumps(VALUES | {"squares": squares})).half_turn_shows

    assert shows(8, 5)
    assert shows(9, 6)
    assert not shows(9, 7)
    assert not shows(10, 6)


@pytest.mark.parametrize("key", sorted(VALUES.keys() - {"response"}))
def test_a_missing_key_is_named(key):
    with pytest.raises(ValueError, match=f"^{key}: missing"):
        Board.from_json(json.dumps({name: value for name, value in VALUES.items() if name != key}))


def test_a_response_that_nobody_knows_may_be_left_out():
    untold = {name: value for name, value in VALUES.items() if name != "response"}
    assert Board.from_json(json.dumps(untold)).response is None


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("squares", [5, 8]),
        ("squares", [8, 8]),
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
