"""Our forest beside OpenCV's: same model, same pictures, an implementation nobody here wrote."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from opencv_format import write_opencv
from random_forests import random_forest, random_picture

from appliance.simulation.bars.bars import Bar
from appliance.simulation.bars.line_scene import Scene
from appliance.simulation.true_rig import default_rig
from vision.edges.forest.inference import EdgeDetector
from vision.edges.forest.model import shipped_forest

CONTRIB = Path(__file__).parents[2] / ".venv-contrib" / "bin" / "python"


def mill_picture():
    left, _ = Scene(default_rig((640, 480)), seed=3).pair(Bar(180.0), 0)
    return left[:, :, ::-1].astype(np.float32) / np.float32(255)


def pictures():
    noise = np.random.default_rng(6).random((130, 150, 3)).astype(np.float32)
    squares = np.kron(np.indices((6, 9)).sum(axis=0) % 2, np.ones((30, 24))).astype(np.float32)
    return {
        "mill": mill_picture(),
        "mill, grey": np.ascontiguousarray(mill_picture()[:, :, 1]),
        "discs": random_picture(240, 320, seed=11),
        "discs, grey": random_picture(202, 334, seed=12, colours=1),
        "noise": np.rint(noise * 255) / np.float32(255),
        "squares": squares,
        "black": np.zeros((64, 80), np.float32),
        "odd": random_picture(161, 203, seed=13),
    }


def even(picture):
    """OpenCV squeezes odd sides to half; ours repeats the last row or column first, so here both get it."""
    colour = np.repeat(picture[:, :, None], 3, axis=2) if picture.ndim == 2 else picture
    return np.pad(colour, [(0, colour.shape[0] % 2), (0, colour.shape[1] % 2), (0, 0)], mode="edge")


def both(forest, folder):
    """Name of a picture, our strengths, OpenCV's."""
    if not CONTRIB.is_file():
        pytest.fail(f"{CONTRIB}: not there; make .venv-contrib/installed")
    write_opencv(forest, folder / "model.yml")
    files = []
    for name, picture in pictures().items():
        np.save(folder / f"{name}.npy", even(picture))
        files += [folder / f"{name}.npy", folder / f"{name} edges.npy"]
    script = Path(__file__).with_name("opencv_forest.py")
    subprocess.run([CONTRIB, script, folder / "model.yml", *files], check=True, timeout=120)
    detector = EdgeDetector(forest)
    for name, picture in pictures().items():
        theirs = np.load(folder / f"{name} edges.npy")[: picture.shape[0], : picture.shape[1]]
        yield name, detector.strength(np.ascontiguousarray(picture)), theirs


def test_edge_strength_of_the_shipped_forest_is_opencvs(tmp_path):
    for name, ours, theirs in both(shipped_forest(), tmp_path):
        assert np.abs(ours - theirs).max() < 0.02, name
        if theirs.any():
            assert np.corrcoef(ours.ravel(), theirs.ravel())[0, 1] > 0.99999, name


def test_a_forest_of_random_tests_takes_the_same_ways(tmp_path):
    """Neighbouring leaves have nothing in common here: each patch that rounding sends astray shows."""
    for name, ours, theirs in both(random_forest(), tmp_path):
        assert np.abs(ours - theirs).max() < 0.02, name
        assert (ours != theirs).mean() < 0.02, name
