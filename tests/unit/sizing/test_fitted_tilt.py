"""`measure --board-tilt fitted`: the line's rise is found, said, and measured along; without a bar it is refused."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from mill_scenes import perfect_rig

from appliance.cli.main import main
from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from appliance.sizing.stereo.rig_file import save_rig
from appliance.sizing.stereo.settings import SizingSettings
from vision.calibration.rig import BOARD_NAMES

TILT_DEG, DIAMETER_MM = -3.0, 160.0


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A rig in the frame of boards against which the line falls, and two frames of a bar."""
    folder = tmp_path_factory.mktemp("tilted")
    boards = dict.fromkeys(BOARD_NAMES, np.empty((0, 2)))
    rig = replace(perfect_rig(default_rig()), boards=boards)
    axes = rig.along_line(TILT_DEG).line_axes
    left, right = (replace(camera, R=camera.R @ axes) for camera in (rig.left, rig.right))
    save_rig(replace(rig, left=left, right=right), folder / "rig.json")
    scene = Scene(default_rig(), seed=8)
    for kind, bar in (("bar", Bar(DIAMETER_MM, offset_mm=10.0)), ("empty", None)):
        for side in ("left", "right"):
            (folder / kind / side).mkdir(parents=True)
        for frame in range(2):
            for side, picture in zip(("left", "right"), scene.pair(bar, frame), strict=True):
                cv2.imwrite(str(folder / kind / side / f"{frame:06d}.png"), picture)
    return folder


def measure(recording, kind, *more):
    words = ["measure", str(recording / kind), "--rig", str(recording / "rig.json")]
    return main([*words, "--output", str(recording / "out.jsonl"), *more])


def test_the_tilt_is_fitted_said_and_used(recording, capsys):
    assert measure(recording, "bar", "--method", "virtual-board", "--board-tilt", "fitted") == 0
    assert "the line rises by -3.0" in capsys.readouterr().out
    rows = [json.loads(line) for line in (recording / "out.jsonl").read_text().splitlines()]
    for row in rows:
        assert abs(row["diameter_mm"] - DIAMETER_MM) <= row["expanded_uncertainty_mm"]


def test_on_level_boards_a_bar_that_rises_has_no_uncertainty(recording):
    assert measure(recording, "bar", "--method", "virtual-board") == 0
    rows = [json.loads(line) for line in (recording / "out.jsonl").read_text().splitlines()]
    assert all(not row["valid"] or "uncertainty_unknown" in row["reasons"] for row in rows)
    assert all(row["expanded_uncertainty_mm"] is None for row in rows)


def test_without_a_bar_no_tilt_is_fitted(recording, capsys):
    assert measure(recording, "empty", "--board-tilt", "fitted") == 2
    assert "give --board-tilt in degrees" in capsys.readouterr().err


def test_a_tilt_of_the_settings_is_that_of_the_gauge(recording):
    settings = SizingSettings.model_validate(
        {"rig": recording / "rig.json", "board_tilt_deg": TILT_DEG, "ovality_mm": 0}
    )
    gauge = settings.make_gauge(lambda: None)
    pair = [cv2.imread(str(recording / "bar" / side / "000000.png")) for side in ("left", "right")]
    reading, _ = gauge.measure(*pair)
    assert abs(reading.diameter_mm - DIAMETER_MM) <= reading.expanded_uncertainty_mm
    (kept,) = gauge.scale_files
    assert np.allclose(
        json.loads(kept.content)["left"]["R"], json.loads((recording / "rig.json").read_text())["left"]["R"]
    )
