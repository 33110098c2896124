"""`hotgauge capture` with cameras on a network: what it writes calibrates them, and what it says is true."""

import subprocess
import sys
from pathlib import Path

import gige_boards
import gige_cameras
import numpy as np
import pytest
from network_cameras import rtsp_camera
from running import HOTGAUGE
from shown_boards import HEIGHT_WORDS, capture_poses, write_boards

from appliance.cameras.recording.pairs import Recording
from vision.calibration.rig import Rig

pytestmark = pytest.mark.waiting

POSES = 7
RATE_HZ = 10


@pytest.fixture(scope="module")
def boards(tmp_path_factory):
    folder = tmp_path_factory.mktemp("boards")
    return folder, write_boards(folder, POSES)


def capture(*words, config):
    done = subprocess.run(
        [HOTGAUGE, "capture", *map(str, words), "--config", str(config)],
        capture_output=True, text=True, timeout=90, check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def calibrated(rig_folder, tmp_path):
    output = tmp_path / "rig.json"
    done = subprocess.run(
        [HOTGAUGE, "calibrate", rig_folder, "--output", output],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return Rig.from_json(output.read_text())


def assert_is_the_true_rig(rig, true_rig):
    assert rig.has_world
    for camera, true_camera, column in ((rig.left, true_rig.left, 0), (rig.right, true_rig.right, 15)):
        u_px = float(np.sqrt(rig.covariance[column, column]))
        assert abs(camera.K[0, 0] - true_camera.K[0, 0]) < 4 * u_px
        assert u_px < 0.01 * camera.K[0, 0]


def test_boards_before_rtsp_cameras_become_a_rig_folder_that_calibrates_them(boards, tmp_path):
    folder, true_rig = boards
    options = {"size": "800x600", "rate": RATE_HZ}
    with (
        rtsp_camera(show=(folder / "00" / "left", 1), **options) as left,
        rtsp_camera(show=(folder / "00" / "right", 1), **options) as right,
    ):
        config = tmp_path / "streams.toml"
        config.write_text(
            f'[sizing.camera]\nkind = "stream"\nleft = "{left.address}"\nright = "{right.address}"\n'
            "[sizing.liveness]\napart_max_us = 50000\n"
        )
        rig_folder = tmp_path / "rig"

        def show(pose):
            for camera, side in ((left, "left"), (right, "right")):
                camera.tell(f"show {folder / pose / side} 1")

        said = capture_poses(rig_folder, config, POSES, show)
        assert "stopped" in said
        assert f"next: hotgauge capture registration --output {rig_folder}" in said
        for height in ("low", "high"):
            show(height)
            words = ["registration", "--output", rig_folder, *HEIGHT_WORDS, "--height", height]
            assert f"{height} board: stored" in capture(*words, config=config)
        recorded = capture("recording", "--output", tmp_path / "recording", "--seconds", 1, config=config)
    assert "frames of 800 x 600 pixels" in recorded
    assert {left.coding.samples for _, left, _ in Recording(tmp_path / "recording")} == {"luma"}
    assert_is_the_true_rig(calibrated(rig_folder, tmp_path), true_rig)


def test_boards_before_gige_cameras_become_a_rig_folder_that_calibrates_them(boards, tmp_path):
    folder, true_rig = boards
    script = Path(gige_boards.__file__)
    said = gige_cameras.in_own_network(sys.executable, script, folder, tmp_path, timeout=150)
    assert "low board: stored" in said
    assert "high board: stored" in said
    assert {left.coding.samples for _, left, _ in Recording(tmp_path / "recording")} == {"grey"}
    assert_is_the_true_rig(calibrated(tmp_path / "rig", tmp_path), true_rig)
