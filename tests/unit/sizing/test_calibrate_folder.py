"""What `calibrate` makes of the pictures of a rig folder beside the calibration itself."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from appliance.sizing.stereo import calibrate_folder

CORNERS = np.zeros((28, 2))


@pytest.mark.parametrize(
    "names", [("left_07.png", "right_07.png"), ("LEFT-7.PNG", "Right 7.jpeg"), ("a7.png", "b7.png")]
)
def test_the_response_is_measured_through_the_camera_that_made_the_picture(monkeypatch, names):
    through = {}

    def board_edges(picture, camera, *_):
        through[picture.name] = camera

    monkeypatch.setattr(calibrate_folder, "read_picture", lambda path, _: SimpleNamespace(name=path.name, coding=None))
    monkeypatch.setattr(calibrate_folder, "board_edges", board_edges)
    monkeypatch.setattr(calibrate_folder, "measure_response", len)
    monkeypatch.setattr(calibrate_folder, "chosen_response", lambda _, edges: edges)
    rig, board = SimpleNamespace(left="left camera", right="right camera"), SimpleNamespace(response=None)
    paths = {"07": dict(zip(("left", "right"), map(Path, names), strict=True)), "08": {"left": Path("lost.png")}}
    count = calibrate_folder._response(rig, board, paths, {"07": (CORNERS, CORNERS), "08": (None, None)}, None)
    assert count == 2
    assert through == dict(zip(names, ("left camera", "right camera"), strict=True))
