"""Commands that cannot do what they were asked for say so in one sentence, before anything is served or written."""

import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from running import HOTGAUGE, free_port

from appliance.cameras.simulated.pairs import MillSource
from appliance.cameras.simulated.rig import mill_rig
from appliance.sizing.stereo.rig_file import save_rig

pytestmark = pytest.mark.waiting

SIDES = ("left", "right")


def refusal(*words: str | Path) -> str:
    """The sentence of a command that must end by itself with exit code 2."""
    ended = subprocess.run([HOTGAUGE, *words], capture_output=True, text=True, timeout=30, check=False)
    assert ended.returncode == 2, ended
    assert ended.stdout == ""
    assert ended.stderr.startswith("hotgauge: ")
    assert ended.stderr.count("\n") == 1, ended.stderr
    return ended.stderr


@pytest.fixture(scope="module")
def rig(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("rig") / "rig.json"
    save_rig(mill_rig(MillSource(seed=1, rate_hz=0)), path)
    return path


@pytest.fixture
def config(tmp_path) -> Path:
    """Settings with a port of their own."""
    file = tmp_path / "hotgauge.toml"
    file.write_text(f"[plc]\nport = {free_port()}\n")
    return file


def recording(folder: Path, columns: int = 800, rows: int = 600) -> Path:
    for side in SIDES:
        (folder / side).mkdir(parents=True)
        for number in range(2):
            picture = np.random.default_rng(number).integers(0, 50, (rows, columns, 3), np.uint8)
            cv2.imwrite(str(folder / side / f"{number:06d}.jpg"), picture)
    return folder


@pytest.fixture
def taken_port() -> Iterator[int]:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        yield listener.getsockname()[1]


def test_a_wrong_key_refuses_the_start_and_is_named(tmp_path):
    file = tmp_path / "hotgauge.toml"
    file.write_text("[plc]\nprot = 5020\n")
    said = refusal("run", "--config", file)
    assert str(file) in said
    assert "plc.prot" in said
    assert "plc.port" in said


def test_a_port_that_is_taken_refuses_the_start_and_is_named(tmp_path, taken_port):
    file = tmp_path / "hotgauge.toml"
    file.write_text(f"[plc]\nport = {taken_port}\n")
    said = refusal("run", "--config", file)
    assert f"127.0.0.1:{taken_port}" in said
    assert "plc.port" in said


def test_a_missing_recording_refuses_the_start_and_is_named(tmp_path, rig, config):
    assert str(tmp_path / "absent") in refusal("replay", tmp_path / "absent", "--rig", rig, "--config", config)


def test_a_missing_rig_refuses_the_start_and_is_named(tmp_path, config):
    said = refusal("replay", recording(tmp_path / "scene"), "--rig", tmp_path / "absent.json", "--config", config)
    assert str(tmp_path / "absent.json") in said


def test_a_recording_without_a_rig_refuses_the_start(tmp_path, config):
    scene = recording(tmp_path / "scene")
    config.write_text(config.read_text() + f'[sizing.camera]\nkind = "recording"\npath = "{scene}"\n')
    assert "sizing.rig" in refusal("run", "--config", config)


def test_a_truncated_picture_refuses_the_start_and_is_named(tmp_path, rig, config):
    scene = recording(tmp_path / "scene")
    broken = scene / "right" / "000000.jpg"
    broken.write_bytes(broken.read_bytes()[:5000])
    assert str(broken) in refusal("replay", scene, "--rig", rig, "--config", config)


def test_a_rig_for_pictures_of_another_size_refuses_the_start_with_both_sizes(tmp_path, rig, config):
    scene = recording(tmp_path / "scene", columns=640, rows=480)
    said = refusal("replay", scene, "--rig", rig, "--config", config)
    assert str(rig) in said
    assert "800 x 600" in said
    assert "640 x 480" in said


def test_measure_leaves_no_file_behind_when_a_picture_is_truncated(tmp_path, rig):
    scene = recording(tmp_path / "scene")
    broken = scene / "left" / "000001.jpg"
    broken.write_bytes(broken.read_bytes()[:5000])
    (tmp_path / "output").mkdir()
    said = refusal("measure", scene, "--rig", rig, "--output", tmp_path / "output" / "out.jsonl")
    assert str(broken) in said
    assert list((tmp_path / "output").iterdir()) == []


def test_a_measure_that_is_interrupted_leaves_no_file_behind(tmp_path, rig):
    scene = recording(tmp_path / "scene")
    for number in range(2, 300):
        for side in SIDES:
            shutil.copy(scene / side / "000000.jpg", scene / side / f"{number:06d}.jpg")
    (tmp_path / "output").mkdir()
    words = [HOTGAUGE, "measure", scene, "--rig", rig, "--output", tmp_path / "output" / "out.jsonl"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        until = time.monotonic() + 20
        while not list((tmp_path / "output").iterdir()) and time.monotonic() < until:
            time.sleep(0.05)
        process.send_signal(2)
        assert process.wait(10) == 130
        assert process.stderr.read() == ""
    assert list((tmp_path / "output").iterdir()) == []
